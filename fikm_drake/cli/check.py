"""`fikm-drake check`: a robot's file as a controller will see it."""

import argparse

from fikm_drake.cli.shared import OK, positive_count, print_json
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.experiments.check_robot import SECONDS, RobotReport, check_robot


def add_check(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    check = commands.add_parser(
        "check", help="look at a robot's file, and drive it to random poses"
    )
    check.add_argument("robot", help="a .urdf, .sdf or .xml file; or an arm's name or .yaml file")
    check.add_argument("--frame", default="tool", help="the tool's frame (tool)")
    check.add_argument("--joints", nargs="+", help="which joints on the way to it move (all)")
    check.add_argument("--base", help="the frame from which the arm starts (the world)")
    check.add_argument("--poses", type=positive_count, default=50, help="how many poses (50)")
    check.add_argument("--json", action="store_true", help="print what was found as JSON")
    check.set_defaults(run=_check)


def _check(options: argparse.Namespace) -> int:
    with quiet_drake():
        report = check_robot(
            options.robot,
            options.frame,
            joints=options.joints,
            base=options.base,
            poses=options.poses,
        )
    if options.json:
        print_json(report)
        return OK
    _print(report)
    return OK


def _print(report: RobotReport) -> None:
    print(f"{report.frame}: {len(report.joints)} joints, reach {report.reach:.3f} m")
    print(f"{'':2s}{'joint':24s}{'kind':>10s}{'lower':>10s}{'upper':>10s}{'speed':>10s}")
    for joint in report.joints:
        numbers = (joint.lower, joint.upper, joint.velocity_limit)
        print(f"  {joint.name:24s}{joint.kind:>10s}" + "".join(f"{x:10.4g}" for x in numbers))
    for line in report.odd or ["nothing"]:
        print(f"odd: {line}")
    print(
        f"of {report.poses} random poses, in {SECONDS:g} s each with restart search: "
        f"{report.reached_from_default} reached from the default posture, "
        f"{report.reached_from_middle} from the middle of the limits"
    )
    print(
        f"false CONVERGED: {report.false_converged}; {report.microseconds_a_cycle:.0f} µs of CPU a cycle"
    )
