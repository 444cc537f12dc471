"""Feasible intervals by brute force: the independent check of the closed form."""

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.dh_arm import DhArm

HALVINGS = 60
"""Halvings of a cell of the scan: more than double precision resolves."""


def scan_intervals(
    arm: DhArm, points: Array, known: Array | None = None, *, cells: int = 400
) -> tuple[NDArray[np.int_], Array, Array]:
    """Intervals of θ1 of a planar 3R arm by a scan and bisection of every change it sees.

    It shares nothing with `feasible_intervals`: the two postures at a θ1 are the textbook's, by the
    law of cosines.

    Args:
        arm: planar, three joints with limits, links along x, no offsets.
        points: (N,2) [m].
        known: (N,) a feasible θ1 of each point [rad], so that no interval around it falls between
            two cells.
        cells: of the scan, over the limits of joint 1.

    Returns:
        Row, lower and upper bound [rad] of each interval, (K,) each, rows ascending.
    """
    count = len(points)
    grid = np.broadcast_to(np.linspace(arm.lower[0], arm.upper[0], cells + 1), (count, cells + 1))
    if known is not None:
        grid = np.sort(np.concatenate([grid, known[:, None]], axis=1), axis=1)
    feasible = is_feasible(arm, points[:, None], grid)
    padded = np.pad(feasible, ((0, 0), (1, 1)))
    rows, starts = np.nonzero(padded[:, 1:] & ~padded[:, :-1])
    _, ends = np.nonzero(padded[:, :-1] & ~padded[:, 1:])
    ends -= 1
    last = grid.shape[1] - 1
    lower = _bisect(arm, points[rows], grid[rows, starts], grid[rows, np.maximum(starts - 1, 0)])
    upper = _bisect(arm, points[rows], grid[rows, ends], grid[rows, np.minimum(ends + 1, last)])
    return rows, lower, upper


def is_feasible(arm: DhArm, points: Array, theta_1: Array) -> Bools:
    """Whether joint 1 at θ1 leaves joints 2 and 3 a posture within their limits."""
    rows = arm.table.joints
    a, b, c = rows[1].a, rows[2].a, arm.table.tool.a
    x, y = points[..., 0] - a * np.cos(theta_1), points[..., 1] - a * np.sin(theta_1)
    cosine = (x * x + y * y - b * b - c * c) / (2.0 * b * c)
    found = np.zeros(cosine.shape, dtype=bool)
    for sign in (1.0, -1.0):
        theta_3 = sign * np.arccos(np.clip(cosine, -1.0, 1.0))
        across, along = c * np.sin(theta_3), b + c * np.cos(theta_3)
        theta_2 = np.arctan2(y, x) - np.arctan2(across, along) - theta_1
        found |= _within(arm, 1, theta_2) & _within(arm, 2, theta_3)
    return found & (np.abs(cosine) <= 1.0)


def _within(arm: DhArm, joint: int, angle: Array) -> Bools:
    """Whether some whole turn brings an angle within a joint's limits."""
    lower, upper = arm.lower[joint], arm.upper[joint]
    return np.mod(angle - lower, 2.0 * np.pi) <= upper - lower


def _bisect(arm: DhArm, points: Array, inside: Array, outside: Array) -> Array:
    """The last feasible θ1 on the way from one that is to one that is not, or is the same."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        feasible = is_feasible(arm, points, middle)
        inside, outside = np.where(feasible, middle, inside), np.where(feasible, outside, middle)
    return inside
