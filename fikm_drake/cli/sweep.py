"""`fikm-drake sweep` and `fikm-drake compare`: many runs, and two logs beside each other."""

import argparse
import logging
import sys
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from multiprocessing import active_children, get_context
from pathlib import Path

from fikm_drake.cli.shared import FAILED, OK, positive_count, print_json, progress
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.simulation.compare import compare
from fikm_drake.simulation.plot_sweep import plot_sweep
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.sweep_runs import load_grid, sweep


def add_sweep(commands: "argparse._SubParsersAction") -> None:
    """Add the commands."""
    parser = commands.add_parser(
        "sweep", help="run every combination of options; a sweep that was stopped goes on"
    )
    parser.add_argument(
        "file", metavar="FILE.yaml", help="base: a scenario, grid: values by dotted path"
    )
    parser.add_argument("--jobs", type=positive_count, default=1, help="processes (1)")
    parser.add_argument("--folder", metavar="FOLDER", help="keep logs and sweep.csv there")
    parser.add_argument("--csv", metavar="SWEEP.csv", help="write the table")
    parser.add_argument(
        "--plot", metavar="SWEEP.png", help="write a heat map, error against motion"
    )
    parser.add_argument("--json", action="store_true", help="print the table as JSON")
    parser.set_defaults(run=_sweep)

    two = commands.add_parser("compare", help="compare two logs; exit code 1 if they differ")
    two.add_argument("first", metavar="A.npz")
    two.add_argument("second", metavar="B.npz")
    two.add_argument("--plot", metavar="BOTH.png", help="write a picture of both")
    two.set_defaults(run=_compare)


def _sweep(options: argparse.Namespace) -> int:
    grid = load_grid(options.file)
    for path in (options.csv, options.plot):
        if path is not None and not Path(path).parent.is_dir():
            print(f"fikm-drake: cannot write {path}: there is no such folder", file=sys.stderr)
            return FAILED
    several = options.jobs > 1
    pool = (
        ProcessPoolExecutor(options.jobs, get_context("spawn"), initializer=_quiet_worker)
        if several
        else nullcontext()
    )
    table = None
    try:
        with pool as executor, quiet_drake(), _children_end():
            table = sweep(grid, executor, folder=options.folder, progress=progress())
    except BrokenExecutor:
        kept = f"; what is done is in {options.folder}: run it again" if options.folder else ""
        print(f"fikm-drake: a worker was killed{kept}", file=sys.stderr)
    if table is None:
        return FAILED
    if options.csv is not None:
        table.to_csv(options.csv)
    if options.plot is not None:
        plot_sweep(table, options.plot)
    if options.json:
        print_json([asdict(row) for row in table.rows])
    else:
        print(table)
    return FAILED if any(row.error for row in table.rows) else OK


@contextmanager
def _children_end() -> Iterator[None]:
    """Where a person or the system ends a sweep its workers end too; their logs stay readable."""
    try:
        yield
    except KeyboardInterrupt:
        for child in active_children():
            child.terminate()
        raise


def _quiet_worker() -> None:
    """A worker's standard output is this process's, which is nowhere; this is for its log messages."""
    logging.getLogger("drake").setLevel(logging.ERROR)


def _compare(options: argparse.Namespace) -> int:
    found = compare(RunLog.load(options.first), RunLog.load(options.second))
    print(found)
    if options.plot is not None:
        found.plot(options.plot)
    return OK if found.same else FAILED
