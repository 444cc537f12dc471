"""`fikm-drake run`: a scenario to its errors, log, picture and page."""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

from pydrake.common.yaml import yaml_load
from pydrake.geometry import Meshcat

from fikm_drake.cli.shared import FAILED, OK, code_of, print_json, progress, write_files
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.simulation.plot_log import plot_log
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import Scenario, load_scenario
from fikm_drake.simulation.simulate import SimulationStopped, simulate
from fikm_drake.simulation.write_html import write_html

PATIENCE = 30.0
"""A run with --meshcat begins after this time though nobody watches [s]."""


def add_run(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    run = commands.add_parser("run", help="run a scenario and print its errors")
    run.add_argument("scenario", help="name (see `fikm-drake models`) or path of a .yaml file")
    run.add_argument("--log", metavar="RUN.npz", help="write the log")
    run.add_argument("--csv", metavar="RUN.csv", help="write the log as a table")
    run.add_argument("--plot", metavar="RUN.png", help="write a picture")
    run.add_argument("--html", metavar="RUN.html", help="write a page that plays the run")
    run.add_argument(
        "--meshcat", action="store_true", help="show the run in a browser, in real time"
    )
    run.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="OPTION=VALUE",
        help="another value, such as target.duration=2 or controller=frmrc",
    )
    run.add_argument("--json", action="store_true", help="print errors and status as JSON")
    run.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    scenario = _changed(load_scenario(options.scenario), options.set)
    if not _folders_exist(options):
        return FAILED
    code = OK
    try:
        meshcat = _meshcat(options.meshcat)
        with quiet_drake():
            log = simulate(scenario, file=options.log, meshcat=meshcat, progress=progress())
    except SimulationStopped as stopped:
        print(f"fikm-drake: {stopped}", file=sys.stderr)
        log = stopped.log
        code = code_of(stopped.__cause__)
    if not _write(log, options):
        code = code or FAILED
    status = log.status_names[-1].lower() if "status" in log else None
    if options.json:
        found = {"scenario": options.scenario, "status": status, "metrics": log.metrics()}
        print_json(found)
    else:
        last = "" if status is None else f", {status.replace('_', ' ')} at the end"
        print(f"{options.scenario}: {log.metrics()}{last}")
    return code


def _changed(scenario: Scenario, changes: list[str]) -> Scenario:
    """The scenario with other values, each read as YAML."""
    values = {}
    for change in changes:
        option, equals, text = change.partition("=")
        if not equals:
            raise ValueError(f"--set takes OPTION=VALUE, got {change!r}")
        try:
            values[option] = yaml_load(data=text)
        except Exception as error:  # PyYAML raises many kinds
            raise ValueError(f"--set {option}: {text!r} is not YAML") from error
    return scenario.with_options(values) if values else scenario


def _meshcat(wanted: bool) -> Meshcat | None:
    """A page in the browser, its address told; None where none is wanted.

    A person at a terminal has `PATIENCE` to open it before the run begins.
    """
    if not wanted:
        return None
    meshcat = Meshcat()
    print(f"open {meshcat.web_url()}", file=sys.stderr, flush=True)
    if sys.stdin.isatty():
        print("the run begins when the page is open", file=sys.stderr, flush=True)
        end = time.monotonic() + PATIENCE
        while not meshcat.GetNumActiveConnections() and time.monotonic() < end:
            time.sleep(0.05)
    return meshcat


def _folders_exist(options: argparse.Namespace) -> bool:
    """Complain of a mistyped folder before the run, not after it."""
    for name in ("log", "csv", "plot", "html"):
        path = getattr(options, name)
        if path is not None and not Path(path).parent.is_dir():
            print(f"fikm-drake: cannot write {path}: there is no such folder", file=sys.stderr)
            return False
    return True


def _write(log: RunLog, options: argparse.Namespace) -> bool:
    """Write the files that were asked for, each even if another fails; True if all could be."""
    writers: dict[str, Callable] = {
        "log": log.save,  # again: the file that grew with the run may have failed
        "csv": log.to_csv,
        "plot": lambda path: plot_log(log, path),
        "html": lambda path: write_html(log, path),
    }
    return write_files(options, writers)
