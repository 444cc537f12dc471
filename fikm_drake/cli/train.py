"""`fikm-drake train`: learned bounds of a redundant arm."""

import argparse
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from fikm_drake.cli.shared import FAILED, OK, positive_count, progress
from fikm_drake.experiments.reproduce.anfis.samples import train_static
from fikm_drake.experiments.reproduce.anfis.seven_joints import train_freedom
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.fuzzy.anfis.anfis_data import ORDERS
from fikm_drake.fuzzy.anfis.membership_kinds import KINDS
from fikm_drake.fuzzy.anfis.structure_search import search_structures, split_rows
from fikm_drake.fuzzy.anfis.training import METHODS
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.redundancy.bounds_inputs import INPUTS
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.train_bounds import POINTS, STARTS, train_bounds
from fikm_drake.solvers.redundancy.train_traced_bounds import (
    TRACED_EPOCHS,
    TRACED_POINTS,
    train_traced_bounds,
)

EXPERIMENTS: dict[str, tuple[str, Callable[[Callable[[float], None]], Anfis]]] = {
    "static": ("joint 1 of the thesis's arm in the posture closest to mid-range", train_static),
    "freedom": (
        "longest self-motion of an iiwa14, traced: an arm without closed form",
        train_freedom,
    ),
}
"""What `fikm-drake reproduce anfis` evaluates, by name."""


def add_train(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    train = commands.add_parser(
        "train", help="learn bounds and other functions of an arm's workspace"
    )
    what = train.add_subparsers(required=True, metavar="WHAT")

    bounds = what.add_parser(
        "bounds", help="bounds of joint 1 of a planar 3R arm, for `RedundancyResolver`"
    )
    bounds.add_argument("arm", help="name (see `fikm-drake models`) or path of a .yaml file")
    bounds.add_argument("out", metavar="BOUNDS.yaml", help="the file to write")
    bounds.add_argument("--inputs", choices=INPUTS, default="polar")
    bounds.add_argument("--method", choices=METHODS, default="variable_projection")
    bounds.add_argument("--points", type=int, default=POINTS, help=f"about how many ({POINTS})")
    bounds.add_argument("--epochs", type=int, default=150, help="how many (150)")
    bounds.add_argument(
        "--starts", type=int, default=STARTS, help=f"partitions to start from ({STARTS})"
    )
    bounds.set_defaults(run=_bounds)

    traced = what.add_parser(
        "traced-bounds",
        help="bounds of a joint of a planar 4R arm over poses, traced, for `RedundancyResolver`",
    )
    traced.add_argument("arm", help="name (see `fikm-drake models`) or path of a .yaml file")
    traced.add_argument("out", metavar="BOUNDS.yaml", help="the file to write")
    traced.add_argument("--joint", type=int, default=0, help="whose bounds, from 0 (0)")
    traced.add_argument("--inputs", choices=INPUTS, default="polar")
    traced.add_argument(
        "--points", type=positive_count, default=TRACED_POINTS, help=f"how many ({TRACED_POINTS})"
    )
    traced.add_argument(
        "--epochs", type=positive_count, default=TRACED_EPOCHS, help=f"how many ({TRACED_EPOCHS})"
    )
    traced.add_argument("--processes", type=positive_count, help="that trace; all cores")
    traced.set_defaults(run=_traced_bounds)

    structures = what.add_parser(
        "structures", help="compare memberships, kinds and orders of an ANFIS on held-out rows"
    )
    structures.add_argument(
        "data", metavar="DATA.csv", help="inputs, the output last; a row a line"
    )
    structures.add_argument(
        "--memberships", nargs="+", type=positive_count, default=[4, 6, 8], metavar="N"
    )
    structures.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    structures.add_argument("--orders", nargs="+", type=int, choices=ORDERS, default=list(ORDERS))
    structures.add_argument("--epochs", type=positive_count, default=40, help="of each (40)")
    structures.add_argument("--method", choices=METHODS, default="variable_projection")
    structures.add_argument("--seed", type=int, default=0, help="of the split into three (0)")
    structures.add_argument("--out", metavar="ANFIS.yaml", help="write the best")
    structures.set_defaults(run=_structures)

    for name, (text, learn) in EXPERIMENTS.items():
        experiment = what.add_parser(name, help=text)
        experiment.add_argument("out", metavar="ANFIS.yaml", help="the file to write")
        experiment.set_defaults(run=_experiment, learn=learn)


def _bounds(options: argparse.Namespace) -> int:
    arm = load_arm(options.arm)
    if not _folder_exists(options.out):
        return FAILED
    learned = train_bounds(
        arm,
        inputs=options.inputs,
        method=options.method,
        points=options.points,
        epochs=options.epochs,
        starts=options.starts,
        progress=progress(),
    )
    return _written(learned, options.out)


def _traced_bounds(options: argparse.Namespace) -> int:
    arm = load_arm(options.arm)
    if not _folder_exists(options.out):
        return FAILED
    with ProcessPoolExecutor(options.processes) as executor:
        learned = train_traced_bounds(
            arm,
            joint=options.joint,
            inputs=options.inputs,
            points=options.points,
            epochs=options.epochs,
            executor=executor,
            progress=progress(),
        )
    return _written(learned, options.out)


def _written(learned: LearnedBounds, path: str) -> int:
    learned.save(path)
    for anfis in (learned.lower, learned.upper):
        print(f"{anfis}: rms error {anfis.training_error.min():.2e} rad over the training data")
    return OK


def _structures(options: argparse.Namespace) -> int:
    if options.out is not None and not _folder_exists(options.out):
        return FAILED
    try:
        table = np.loadtxt(options.data, delimiter=",", skiprows=_heads(options.data), ndmin=2)
    except ValueError as error:
        raise ValueError(f"{options.data} is not a table of numbers: {error}") from error
    if table.shape[1] < 2:
        raise ValueError(
            f"{options.data} must have inputs and an output, has {table.shape[1]} column"
        )
    data, validation, held_out = split_rows(table[:, :-1], table[:, -1], seed=options.seed)
    found = search_structures(
        data,
        validation,
        held_out,
        memberships=options.memberships,
        kinds=options.kinds,
        orders=options.orders,
        epochs=options.epochs,
        method=options.method,
        progress=progress(),
    )
    print(f"{len(data[1])} rows learned, {len(validation[1])} chose, {len(held_out[1])} held out")
    print(
        f"{'structure':28s} {'numbers':>8s} {'validation':>11s} {'held out':>11s} {'largest':>11s}"
    )
    for s in found:
        errors = f"{s.validation:11.4g} {s.held_out:11.4g} {s.held_out_largest:11.4g}"
        print(f"{s!s:28s} {s.numbers:8d} {errors}")
    if options.out is not None:
        found[0].anfis.save(options.out)
        print(f"wrote {options.out}: {found[0]}")
    return OK


def _heads(path: str) -> int:
    """1 if the first line has names, else 0."""
    with open(path, encoding="utf-8") as file:
        first = file.readline().split(",")[0]
    try:
        float(first)
    except ValueError:
        return 1
    return 0


def _experiment(options: argparse.Namespace) -> int:
    if not _folder_exists(options.out):
        return FAILED
    anfis = options.learn(progress())
    anfis.save(options.out)
    print(f"{anfis}: rms error {anfis.training_error.min():.2e} rad over the training data")
    return OK


def _folder_exists(path: str) -> bool:
    """Complain of a mistyped folder before the training, not after it."""
    if Path(path).parent.is_dir():
        return True
    print(f"fikm-drake: cannot write {path}: there is no such folder", file=sys.stderr)
    return False
