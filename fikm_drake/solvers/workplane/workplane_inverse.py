"""Exact joint positions for the points of a workplane: any arm, or in closed form one like paper 5's."""

import copy
from math import ceil, sqrt

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finites
from fikm_drake.fuzzy.integer import IntegerPartition, fit_singletons
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.kinematics.serial_chain import HasChain, SerialChain, as_chain
from fikm_drake.solvers.solver import solve_batch
from fikm_drake.solvers.workplane.workplane import Workplane

MOST_POINTS = 200_000
"""About as many points of a large workplane are fitted to."""


class WorkplaneInverse:
    """Joint positions that bring an arm's tool to points of a workplane, by `solve_batch`.

    Args:
        arm: any arm of revolute joints, a `DhArm` or a chain such as of `SerialChain.from_plant`.
        workplane: the workplane, in the arm's base frame; it is copied.
        initial_position: joint positions (n,) from which every point is searched for, so that
            neighbouring points get neighbouring postures [rad].

    Raises:
        ValueError: a joint is prismatic, `initial_position` is not n finite numbers, or see
            `Workplane.validate`.
    """

    def __init__(
        self, arm: SerialChain | HasChain, workplane: Workplane, initial_position: ArrayLike
    ) -> None:
        workplane.validate()
        self.chain = chain = as_chain(arm)
        for name, kind in zip(chain.joint_names, chain.kinds):
            if kind != "revolute":
                raise ValueError(f"all joints must be revolute, {name} of {chain.name!r} is not")
        self._workplane = copy.deepcopy(workplane)
        start = check_finites("initial_position", initial_position, chain.num_joints, "rad")
        self._initial_position = np.array(start)

    @property
    def workplane(self) -> Workplane:
        """A copy of the workplane."""
        return copy.deepcopy(self._workplane)

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
        targets = self._workplane.to_world(points).reshape(-1, 3)
        solution = solve_batch(
            self.chain, targets, initial_position=self._initial_position, tolerance=1e-6
        )
        check_reached(solution.success.reshape(points.shape[:-1]), points)
        return solution.q.reshape(*points.shape[:-1], -1)

    def reached(self, q: ArrayLike) -> Array:
        """x, y and height over the workplane (…,3) [mm] of the tool at joint positions (…,n)."""
        return self._workplane.from_world(self.chain.forward_kinematics(q)[..., :3, 3])

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
        width, depth = self._workplane.size
        first = IntegerPartition.even(0, width, labels[0])
        second = IntegerPartition.even(0, depth, labels[1])
        if not least_squares:
            peaks = np.stack(np.meshgrid(first.knots, second.knots, indexing="ij"), axis=-1)
            return first, second, self(peaks)
        every = ceil(sqrt(width * depth / MOST_POINTS))
        points = self._workplane.grid(every).reshape(-1, 2)
        return first, second, fit_singletons(first, second, points, self(points), conjunction)


def check_reached(reached: ArrayLike, points: Array) -> None:
    """Raise ValueError, naming the first point (…,2) of the workplane [mm] that is not reached."""
    for x, y in points[~np.asarray(reached)][:1]:
        raise ValueError(f"the arm does not reach the point ({x:g}, {y:g}) mm of the workplane")


HEADING = (-1.01, -0.41)
"""Heading of the hand at the near and at the far edge [rad]: with these, Table 1's labels agree in order."""


SAMPLES = 5
"""Postures at which an arm's geometry is compared."""
ALIKE = 1e-9
"""How far the tool may be from where the geometry has it [reach]."""


class TiltedPlaneInverse(WorkplaneInverse):
    """Joint positions of an arm like `tojo4dof` at points of a workplane, in closed form.

    Three joints in a plane through the shoulder's y axis reach a point; the pitch tilts the plane so
    that it holds the point, and so depends on the distance from the shoulder only. The fourth joint
    is spent on the heading of the hand: its angle to the straight-ahead direction of the plane,
    positive to the left, which changes linearly from the near edge to the far one.

    Args:
        arm: of the geometry of `tojo4dof`, with any lengths of the links.
        workplane: the workplane, in the arm's base frame; it is copied.
        heading: of the hand at the near and at the far edge of the workplane [rad].

    Raises:
        ValueError: the arm has another geometry, the heading is not two finite angles, or see
            `Workplane.validate`.
    """

    def __init__(
        self,
        arm: SerialChain | HasChain,
        workplane: Workplane,
        *,
        heading: tuple[float, float] = HEADING,
    ) -> None:
        chain = as_chain(arm)
        super().__init__(chain, workplane, chain.default_position)
        self._lengths = _link_lengths(chain)
        self._heading = check_finites("heading", heading, 2, "rad")

    def __call__(self, points: ArrayLike) -> Array:
        """As of `WorkplaneInverse`."""
        points = np.asarray(points, dtype=float)
        forward, left, up = np.moveaxis(self._workplane.to_world(points), -1, 0)
        near, far = self._heading
        heading = near + (far - near) * points[..., 1] / self._workplane.size[1]
        upper, fore, hand = self._lengths
        ahead = np.hypot(forward, up) - hand * np.cos(heading)  # the wrist, in the plane
        left = left - hand * np.sin(heading)
        cosine = (ahead**2 + left**2 - upper**2 - fore**2) / (2 * upper * fore)
        check_reached(np.abs(cosine) <= 1.0, points)
        pitch = np.arctan2(forward, -up)
        elbow = np.arccos(cosine)
        roll = np.arctan2(left, ahead) + np.arctan2(fore * np.sin(elbow), upper + fore * cosine)
        return np.stack([pitch, roll, elbow, roll - elbow - heading], axis=-1)


def _link_lengths(chain: SerialChain) -> tuple[float, float, float]:
    """Upper arm, forearm and hand [m]; ValueError unless the tool moves as that of `tojo4dof`."""
    if chain.num_joints == 4:
        X = chain.link_poses(np.zeros(4))
        ends = np.array([*X[2:, :3, 3], chain.forward_kinematics(np.zeros(4))[:3, 3]])
        links = np.cross(
            X[1:, :3, 2], ends - X[1:, :3, 3]
        )  # across the axes, wherever frames stand
        upper, fore, hand = np.linalg.norm(links, axis=1).tolist()
        q = np.random.default_rng(0).uniform(-1.0, 1.0, (SAMPLES, 4))
        pitch, roll, elbow, wrist = q.T
        turns = np.array([roll, roll - elbow, roll - elbow - wrist])
        lengths = np.array([upper, fore, hand])
        ahead, left = lengths @ np.cos(turns), lengths @ np.sin(turns)
        there = np.stack([ahead * np.sin(pitch), left, -ahead * np.cos(pitch)], axis=-1)
        away = np.abs(chain.forward_kinematics(q)[:, :3, 3] - there).max()
        if away < ALIKE * chain.reach:
            return upper, fore, hand
    raise ValueError(f"arm {chain.name!r} does not have the geometry of 'tojo4dof'")
