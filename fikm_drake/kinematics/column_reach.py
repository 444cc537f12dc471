"""How long the columns of a task Jacobian can get."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.task import Task


def column_reach(bounds: Array, task: Task) -> Array:
    """Bounds of the lengths |J_k| of the columns of a task Jacobian over all joint positions.

    For a position in the plane or in space and a revolute joint it is the reach of the arm beyond
    the joint; for a prismatic joint it is at most 1. Rows of rotation count with the task's
    characteristic length.

    Args:
        bounds: (6,n) bounds of |J_ij|, rows [ω; v], as of `DhArm.jacobian_range`.
        task: the rows that count.

    Returns:
        (n,) [m for each rad or m of the joint].
    """
    turns, rows = bounds[:3].any(axis=0), task.rows
    lever = np.where(turns, bounds[3:].max(axis=0), 1.0)  # of the whole column, rows v
    linear = np.minimum(np.linalg.norm(bounds[[i for i in rows if i >= 3]], axis=0), lever)
    if not task.turns:
        return linear
    return np.hypot(linear, task.characteristic_length * turns)
