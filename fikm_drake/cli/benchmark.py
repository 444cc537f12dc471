"""`fikm-drake benchmark`: costs and success, ours beside others'."""

import argparse
from pathlib import Path

from fikm_drake.cli.shared import OK, positive_count, print_json, progress
from fikm_drake.experiments.benchmarks.benchmark_page import head, rows_as_markdown, section
from fikm_drake.experiments.benchmarks.registry import BENCHMARKS
from fikm_drake.files import whole_file


def add_benchmark(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    benchmark = commands.add_parser("benchmark", help="measure costs and success")
    what = benchmark.add_subparsers(required=True, metavar="WHAT")
    for name, entry in BENCHMARKS.items():
        parser = what.add_parser(name, help=entry.help)
        count, default = entry.count, entry.default
        parser.add_argument(
            f"--{count}",
            type=positive_count,
            default=default,
            dest="count",
            help=f"how many ({default})",
        )
        form = parser.add_mutually_exclusive_group()
        form.add_argument("--json", action="store_true", help="print the rows as JSON")
        form.add_argument("--markdown", action="store_true", help="print the rows as Markdown")
        parser.set_defaults(run=_run, name=name, entry=entry)
    parser = what.add_parser("all", help="every benchmark, one after the other")
    parser.add_argument("--markdown", action="store_true", help="print the rows as Markdown")
    parser.add_argument(
        "--page", type=Path, metavar="FILE", help="write them as a page of Markdown"
    )
    parser.add_argument("--only", nargs="+", choices=BENCHMARKS, metavar="NAME", help="these only")
    parser.add_argument(
        "--count", type=positive_count, help="rounds (poses, …) of each; by default its own number"
    )
    parser.set_defaults(run=_run_all)


def _run(options: argparse.Namespace) -> int:
    table = options.entry.table(options.count, progress())
    if options.json:
        # A benchmark without rows gives its text.
        rows = getattr(table, "rows", table.splitlines())
        entry = options.entry
        print_json({"benchmark": options.name, entry.count: options.count, "rows": rows})
    elif options.markdown:
        print(rows_as_markdown(table))
    else:
        print(table)
    return OK


def _run_all(options: argparse.Namespace) -> int:
    if (
        options.page and not options.page.resolve().parent.is_dir()
    ):  # told before, not after an hour
        raise FileNotFoundError(f"there is no folder {options.page.resolve().parent}")
    parts = [head()]
    print(parts[0], flush=True)
    for name in options.only or BENCHMARKS:
        count = options.count or BENCHMARKS[name].default
        table = BENCHMARKS[name].table(count, progress())
        parts.append(section(name, count, table))
        as_text = f"fikm-drake benchmark {name} --{BENCHMARKS[name].count} {count}\n{table}"
        print(f"\n{parts[-1] if options.markdown or options.page else as_text}", flush=True)
    if options.page:
        with whole_file(options.page) as file:
            file.write(("\n\n".join(parts) + "\n").encode("utf-8"))
    return OK
