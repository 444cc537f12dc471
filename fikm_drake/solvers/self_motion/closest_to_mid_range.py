"""The posture of a planar 3R arm at a point that is closest to the middle of its joints' limits."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.self_motion.feasible_intervals import CHUNK, interval_columns

NODES = 17
"""Postures of an interval that are compared first."""
HALVINGS = 54
"""Halvings of the gap around the best of them."""


def closest_to_mid_range(arm: DhArm, points: ArrayLike) -> Array:
    """Postures that reach points within all limits, each the closest to the middle of the limits.

    Closest means the least Σ (q_i − middle_i)². It depends on the point alone, other than a posture
    found by integrating steps of least norm along a path (`minimum_norm_path`).

    Args:
        arm: a planar arm with three revolute joints about z, all with two limits.
        points: (N,2) [m].

    Returns:
        (N,3) [rad], NaN where the point is infeasible.

    Raises:
        ValueError: the arm is of another kind, or `points` has another shape.
    """
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {array.shape}")
    if not np.isfinite([arm.lower, arm.upper]).all():
        raise ValueError(f"arm {arm.name!r} must have two limits of each joint")
    geometry = Planar3R(arm)
    q = np.full((len(array), 3), np.nan)
    for start in range(0, len(array), CHUNK):
        chunk = array[start : start + CHUNK]
        distance = np.full(len(chunk), np.inf)
        for elbow in (0, 1):
            rows, lower, upper, _, _ = interval_columns(geometry, chunk, (elbow,))
            found = _closest(geometry, chunk[rows], lower, upper, elbow)
            squares = np.sum((found - geometry.middle) ** 2, axis=-1)
            # The best of a row's intervals: written last.
            order = np.argsort(-squares, kind="stable")
            order = order[squares[order] < distance[rows[order]]]
            q[start + rows[order]] = found[order]
            distance[rows[order]] = squares[order]
    return q


def _closest(geometry: Planar3R, points: Array, lower: Array, upper: Array, elbow: int) -> Array:
    """The closest posture (K,3) with one elbow on each of K intervals of θ1."""
    nodes = np.linspace(lower, upper, NODES, axis=1)
    postures = geometry.postures(points[:, None], nodes)[..., elbow, :]
    squares = np.sum((postures - geometry.middle) ** 2, axis=-1)
    best = np.argmin(np.where(np.isnan(squares), np.inf, squares), axis=1)
    every = np.arange(len(points))
    low, high = nodes[every, np.maximum(best - 1, 0)], nodes[every, np.minimum(best + 1, NODES - 1)]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        q = geometry.postures(points, middle)[:, elbow]
        rises = np.sum((q - geometry.middle) * geometry.self_motion(q), axis=-1) > 0.0
        low, high = np.where(rises, low, middle), np.where(rises, middle, high)
    q = geometry.postures(points, 0.5 * (low + high))[:, elbow]
    return np.clip(q, geometry.lower, geometry.upper)
