"""`fikm-drake train`: learned bounds of a redundant arm."""

import argparse
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from fikm_drake.cli.shared import FAILED, OK, positive_count, progress
from fikm_drake.experiments.reproduce.anfis.samples import train_static
from fikm_drake.experiments.reproduce.anfis.seven_joints import train_freedom
from fikm_drake.fuzzy.anfis.anfis import Anfis
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
    traced.add_argument("--joint", type=int, default=1, help="whose bounds (1)")
    traced.add_argument("--inputs", choices=INPUTS, default="polar")
    traced.add_argument(
        "--points", type=positive_count, default=TRACED_POINTS, help=f"how many ({TRACED_POINTS})"
    )
    traced.add_argument(
        "--epochs", type=positive_count, default=TRACED_EPOCHS, help=f"how many ({TRACED_EPOCHS})"
    )
    traced.add_argument("--processes", type=positive_count, help="that trace; all cores")
    traced.set_defaults(run=_traced_bounds)

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
