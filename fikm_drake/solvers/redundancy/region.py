"""The feasible region of one joint: in closed form for a planar 3R arm, else traced."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from pydrake.math import RigidTransform

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import middle_of_limits
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.redundancy.postures_at_joint import MET, PosturesAtJoint
from fikm_drake.solvers.redundancy.tool_targets import as_poses, tool_errors
from fikm_drake.solvers.self_motion.feasible_intervals import EDGE, feasible_interval_table
from fikm_drake.solvers.self_motion.self_motion import SelfMotion
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer


@dataclass(frozen=True)
class Middle:
    """Postures in the middle of the exact bounds of the redundant joint, for N points."""

    q: Array
    """(N,n) [rad or m]; arbitrary where there is none inside the limits."""
    inside: Bools
    """(N,): whether there is one inside the limits."""
    lower: Array
    """(N,) lower bound of the joint [rad or m]."""
    upper: Array
    """(N,) upper bound of the joint [rad or m]."""


class Region(Protocol):
    """The feasible region of one joint of an arm, for valid points: in closed form, or traced."""

    def postures(self, points: Array, joint_position: Array) -> tuple[Array, Bools]:
        """Postures (N,n) with the joint at given positions (N,), and which are inside the limits."""

    def middle(self, points: Array) -> Middle:
        """Postures in the middle of the widest exact interval."""


class ClosedFormRegion:
    """A `Region` of points (N,2) [m] of a planar 3R arm.

    Of two elbows inside the limits the left one (θ3 bent to the positive side) is taken.

    Raises:
        ValueError: the arm is of another kind.
    """

    def __init__(self, arm: DhArm | SerialChain) -> None:
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


NARROW = 1e-9
"""An interval that is not halved: the joint hardly moves [rad or m]."""


class TracedRegion:
    """A `Region` of points, or poses, of an arm with one spare degree of freedom.

    Of several postures inside the limits the one that is closest to their middle is taken.

    Args:
        arm: the arm.
        task: it must leave one degree of freedom.
        joint: whose region it is, from 0.

    Raises:
        ValueError: the task leaves none or more than one degree of freedom.
    """

    def __init__(self, arm: DhArm | SerialChain, task: Task, joint: int) -> None:
        self._arm, self._task, self._joint = arm, task, joint
        self._tracer = SelfMotionTracer(arm, task)
        self._newton = PosturesAtJoint(arm, task, joint)
        self._lower, self._upper = arm.lower, arm.upper
        self._middle = middle_of_limits(arm.lower, arm.upper)

    def postures(self, points: Array, joint_position: Array) -> tuple[Array, Bools]:
        """See `Region`."""
        i = self._joint
        positions = np.clip(joint_position, self._lower[i], self._upper[i])
        return self._newton.solve(as_poses(points, self._task), positions)

    def middle(self, points: Array) -> Middle:
        """See `Region`."""
        q = np.full((len(points), self._middle.size), np.nan)
        bounds = np.full((2, len(points)), np.nan)
        poses = as_poses(points, self._task)
        for k, pose in enumerate(poses):
            motion = self._tracer.trace(RigidTransform(pose))
            if motion.components:
                q[k], bounds[:, k] = self._middle_of(motion)
        q = np.clip(q, self._lower, self._upper)  # of what rounding has left outside
        distance, turn = tool_errors(self._arm, self._task, q, poses)
        return Middle(q, (distance < MET * self._arm.chain.reach) & (turn < MET), *bounds)

    def _middle_of(self, motion: SelfMotion) -> tuple[Array, tuple[float, float]]:
        """The posture in the middle of the widest interval of a self-motion, and the interval."""
        intervals = motion.intervals(self._joint)
        widest = max(intervals, key=lambda interval: interval.upper - interval.lower)
        wanted = 0.5 * (widest.lower + widest.upper)
        i = self._joint
        parts = [c for c in motion.components if widest.lower <= c.lower[i] <= widest.upper]
        found = np.concatenate([part.with_joint_at(self._joint, wanted) for part in parts])
        if not len(found) or widest.upper - widest.lower < NARROW:
            longest = max(parts, key=lambda part: part.length)
            found = longest.at(0.5 * longest.length)[None]
        best = np.argmin(np.sum((found - self._middle) ** 2, axis=1))
        return found[best], (widest.lower, widest.upper)
