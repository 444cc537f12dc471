"""What `trace_self_motion` returns."""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_joint
from fikm_drake.solvers.self_motion.curve import CurvePoint, SelfMotionCurve
from fikm_drake.solvers.self_motion.events import root_between
from fikm_drake.solvers.self_motion.interval_table import FeasibleInterval
from fikm_drake.solvers.self_motion.polyline import interpolate
from fikm_drake.solvers.self_motion.walk import CLOSED


class SelfMotionStatus(IntEnum):
    """How a trace ended; 0 is kept for INVALID_INPUT, which here raises ValueError."""

    TRACED = 1
    """Every component that was found is traced from end to end."""
    INFEASIBLE = 2
    """Postures reach the target, none of them within the limits."""
    UNREACHABLE = 3
    """No posture was found that reaches the target; that does not prove that there is none."""
    INCOMPLETE = 4
    """A component ends in a singular posture, or is too long: there may be more behind it."""


@dataclass(frozen=True)
class SelfMotionComponent:
    """A connected piece of a self-motion within the limits: the arm can move along all of it.

    Positions are of all n joints of the arm or plant; those that do not move the tool stay.
    """

    q: Array
    """(K,n) points of the curve [rad or m], each on it to rounding."""
    tangents: Array
    """(K,n) directions of motion, of length 1."""
    arc_length: Array
    """(K,) from the first point [rad, or m for prismatic joints: the norm of joint motion]."""
    ends: tuple[str, str]
    """What ends it at the first and at the last point: `joint j lower`, `joint j upper`, `closed`,
    `singular` or `too long`."""
    lower: Array
    """(n,) least position of each joint [rad or m]."""
    upper: Array
    """(n,) greatest position of each joint [rad or m]."""
    lower_end: tuple[str, ...]
    """(n,) what keeps each joint from less: an end of the component, or `turning point`."""
    upper_end: tuple[str, ...]
    """(n,) what keeps each joint from more."""
    curve: SelfMotionCurve = field(repr=False)
    """The curve, for points between."""

    @property
    def closed(self) -> bool:
        """True if the motion comes back to its first point."""
        return self.ends[0] == CLOSED

    @property
    def length(self) -> float:
        """Arc length of the whole [rad, or m for prismatic joints]."""
        return float(self.arc_length[-1])

    def at(self, arc_length: float) -> Array:
        """The posture (n,) at an arc length in [0, length], on the curve to rounding [rad or m].

        Raises:
            ValueError: `arc_length` is outside.
        """
        if not 0.0 <= arc_length <= self.length:
            raise ValueError(f"arc_length must be in [0, {self.length}], got {arc_length!r}")
        at = np.array([arc_length])
        guess = interpolate(self.q, self.tangents, self.arc_length, at)[0]
        moving = self.curve.task.moving
        row = self.tangents[max(int(np.searchsorted(self.arc_length, arc_length)) - 1, 0), moving]
        point = self.curve.solve(guess[moving], row, float(row @ guess[moving]))
        q = guess if point is None else self.curve.task.full(point.q, self.q[0])
        return np.clip(q, self.lower, self.upper)

    def with_joint_at(self, joint: int, position: float) -> Array:
        """The postures (M,n) of the component with a joint at a position [rad or m].

        A joint that turns back and is past `position` only between two points of `q` is not seen.

        Args:
            joint: its index, from 0.
            position: where it is to be [rad or m].
        """
        moving = self.curve.task.moving

        def away(point: CurvePoint) -> float:
            return float(self.curve.task.full(point.q, self.q[0])[joint] - position)

        points = [CurvePoint(*pair) for pair in zip(self.q[:, moving], self.tangents[:, moving])]
        past = self.q[:, joint] > position
        found = [
            self.curve.task.full(root_between(self.curve, here, there, away).q, self.q[0])
            for here, there, crossed in zip(points, points[1:], past[1:] != past[:-1])
            if crossed
        ]
        return np.clip(np.reshape(found, (-1, self.q.shape[1])), self.lower, self.upper)

    def closest_to(self, reference: ArrayLike) -> Array:
        """The posture (n,) with the least Σ (q_i − reference_i)² [rad or m].

        Args:
            reference: (n,), such as the middle of the limits.
        """
        away = self.q - np.asarray(reference, dtype=float)
        best = int(np.argmin(np.sum(away * away, axis=1)))
        moving = self.curve.task.moving
        wanted = np.asarray(reference, dtype=float)[moving]

        def rate(point: CurvePoint) -> float:
            return float((point.q - wanted) @ point.tangent)

        last = len(self.q) - 1
        neighbours = [(best - 1, best), (best, best + 1)]
        if self.closed:
            neighbours = [((i % last), (i % last) + 1) for i, _ in neighbours]
        for i, j in neighbours:
            if i < 0 or j > last:
                continue
            here, there = (CurvePoint(self.q[k, moving], self.tangents[k, moving]) for k in (i, j))
            if rate(here) < 0.0 < rate(there):
                point = root_between(self.curve, here, there, rate)
                return self.curve.task.full(point.q, self.q[0])
        return self.q[best].copy()


@dataclass(frozen=True)
class SelfMotion:
    """The self-motion of an arm at a target, within the limits of its joints."""

    status: SelfMotionStatus
    """How the trace ended."""
    components: list[SelfMotionComponent]
    """The connected pieces; first the one of the posture that was given, if it is within limits."""

    def intervals(self, joint: int) -> list[FeasibleInterval]:
        """Positions of a joint that some component takes, as disjoint intervals in ascending order.

        Args:
            joint: its index, from 0.

        Raises:
            ValueError: there is no such joint.
        """
        if self.components:
            check_joint(joint, self.components[0].q.shape[1])
        parts = sorted(
            (
                FeasibleInterval(
                    float(c.lower[joint]),
                    float(c.upper[joint]),
                    c.lower_end[joint],
                    c.upper_end[joint],
                )
                for c in self.components
            ),
            key=lambda part: part.lower,
        )
        merged: list[FeasibleInterval] = []
        for part in parts:
            if merged and part.lower <= merged[-1].upper:
                low = merged.pop()
                high = part if part.upper > low.upper else low
                part = FeasibleInterval(low.lower, high.upper, low.lower_end, high.upper_end)
            merged.append(part)
        return merged

    def closest_to(self, reference: ArrayLike) -> Array | None:
        """The posture (n,) of all components that is closest to a reference (n,); None without any."""
        wanted = np.asarray(reference, dtype=float)
        found = [component.closest_to(wanted) for component in self.components]
        return min(found, key=lambda q: float(np.sum((q - wanted) ** 2)), default=None)
