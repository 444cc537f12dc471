"""Trains the bounds of a joint on traced self-motions: arms without a closed form."""

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

import numpy as np

from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.workspace_points import random_tool_poses
from fikm_drake.solvers.self_motion.generate_feasibility_data import generate_feasibility_data

TRACED_POINTS = 4000
TRACED_EPOCHS = 60
HELD = 5
"""Every so many-th point is not learned from: the best epoch is the best over those."""
RIDGE = 1e-7
SEED = 0
TRACING = 0.6
"""Share of the time that tracing takes, about, for the progress."""


def train_traced_bounds(
    arm: DhArm,
    *,
    task: str = "pose",
    joint: int = 0,
    inputs: str = "polar",
    memberships: tuple[int, ...] = (5, 5, 5),
    points: int = TRACED_POINTS,
    epochs: int = TRACED_EPOCHS,
    executor: Executor | None = None,
    file: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> LearnedBounds:
    """Train two ANFIS on the traced bounds of a joint, by variable projection.

    The points are where the tool of random postures is, half of the postures near limits: there the
    bounds change fastest. The same arm and options give the same bounds.

    Args:
        arm: a planar arm, with four revolute joints for the task `pose`, three for `xy`.
        task: what the points fix; it must leave one degree of freedom.
        joint: whose bounds, from 0.
        inputs: see `BoundsInputs`.
        memberships: of each input, one number an input.
        points: to trace, some 20 ms each; a fifth of them is held back to find the best epoch.
        epochs: how many.
        executor: that traces, such as a ProcessPoolExecutor; None: this process.
        file: where the traced data are kept, see `generate_feasibility_data`.
        progress: called with the fraction done.

    Raises:
        ValueError: naming the bad value.
    """
    inputs_of = BoundsInputs(arm, task, inputs)
    if len(memberships) != len(inputs_of.names):
        raise ValueError(f"memberships must be of {inputs_of.names}, got {memberships!r}")
    networks = [
        Anfis(memberships, names=[*inputs_of.names, f"theta_{joint + 1}_{side}"])
        for side in ("lower", "upper")
    ]
    LearnedBounds(arm, inputs, *networks, task=task, joint=joint)  # all valid, before the tracing

    def show(start: float, share: float) -> Callable[[float], None]:
        return lambda done: progress(start + share * done) if progress else None

    poses = random_tool_poses(arm, points, SEED)
    what = Task(task)
    data = generate_feasibility_data(
        arm,
        poses if what.turns else poses[:, what.coordinates, 3],
        executor,
        task=task,
        joint=joint,
        file=file,
        progress=show(0.0, TRACING),
    )
    X = inputs_of(data.points[data.feasible])
    held = np.arange(len(X)) % HELD == 0
    share = 0.5 * (1.0 - TRACING)
    for k, (anfis, bound) in enumerate(zip(networks, (data.lower, data.upper))):
        Y = bound[data.feasible]
        anfis.fit(
            X[~held],
            Y[~held],
            epochs=epochs,
            method="variable_projection",
            ridge=RIDGE,
            validation=(X[held], Y[held]),
            progress=show(TRACING + k * share, share),
        )
    return LearnedBounds(arm, inputs, *networks, task=task, joint=joint)
