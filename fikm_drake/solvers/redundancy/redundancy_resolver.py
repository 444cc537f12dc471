"""Joint positions of a redundant planar arm, in the middle of what its limits leave."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.resolution import Resolution, ResolutionStatus
from fikm_drake.solvers.regions.feasible_intervals import EDGE, feasible_interval_table

Array = NDArray[np.float64]
FARTHEST = 1e100
"""Points beyond this are not valid: their squares overflow [m]."""


class RedundancyResolver:
    """Joint positions of a planar 3R arm for points, in the middle of the feasible region of joint 1.

    Section 4.5 of Hassantabar (2021), and what it lacks: the learned bounds give joint 1, a closed form
    the other two, each posture is verified against all limits, and one that fails is repaired by the
    exact bounds. So the learning never costs accuracy: the tool is at the point to rounding, or the
    point is flagged as infeasible.

        resolver = fd.RedundancyResolver(fd.load_arm("hassantabar3r"))
        resolver.resolve([[1.0, 2.0], [-1.0, 3.0]]).q

    Args:
        arm: a planar arm with three revolute joints about z.
        bounds: learned bounds of this arm; by default those that come with the library.

    Raises:
        ValueError: the arm is of another kind, or the bounds are of another arm, or there are none.
    """

    def __init__(self, arm: DhArm, bounds: LearnedBounds | None = None) -> None:
        self._geometry = Planar3R(arm)
        self._bounds = LearnedBounds.of(arm) if bounds is None else bounds
        if self._bounds.arm.table != arm.table:
            raise ValueError(
                f"the bounds are of arm {self._bounds.arm.name!r} with another table, not of {arm.name!r}"
            )
        self._arm = arm

    @property
    def arm(self) -> DhArm:
        """The arm."""
        return self._arm

    @property
    def bounds(self) -> LearnedBounds:
        """The learned bounds."""
        return self._bounds

    def resolve(self, points: ArrayLike) -> Resolution:
        """Joint positions for points (N,2) of the tool in the base frame [m].

        Of two elbows inside the limits the left one (θ3 bent to the positive side) is taken.

        Raises:
            ValueError: the points have another shape.
        """
        points = np.asarray(points, dtype=float)
        if points.ndim != 2 or points.shape[1] != 2:
            raise ValueError(f"points must have shape (N, 2), got {points.shape}")
        valid = (np.abs(points) < FARTHEST).all(axis=1)
        points = np.where(valid[:, None], points, np.nan)
        lower, upper = self._bounds.predict(points)
        q, inside = self._postures(points, lower, upper, 0.0)
        status = np.where(inside, ResolutionStatus.RESOLVED, ResolutionStatus.REPAIRED)
        failed = np.flatnonzero(~inside)
        if failed.size:
            exact = feasible_interval_table(self._arm, points[failed]).widest()
            lower[failed], upper[failed] = exact
            q[failed], repaired = self._postures(points[failed], *exact, EDGE)
            status[failed[~repaired]] = ResolutionStatus.INFEASIBLE
        status[~valid] = ResolutionStatus.INVALID_TARGET
        success = status <= ResolutionStatus.REPAIRED
        for array in (q, lower, upper):
            array[~success] = np.nan
        tool = self._arm.forward_kinematics(q)[:, :2, 3]
        error = np.hypot(*(tool - points).T)
        return Resolution(q, success, status, lower, upper, error)

    def _postures(
        self, points: Array, lower: Array, upper: Array, slack: float
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Postures (N,3) with joint 1 half-way between the bounds, and which are inside the limits.

        On the edge of the workspace rounding takes a posture out of the limits by up to `slack` [rad];
        it is moved back.
        """
        geometry = self._geometry
        theta_1 = np.clip(0.5 * (lower + upper), geometry.lower[0], geometry.upper[0])
        both = geometry.postures(points, theta_1)
        inside = geometry.is_inside(both, slack)
        q = np.where(inside[:, :1], both[:, 0], both[:, 1])
        return np.clip(q, geometry.lower, geometry.upper), np.asarray(inside.any(axis=1))
