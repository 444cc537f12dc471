"""Exact joint positions for the points of a workplane."""

import copy
from math import ceil, sqrt

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finites
from fikm_drake.fuzzy.integer import IntegerPartition, fit_singletons
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.solvers.batch.solve_batch import solve_batch
from fikm_drake.solvers.workplane.workplane import Workplane

MOST_POINTS = 200_000
"""About as many points of a large workplane are fitted to."""


class WorkplaneInverse:
    """Joint positions that bring an arm's tool to points of a workplane, by `solve_batch`.

    Args:
        arm: any arm of revolute joints.
        workplane: the workplane, in the arm's base frame; it is copied.
        initial_position: joint positions (n,) from which every point is searched for, so that
            neighbouring points get neighbouring postures [rad].

    Raises:
        ValueError: a joint is prismatic, `initial_position` is not n finite numbers, or see
            `Workplane.validate`.
    """

    def __init__(self, arm: DhArm, workplane: Workplane, initial_position: ArrayLike) -> None:
        workplane.validate()
        for i, joint in enumerate(arm.table.joints, start=1):
            if not joint.is_revolute:
                raise ValueError(f"all joints must be revolute, joint {i} of {arm.name!r} is not")
        self.arm = arm
        self._desk = copy.deepcopy(workplane)
        start = check_finites("initial_position", initial_position, arm.num_joints, "rad")
        self._initial_position = np.array(start)

    @property
    def workplane(self) -> Workplane:
        """A copy of the workplane."""
        return copy.deepcopy(self._desk)

    def __call__(self, points: ArrayLike) -> Array:
        """Joint positions at points of the workplane.

        Args:
            points: x, y (…,2) [mm].

        Returns:
            (…,n) [rad].

        Raises:
            ValueError: a point is out of reach, or points of another shape; the message names them.
        """
        points = np.asarray(points, dtype=float)
        targets = self._desk.to_world(points).reshape(-1, 3)
        solution = solve_batch(
            self.arm, targets, initial_position=self._initial_position, tolerance=1e-6
        )
        check_reached(solution.success.reshape(points.shape[:-1]), points)
        return solution.q.reshape(*points.shape[:-1], -1)

    def reached(self, q: ArrayLike) -> Array:
        """x, y and height over the workplane (…,3) [mm] of the tool at joint positions (…,n)."""
        return self._desk.from_world(self.arm.forward_kinematics(q)[..., :3, 3])

    def singletons(
        self, labels: tuple[int, int], conjunction: Conjunction, *, least_squares: bool
    ) -> tuple[IntegerPartition, IntegerPartition, Array]:
        """Memberships of x and y, evenly spaced over the workplane, and singletons (n1, n2, n).

        Args:
            labels: memberships of x and of y, 2 to 33 each.
            conjunction: `min` or `product`, which counts for least squares only.
            least_squares: False: the joint positions at the peaks; True: those whose inference is
                nearest to the joint positions at every whole millimetre, of a large workplane at fewer.

        Raises:
            ValueError: a point is out of reach, or the workplane is too small for so many labels.
        """
        width, depth = self._desk.size
        first = IntegerPartition.even(0, width, labels[0])
        second = IntegerPartition.even(0, depth, labels[1])
        if not least_squares:
            peaks = np.stack(np.meshgrid(first.knots, second.knots, indexing="ij"), axis=-1)
            return first, second, self(peaks)
        every = ceil(sqrt(width * depth / MOST_POINTS))
        points = self._desk.grid(every).reshape(-1, 2)
        return first, second, fit_singletons(first, second, points, self(points), conjunction)


def check_reached(reached: ArrayLike, points: Array) -> None:
    """Raise ValueError, naming the first point (…,2) of the workplane [mm] that is not reached."""
    for x, y in points[~np.asarray(reached)][:1]:
        raise ValueError(f"the arm does not reach the point ({x:g}, {y:g}) mm of the workplane")
