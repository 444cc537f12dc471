"""Planar arms with three revolute joints, in closed form."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import middle_of_limits, nearest_turn, wrap
from fikm_drake.kinematics.serial_chain import HasChain, SerialChain, as_chain

ROUNDING = 1e-12
"""How far an axis may be from z, and how short a link is none [m]."""


class Planar3R:
    """A planar arm with three revolute joints about z: lengths, limits, postures.

    Link k carries the next joint, or the tool, at `lengths[k]` from joint k. The *bent angles*
    q + `offsets` turn each link against the one before it and the first against x; they are the
    joint positions themselves where the table has links along x and no offsets.

    Args:
        arm: the arm; offsets along z do not matter.

    Raises:
        ValueError: the arm has other joints, other axes, or a link without length.
    """

    def __init__(self, arm: SerialChain | HasChain) -> None:
        arm = as_chain(arm)
        if arm.kinds != ("revolute",) * 3:
            raise ValueError(
                f"arm {arm.name!r} must have three revolute joints, has {list(arm.kinds)}"
            )
        origins = arm.before
        if not all(origin[2, 2] > 1.0 - ROUNDING for origin in origins):
            raise ValueError(f"arm {arm.name!r} must be planar: all axes along the base's z")
        links = np.array([X[:2, 3] for X in (*origins[1:], arm.tool)])
        self.lengths = np.hypot(links[:, 0], links[:, 1])
        """(3,) distances from joint to joint and to the tool [m]."""
        if self.lengths.min() < ROUNDING:
            raise ValueError(f"arm {arm.name!r} has a link without length: {self.lengths} m")
        self.base = origins[0][:2, 3]
        """(2,) axis of joint 1 in the base frame [m]."""
        along = np.arctan2(links[:, 1], links[:, 0])
        turned = np.array([np.arctan2(X[1, 0], X[0, 0]) for X in origins])
        self.offsets = wrap(turned + np.diff(along, prepend=0.0))
        """(3,) bent angles at q = 0 [rad]."""
        self.lower, self.upper = arm.lower, arm.upper
        self.middle = middle_of_limits(self.lower, self.upper)
        """(3,) middle of the limits; half a turn from the only limit, zero without any [rad]."""

    def postures(self, points: ArrayLike, theta_1: ArrayLike) -> Array:
        """The two postures that bring the tool to a point with joint 1 at a given position.

        Args:
            points: (…,2) [m].
            theta_1: (…), position of joint 1 [rad].

        Returns:
            (…,2,3) [rad]: first the posture with the elbow of joint 3 bent to the left (θ3 + offset
            in [0, π]), then to the right; NaN where the point is too far or too near. Joints 2 and 3
            are inside their limits if a whole turn can bring them there.
        """
        points, theta_1 = np.asarray(points, dtype=float), np.asarray(theta_1, dtype=float)
        first, second, third = self.lengths
        angle = theta_1 + self.offsets[0]
        x = points[..., 0] - self.base[0] - first * np.cos(angle)
        y = points[..., 1] - self.base[1] - first * np.sin(angle)
        bend = np.pi - triangle_angle(second, third, np.hypot(x, y))
        ahead = np.arctan2(third * np.sin(bend), second + third * np.cos(bend))
        towards = np.arctan2(y, x) - angle
        q = np.empty((*bend.shape, 2, 3))
        q[..., 0] = theta_1[..., None]
        q[..., 0, 1], q[..., 1, 1] = towards - ahead, towards + ahead
        q[..., 0, 2], q[..., 1, 2] = bend, -bend
        q[..., 1:] -= self.offsets[1:]
        q[..., 1:] += nearest_turn(q[..., 1:], self.middle[1:])
        return q

    def self_motion(self, q: ArrayLike) -> Array:
        """Direction of motion that leaves the tool where it is, joint 1 forward.

        Args:
            q: (…,3) [rad].

        Returns:
            (…,3), the null vector of the position's Jacobian [m²]; its first element is zero where
            links 2 and 3 are in line.
        """
        second, third = np.moveaxis((np.asarray(q, dtype=float) + self.offsets)[..., 1:], -1, 0)
        a, b, c = self.lengths
        from_3, from_2 = b * c * np.sin(third), a * c * np.sin(second + third)
        null = np.stack([from_3, -from_3 - from_2, a * b * np.sin(second) + from_2], axis=-1)
        return null * np.where(from_3 < 0.0, -1.0, 1.0)[..., None]

    def is_inside(self, q: Array, slack: float = 0.0) -> Bools:
        """Which postures (…,3) are within the limits, give or take `slack` [rad]; NaN is not."""
        return np.all((q >= self.lower - slack) & (q <= self.upper + slack), axis=-1)


def triangle_angle(a: ArrayLike, b: ArrayLike, opposite: ArrayLike) -> Array:
    """Angle [rad] between the sides `a` and `b` of a triangle; NaN where there is no triangle.

    By half angles: precise for flat triangles too, where the law of cosines is not. A triangle that
    fails to close by a rounding error is flat.
    """
    a, b, c = np.asarray(a, dtype=float), np.asarray(b, dtype=float), np.asarray(opposite)
    slack = 1e-14 * (a + b + c) ** 2
    near = (c - a + b) * (c + a - b)
    far = (a + b + c) * (a + b - c)
    with np.errstate(invalid="ignore"):
        near = np.sqrt(np.where((near < 0.0) & (near > -slack), 0.0, near))
        far = np.sqrt(np.where((far < 0.0) & (far > -slack), 0.0, far))
    return 2.0 * np.arctan2(near, far)
