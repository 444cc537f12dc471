"""Targets of the arm, in its plane or in space."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.checks import check_counts
from fikm_drake.solvers.batch.batch_targets import FARTHEST
from fikm_drake.solvers.labvolt.geometry import Geometry, labvolt


@dataclass(frozen=True)
class PlaneTargets:
    """N targets, turned into the arm's plane."""

    given: Array
    """(N,2) or (N,3), as the user gave them [m]."""
    valid: Bools
    """(N,): finite."""
    yaw: Array
    """(N,): of the base [rad]; 0 for targets in the plane and for invalid ones."""
    plane: Array
    """(2,N): x and y from the shoulder [m]; NaN for invalid ones."""

    def to_space(self, geometry: Geometry, plane: Array) -> Array:
        """Points of the plane (2,N) in the frame that the targets were given in, (N,2) or (N,3)."""
        if self.given.shape[1] == 2:
            return plane.T
        radius = plane[0] + geometry.offset
        x, y = radius * np.cos(self.yaw), radius * np.sin(self.yaw)
        return np.column_stack([x, y, plane[1] + geometry.height])


def plane_targets(geometry: Geometry, targets: ArrayLike) -> PlaneTargets:
    """Read targets: the base turns to face one in space, yaw = atan2(y, x), which leaves a plane.

    Args:
        geometry: of the arm.
        targets: one or many. (x, y) is in the arm's plane, from the shoulder, y up; (x, y, z) is in
            the base frame; (2,), (3,), (N,2) or (N,3) [m].

    Raises:
        ValueError: not numbers, or another shape.
    """
    try:
        given = np.array(targets, dtype=float, ndmin=1)
    except (TypeError, ValueError) as error:
        raise ValueError(f"targets must be numbers, in one shape: {error}") from None
    if given.shape == (0,):
        given = given.reshape(0, 2)
    if given.ndim == 1:
        given = given[None]
    if given.ndim != 2 or given.shape[1] not in (2, 3):
        raise ValueError(
            f"targets must have shape (2,), (3,), (N, 2) or (N, 3), got {np.shape(targets)}"
        )
    valid = (np.abs(given) < FARTHEST).all(axis=1)
    good = np.where(valid[:, None], given, np.nan)
    if given.shape[1] == 2:
        return PlaneTargets(given, valid, np.zeros(len(given)), np.ascontiguousarray(good.T))
    x, y, z = good.T
    yaw = np.where(valid, np.arctan2(y, x), 0.0)
    plane = np.array([np.hypot(x, y) - geometry.offset, z - geometry.height])
    return PlaneTargets(given, valid, yaw, plane)


def random_targets(count: int, *, seed: int = 0) -> Array:
    """Reachable points of the LabVolt 5250's plane, of postures uniform inside the limits.

    Args:
        count: how many, N.
        seed: the same seed gives the same points.

    Returns:
        (N,2), from the shoulder [m].

    Raises:
        ValueError: the count or the seed is not an integer of at least 0.
    """
    check_counts(0, count=count, seed=seed)
    geometry = labvolt()
    rng = np.random.default_rng(seed)
    postures = rng.uniform(geometry.lower, geometry.upper, (count, 3))
    return geometry.tool(postures.T).T
