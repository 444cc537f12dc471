"""`fikm-drake benchmark`: costs and success, ours beside others'."""

import argparse

from fikm_drake.cli.shared import OK, positive_count, progress
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
        parser.set_defaults(run=_run, entry=entry)


def _run(options: argparse.Namespace) -> int:
    print(options.entry.table(options.count, progress()))
    return OK
