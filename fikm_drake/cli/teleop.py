"""`fikm-drake teleop`: sliders in a browser move a robot's tool."""

import argparse
import sys
from pathlib import Path

from fikm_drake.cli.shared import FAILED, OK, TERMINATED, Terminated
from fikm_drake.simulation.teleoperation import Teleop


def add_teleop(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    teleop = commands.add_parser(
        "teleop", help="move a robot's tool by sliders in a browser, with a light for the status"
    )
    teleop.add_argument("robot", help="name of an arm, DH table (.yaml), URDF, SDF or MJCF file")
    teleop.add_argument("--frame", help="the tool's frame in a model; by default the last body's")
    teleop.add_argument("--port", type=int, help="of the page; by default a free one from 7000")
    teleop.add_argument("--log", metavar="RUN.npz", help="write a log while it goes on")
    teleop.add_argument("--seconds", type=float, help="stop after this time; by default at Ctrl-C")
    teleop.set_defaults(run=_teleop)


def _teleop(options: argparse.Namespace) -> int:
    if options.log is not None and not Path(options.log).parent.is_dir():
        print(f"fikm-drake: cannot write {options.log}: there is no such folder", file=sys.stderr)
        return FAILED
    teleop = Teleop(options.robot, frame=options.frame, port=options.port)
    print(
        f"open {teleop.meshcat.web_url()} and move the sliders; Ctrl-C or `Stop` ends", flush=True
    )
    code = OK
    try:
        log = teleop.run(seconds=options.seconds, file=options.log)
    except KeyboardInterrupt as error:  # Ctrl-C is how it is meant to end
        code = TERMINATED if isinstance(error, Terminated) else OK
        log = teleop.log()
    if options.log is not None:
        log.save(options.log)
        print(f"wrote {options.log}", file=sys.stderr)
    print(f"{len(log)} rows, {log.status_names[-1].lower().replace('_', ' ')} at the end")
    return code
