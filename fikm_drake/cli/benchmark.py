"""`fikm-drake benchmark`: costs and success, ours beside others'."""

import argparse

from fikm_drake.cli.shared import OK, positive_count, print_json, progress
from fikm_drake.experiments.benchmarks.registry import BENCHMARKS


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
        parser.add_argument("--json", action="store_true", help="print the rows as JSON")
        parser.set_defaults(run=_run, name=name, entry=entry)


def _run(options: argparse.Namespace) -> int:
    table = options.entry.table(options.count, progress())
    if options.json:
        # A benchmark without rows gives its text.
        rows = getattr(table, "rows", table.splitlines())
        entry = options.entry
        print_json({"benchmark": options.name, entry.count: options.count, "rows": rows})
    else:
        print(table)
    return OK
