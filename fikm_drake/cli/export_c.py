"""`fikm-drake export-c`: fuzzy inverse kinematics in integers as C99."""

import argparse
import sys
from pathlib import Path

import numpy as np

from fikm_drake.cli.shared import FAILED, OK
from fikm_drake.fuzzy.integer import SHAPES
from fikm_drake.fuzzy.integer.integer_partition import ROUNDINGS
from fikm_drake.fuzzy.integer.integer_rule_base import CONJUNCTIONS
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk
from fikm_drake.solvers.workplane.workplane import load_workplane
from fikm_drake.solvers.workplane.workplane_data import WorkplaneData, load_workplane_data
from fikm_drake.solvers.workplane.workplane_inverse import WorkplaneInverse


def add_export_c(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    export = commands.add_parser("export-c", help="write fuzzy IK in integers as C99")
    export.add_argument("path", metavar="NAME.c", help="where to write; NAME.h goes beside it")
    source = export.add_mutually_exclusive_group()
    source.add_argument(
        "--data",
        metavar="DATA.csv",
        help="lines of x, y [mm] and joint positions [degrees]; by default the arm tojo4dof",
    )
    source.add_argument(
        "--arm",
        metavar="ARM",
        help="another arm, a model's name or a YAML file; its inverse kinematics give the singletons",
    )
    export.add_argument(
        "--workplane", metavar="PLANE", help="a model's name or a YAML file (tojo4dof), with --arm"
    )
    export.add_argument(
        "--start",
        nargs="+",
        type=float,
        metavar="Q",
        help="joint positions that every point is searched from [degrees], with --arm (the default's)",
    )
    export.add_argument(
        "--labels", nargs=2, type=int, default=(3, 3), metavar=("NX", "NY"), help="of x and y (3 3)"
    )
    export.add_argument("--conjunction", choices=CONJUNCTIONS, default="min", help="AND (min)")
    export.add_argument("--rounding", choices=ROUNDINGS, default="truncate", help="(truncate)")
    export.add_argument(
        "--resolution", type=float, default=0.01, metavar="STEP", help="of angles [degrees] (0.01)"
    )
    export.add_argument("--least-squares", action="store_true", help="fit the singletons")
    export.add_argument("--shape", choices=SHAPES, default=SHAPES[0], help=f"({SHAPES[0]})")
    export.set_defaults(run=_export)


def _export(options: argparse.Namespace) -> int:
    if not Path(options.path).parent.is_dir():
        print(f"fikm-drake: cannot write {options.path}: there is no such folder", file=sys.stderr)
        return FAILED
    ik = IntegerFuzzyIk(
        _source(options),
        labels=tuple(options.labels),
        conjunction=options.conjunction,
        rounding=options.rounding,
        resolution=options.resolution,
        least_squares=options.least_squares,
    )
    source, header = ik.to_c(options.path, shape=options.shape)
    print(f"wrote {source} and {header}: {ik.rules.size} rules, {ik.num_joints} joints")
    return OK


def _source(options: argparse.Namespace) -> WorkplaneInverse | WorkplaneData | None:
    """Where the singletons come from; None: the arm tojo4dof."""
    if options.data:
        return load_workplane_data(options.data)
    if options.arm is None:
        if options.workplane or options.start:
            raise ValueError("--workplane and --start need --arm")
        return None
    arm, plane = load_arm(options.arm), load_workplane(options.workplane or "tojo4dof")
    start = arm.default_position if options.start is None else np.deg2rad(options.start)
    return WorkplaneInverse(arm, plane, start)
