"""Trains functions of the workspace of a planar arm, such as the bounds of its redundant joint."""

import functools
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any

from fikm_drake.arrays import Array
from fikm_drake.executors import completed
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.workspace_points import random_workspace_points, workspace_points
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table

POINTS = 3356
"""As many as the thesis's."""
STARTS = 4
RIDGE = 1e-9
SEED = 0
"""Seed of the points to validate on, and of the partitions to start from."""


def train_bounds(
    arm: DhArm,
    *,
    inputs: str = "polar",
    memberships: tuple[int, int] = (8, 8),
    points: int = POINTS,
    method: str = "variable_projection",
    epochs: int = 150,
    starts: int = STARTS,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> LearnedBounds:
    """Train two ANFIS on the exact bounds of joint 1 of a planar 3R arm over its workspace.

    Where a point has several intervals, the widest is learned. The same arm and options give the same
    bounds. For the options see `train_on_workspace`; for arms without a closed form `train_traced_bounds`.
    An `executor`, such as a ProcessPoolExecutor, trains both at once.

    Raises:
        ValueError: naming the bad value.
    """
    train = functools.partial(
        _train_bound,
        arm,
        inputs=inputs,
        memberships=memberships,
        points=points,
        method=method,
        epochs=epochs,
        starts=starts,
    )
    if executor is None:  # progress of each epoch
        learned = [train(k, progress=_share(progress, k)) for k in range(2)]
        return LearnedBounds(arm, inputs, *learned)
    found: dict[int, Anfis] = {}
    for k, anfis in completed(executor, train, [(0,), (1,)]):
        found[k] = anfis
        if progress:
            progress(0.5 * len(found))
    return LearnedBounds(arm, inputs, found[0], found[1])


def _train_bound(arm: DhArm, side: int, **options: Any) -> Anfis:  # noqa: ANN401 (train_on_workspace's)
    """The lower (0) or the upper (1) bound, learned."""

    def bound(points: Array) -> Array:
        return feasible_interval_table(arm, points).widest()[side]

    return train_on_workspace(arm, bound, f"theta_1_{('lower', 'upper')[side]}", **options)


def _share(progress: Callable[[float], None] | None, side: int) -> Callable[[float], None] | None:
    return progress and (lambda fraction: progress(0.5 * (side + fraction)))


def train_on_workspace(
    arm: DhArm,
    function: Callable[[Array], Array],
    name: str,
    *,
    inputs: str = "polar",
    memberships: tuple[int, int] = (8, 8),
    points: int = POINTS,
    method: str = "variable_projection",
    epochs: int = 150,
    starts: int = STARTS,
    progress: Callable[[float], None] | None = None,
) -> Anfis:
    """Train an ANFIS on a function of the tool's position.

    It learns from a grid over the workspace with its edge; the best epoch is the best over as many
    random points.

    Args:
        arm: a planar arm with three revolute joints about z.
        function: of feasible points (N,2) [m]; its values (N,) are learned.
        name: of the value.
        inputs: `polar` (distance from joint 1 and angle) or `xy`.
        memberships: of each input.
        points: about how many to learn from, see `workspace_points`.
        method: see `Anfis.fit`.
        epochs: see `Anfis.fit`.
        starts: see `Anfis.fit`.
        progress: called with the fraction done.

    Raises:
        ValueError: naming the bad value.
    """
    inputs_of = BoundsInputs(arm, "xy", inputs)
    grid = workspace_points(arm, points, edge=True)
    fresh = random_workspace_points(arm, points, SEED)
    return Anfis(memberships, names=[*inputs_of.names, name]).fit(
        inputs_of(grid),
        function(grid),
        epochs=epochs,
        method=method,
        ridge=RIDGE,
        starts=starts,
        seed=SEED,
        validation=(inputs_of(fresh), function(fresh)),
        progress=progress,
    )
