"""The feasible region of joint 1 of a planar 3R arm, in closed form."""

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.redundancy.region import Middle
from fikm_drake.solvers.self_motion.feasible_intervals import EDGE, feasible_interval_table


class ClosedFormRegion:
    """A `Region` of points (N,2) [m] of a planar 3R arm.

    Of two elbows inside the limits the left one (θ3 bent to the positive side) is taken.

    Raises:
        ValueError: the arm is of another kind.
    """

    def __init__(self, arm: DhArm) -> None:
        self._arm = arm
        self._geometry = Planar3R(arm)

    def postures(self, points: Array, joint_1: Array) -> tuple[Array, Bools]:
        """See `Region`."""
        return self._postures(points, joint_1, 0.0)

    def middle(self, points: Array) -> Middle:
        """See `Region`."""
        lower, upper = feasible_interval_table(self._arm, points).widest()
        return Middle(*self._postures(points, 0.5 * (lower + upper), EDGE), lower, upper)

    def _postures(self, points: Array, joint_1: Array, slack: float) -> tuple[Array, Bools]:
        # On the edge of the workspace rounding takes a posture out of the limits by up to `slack`; it
        # is moved back.
        geometry = self._geometry
        theta_1 = np.clip(joint_1, geometry.lower[0], geometry.upper[0])
        both = geometry.postures(points, theta_1)
        inside = geometry.is_inside(both, slack)
        q = np.where(inside[:, :1], both[:, 0], both[:, 1])
        return np.clip(q, geometry.lower, geometry.upper), np.asarray(inside.any(axis=1))
