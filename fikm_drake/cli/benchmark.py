"""`fikm-drake benchmark`: costs and success, ours beside others'."""

import argparse
import dataclasses
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version

from fikm_drake.cli.shared import OK, positive_count, print_json, progress
from fikm_drake.experiments.benchmarks.registry import BENCHMARKS, Benchmark
from fikm_drake.kinematics.native.kernel import kernel_description


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
        print(_markdown(table))
    else:
        print(table)
    return OK


def _run_all(options: argparse.Namespace) -> int:
    numpy_and_drake = ", ".join(f"{name} {_version(name)}" for name in ("drake", "numpy"))
    print(f"Python {platform.python_version()}, {numpy_and_drake}, {kernel_description()}")
    for name in options.only or BENCHMARKS:
        entry: Benchmark = BENCHMARKS[name]
        count = options.count or entry.default
        table = entry.table(count, progress())
        command = f"fikm-drake benchmark {name} --{entry.count} {count}"
        if options.markdown:
            print(f"\n{entry.help[0].upper()}{entry.help[1:]} (`{command}`):\n\n{_markdown(table)}")
        else:
            print(f"\n{command}\n{table}", flush=True)
    return OK


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:  # Drake built from source
        return "of unknown version"


def _markdown(table: str) -> str:
    """The rows of a benchmark as Markdown, a table for each kind of row; its text if it has none."""
    rows = [_fields(row) for row in getattr(table, "rows", ())]
    if not rows:
        return f"```text\n{table}\n```"
    parts, names = [], None
    for row in rows:
        if list(row) != names:
            names = list(row)
            heads = [name.replace("_", " ") for name in names]
            parts += ["", _line(heads), _line(["---"] * len(heads))]
        parts.append(_line([_cell(value) for value in row.values()]))
    return "\n".join(parts[1:])


def _fields(row: object) -> dict[str, object]:
    if isinstance(row, Mapping):
        return {str(key): value for key, value in row.items()}
    if dataclasses.is_dataclass(row) and not isinstance(row, type):
        return {item.name: getattr(row, item.name) for item in dataclasses.fields(row)}
    return {"": row}


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{_cell(key)}: {_cell(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(_cell, value))
    return str(value).replace("|", "\\|")
