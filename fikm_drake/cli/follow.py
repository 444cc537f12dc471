"""`fikm-drake follow`: a path of the tool to joint positions."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fikm_drake.cli.shared import FAILED, OK, write_files
from fikm_drake.files import write_whole
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.load_robot import MODELS, load_chain
from fikm_drake.simulation.path_page import write_path_html
from fikm_drake.solvers.paths.joint_path import JointPath, joint_path
from fikm_drake.solvers.paths.path_targets import COLUMNS, load_path_csv

RATE = 100.0
"""Rows a second of the table in time [Hz]."""


def add_follow(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    follow = commands.add_parser("follow", help="joint positions along a path of the tool")
    follow.add_argument("robot", help="a model (.urdf, .sdf, .xml), a DH table (.yaml) or its name")
    follow.add_argument(
        "way",
        metavar="WAY.csv",
        help="targets [m, rad], a line each: " + "; or ".join(COLUMNS.values()),
    )
    follow.add_argument("--out", metavar="JOINTS.csv", help="write a line a target: joints, status")
    follow.add_argument(
        "--times", metavar="TIMES.csv", help=f"write the fastest motion, {RATE:g} lines a second"
    )
    follow.add_argument("--html", metavar="WAY.html", help="write a page that plays it")
    follow.add_argument("--frame", help="the tool's frame in a model; by default the last body's")
    follow.add_argument("--task", choices=("position", "pose"), help="(what the targets are)")
    follow.add_argument(
        "--start", metavar="Q1,Q2,…", help="joint positions before the first target [rad, m]"
    )
    follow.set_defaults(run=_follow)


def _follow(options: argparse.Namespace) -> int:
    chain = load_chain(options.robot, options.frame)
    for name in ("out", "times", "html"):
        target = getattr(options, name)
        if target is not None and not Path(target).parent.is_dir():
            print(f"fikm-drake: cannot write {target}: there is no such folder", file=sys.stderr)
            return FAILED
    start = None
    if options.start is not None:
        try:
            start = np.array([float(x) for x in options.start.split(",")])
        except ValueError:
            raise ValueError(
                f"--start must be numbers with commas, got {options.start!r}"
            ) from None
    path = joint_path(chain, load_path_csv(options.way), task=options.task, initial_position=start)
    print(f"{options.way}: {str(path)[1:-1]}")
    for line in path.explain():
        print(f"  {line}")
    good = path.success
    if good:
        print(f"fastest inside the limits: {path.trajectory().end_time():.3f} s")
    model = options.robot if Path(options.robot).suffix in MODELS else load_arm(options.robot)
    writers: dict[str, Callable] = {
        "out": path.save_csv,
        "times": lambda target: _save_times(path, target),
        "html": lambda target: write_path_html(path, model, target),
    }
    written = write_files(options, writers)
    return OK if good and written else FAILED


def _save_times(path: JointPath, target: str) -> None:
    trajectory = path.trajectory()
    times = np.append(np.arange(0.0, trajectory.end_time(), 1.0 / RATE), trajectory.end_time())
    lines = [",".join(["time_s", *path.chain.joint_names])]
    for t, q in zip(times, trajectory.vector_values(times).T):
        lines.append(",".join(f"{x:.12g}" for x in (t, *q)))
    write_whole(target, "\n".join(lines) + "\n")
