"""Joint positions of a redundant arm, in the middle of what its limits leave."""

from contextlib import suppress

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.checks import check_joint
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.region import ClosedFormRegion, Region, TracedRegion
from fikm_drake.solvers.redundancy.resolution import Resolution, ResolutionStatus
from fikm_drake.solvers.redundancy.tool_targets import as_poses, checked_points, tool_errors


class RedundancyResolver:
    """Joint positions of an arm with one spare degree of freedom, in the middle of a joint's region.

    Section 4.5 of Hassantabar (2021), and what it lacks: the learned bounds give one joint, a closed
    form (planar 3R, its first joint) or Newton's method the others, each posture is verified against
    all limits and by forward kinematics, and one that fails is repaired by the exact bounds: in closed
    form, or by tracing the self-motion. So the learning never costs accuracy: the tool is at the point
    to rounding, or the point is flagged as infeasible. Not for several threads at once.

        resolver = fd.RedundancyResolver(fd.load_arm("hassantabar3r"))
        resolver.resolve([[1.0, 2.0], [-1.0, 3.0]]).q
        resolver = fd.RedundancyResolver(fd.load_arm("hassantabar4r"), task="pose")
        resolver.resolve(poses).q  # (N,4,4)

    Args:
        arm: the arm, a `DhArm` or a chain of `SerialChain.from_plant`.
        bounds: learned bounds of this arm, task and joint; by default those that come with the library.
            Where there are none, the exact bounds are taken for every point: traced, that is some 20 ms
            for a planar 4R and 0.2 s for an iiwa14.
        task: what the points fix; it must leave one degree of freedom. A planar arm with three joints
            has `xy`, one with four has `pose`, a spatial one with seven has `pose`.
        joint: whose bounds are halved, from 0. One that does not move along the self-motion (the
            elbow of many 7-joint arms) leaves the choice to the arc length: its middle is taken.

    Raises:
        ValueError: the task leaves none or more than one degree of freedom; there is no such joint; the
            bounds are of another arm, task or joint.
    """

    def __init__(
        self,
        arm: DhArm | SerialChain,
        bounds: LearnedBounds | None = None,
        *,
        task: str = "xy",
        joint: int = 0,
    ) -> None:
        check_joint(joint, arm.num_joints)
        self._arm, self._task, self._joint = arm, Task(task), joint
        self._region = _region(arm, self._task, joint)
        if bounds is not None:
            bounds.check_are_of(arm, task, joint)
        elif isinstance(arm, DhArm):
            bounds = LearnedBounds.find(arm, task, joint)
        self._bounds = bounds

    @property
    def arm(self) -> DhArm | SerialChain:
        """The arm."""
        return self._arm

    @property
    def task(self) -> Task:
        """What the points fix."""
        return self._task

    @property
    def joint(self) -> int:
        """Whose bounds are halved, from 0."""
        return self._joint

    @property
    def bounds(self) -> LearnedBounds | None:
        """The learned bounds; None without any."""
        return self._bounds

    def resolve(self, points: ArrayLike) -> Resolution:
        """Joint positions for points of the tool in the base frame.

        Args:
            points: (N,2) [m] for the task `xy`; the coordinates (N,m) [m] of other tasks; poses (N,4,4)
                where the task counts orientation.

        Raises:
            ValueError: the points have another shape.
        """
        array, valid = checked_points(points, self._task)
        count = len(array)
        q = np.full((count, self._arm.num_joints), np.nan)
        lower, upper, distance, turn = np.full((4, count), np.nan)
        status = np.full(count, ResolutionStatus.INVALID_INPUT.value)
        rest = np.flatnonzero(valid)
        if self._bounds is not None:
            lower[rest], upper[rest] = self._bounds.predict(array[rest])
            wanted = 0.5 * (lower[rest] + upper[rest])
            q[rest], inside = self._region.postures(array[rest], wanted)
            status[rest[inside]] = ResolutionStatus.SOLVED
            rest = rest[~inside]
        if rest.size:
            exact = self._region.middle(array[rest])
            q[rest], lower[rest], upper[rest] = exact.q, exact.lower, exact.upper
            status[rest] = np.where(
                exact.inside, ResolutionStatus.REPAIRED, ResolutionStatus.INFEASIBLE
            )
        success = np.isin(status, (ResolutionStatus.SOLVED, ResolutionStatus.REPAIRED))
        for values in (q, lower, upper):
            values[~success] = np.nan
        poses = as_poses(array[success], self._task)
        distance[success], turn[success] = tool_errors(self._arm, self._task, q[success], poses)
        return Resolution(q, success, status, lower, upper, distance, turn)


def _region(arm: DhArm | SerialChain, task: Task, joint: int) -> Region:
    """In closed form where there is one."""
    if task.name == "xy" and joint == 0:
        with suppress(ValueError):  # not a planar 3R
            return ClosedFormRegion(arm)
    return TracedRegion(arm, task, joint)
