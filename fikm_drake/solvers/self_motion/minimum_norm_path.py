"""The minimum-norm solution along a path: it depends on the path, and knows no limits."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.task import POSITION_TASKS, Task

ITERATIONS = 25
"""Iterations of a point, as in algorithm 1 of the thesis."""
ARRIVED = 1e-12
"""[m]."""


def minimum_norm_path(
    arm: DhArm, points: ArrayLike, start: ArrayLike, *, task: str = "xy"
) -> Array:
    """Postures along a path of points, each by steps of least norm from the one before it.

    dq = J⁺ (target − tool), repeated at each point until the tool is there (equation 2.4 of
    Hassantabar 2021 without its homogeneous part). Limits are ignored, and a closed path does not
    end at its first posture: the posture at a point depends on the way to it. For one that depends
    on the point alone, and is within the limits, see `closest_to_mid_range`.

    Args:
        arm: the arm.
        points: (N,m) coordinates of the task along the path [m].
        start: (n,) posture from which the first point is approached [rad or m].
        task: the coordinates that count, such as `xy` or `position`.

    Returns:
        (N,n) [rad or m]; NaN from the first point on that is not reached.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    if task not in POSITION_TASKS:
        raise ValueError(f"task must be one of {POSITION_TASKS}, got {task!r}")
    axes, rows = Task(task).coordinates, Task(task).rows
    array, q = np.asarray(points, dtype=float), np.array(start, dtype=float)
    if array.ndim != 2 or array.shape[1] != len(axes) or not np.isfinite(array).all():
        raise ValueError(f"points must be finite, of shape (N, {len(axes)}), got {array.shape}")
    if q.shape != (arm.num_joints,) or not np.isfinite(q).all():
        raise ValueError(f"start must be {arm.num_joints} finite positions, got {start!r}")
    path = np.full((len(array), arm.num_joints), np.nan)
    for k, point in enumerate(array):
        for _ in range(ITERATIONS):
            error = point - arm.forward_kinematics(q)[axes, 3]
            if np.abs(error).max() < ARRIVED:
                break
            q = q + np.linalg.pinv(arm.jacobian(q)[rows]) @ error
        else:
            return path
        path[k] = q
    return path
