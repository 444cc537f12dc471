"""`fikm-drake fuzz`: random cases, and what they violate."""

import argparse

from fikm_drake.cli.shared import FAILED, OK, positive_count, progress
from fikm_drake.experiments.fuzz.fuzz_cases import fuzz


def add_fuzz(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "fuzz", help="random arms, tasks, laws, inputs; exit code 1 if anything is violated"
    )
    parser.add_argument(
        "--cases", type=positive_count, default=1000, metavar="N", help="how many (1000)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of the cases (0)")
    parser.add_argument(
        "--first", type=int, default=0, metavar="I", help="index of the first case (0)"
    )
    parser.set_defaults(run=_fuzz)


def _fuzz(options: argparse.Namespace) -> int:
    report = fuzz(options.cases, seed=options.seed, first=options.first, progress=progress())
    print(report)
    return FAILED if report.violations else OK
