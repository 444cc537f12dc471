"""Trains the bounds of the redundant joint."""

from collections.abc import Callable

from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.redundancy.learned_bounds import (
    LearnedBounds,
    bounds_inputs,
    check_inputs,
)
from fikm_drake.solvers.redundancy.workspace_points import workspace_points
from fikm_drake.solvers.regions.feasible_intervals import feasible_interval_table

NAMES = {"xy": ("x", "y"), "polar": ("r", "phi")}
RIDGE = 1e-9
POINTS = 3356
"""As many as the thesis's."""


def train_bounds(
    arm: DhArm,
    *,
    inputs: str = "polar",
    memberships: tuple[int, int] = (8, 8),
    points: int = POINTS,
    method: str = "variable_projection",
    epochs: int = 150,
    starts: int = 8,
    ridge: float = RIDGE,
    progress: Callable[[float], None] | None = None,
) -> LearnedBounds:
    """Train two ANFIS on the exact bounds of joint 1 over the arm's workspace.

    Where a point has several intervals, the widest is learned. The same arm and options give the same
    bounds.

    Args:
        arm: a planar arm with three revolute joints about z.
        inputs: `polar` (distance from joint 1 and angle) or `xy`.
        memberships: of each input.
        points: about how many to learn from, see `workspace_points`.
        method: see `Anfis.fit`.
        epochs: see `Anfis.fit`.
        starts: see `Anfis.fit`; the seed is 0.
        ridge: see `Anfis.fit`.
        progress: called with the fraction done.

    Raises:
        ValueError: naming the bad value.
    """
    check_inputs(inputs)
    data = workspace_points(arm, points, edge=True)
    X = bounds_inputs(Planar3R(arm), data, inputs)
    learned = []
    for k, (name, theta) in enumerate(
        zip(("lower", "upper"), feasible_interval_table(arm, data).widest())
    ):
        anfis = Anfis(memberships, names=[*NAMES[inputs], f"theta_1_{name}"])

        def show(fraction: float, k: int = k) -> None:
            if progress:
                progress(0.5 * (k + fraction))

        learned.append(
            anfis.fit(
                X,
                theta,
                epochs=epochs,
                method=method,
                ridge=ridge,
                starts=starts,
                progress=show,
            )
        )
    return LearnedBounds(arm, inputs, *learned)
