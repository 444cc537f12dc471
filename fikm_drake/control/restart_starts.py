"""Postures from which a restart search starts, the most promising first."""

from collections.abc import Callable
from typing import Any

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.kinematics.angles import nearest_turn

STARTS = 40
"""Postures from which the search starts before it gives up [-]."""
WAY = 0.035
"""A radian of way, at `pace` of what the slowest joint lets it, counts as this much of the
longest error [1/rad]."""


class RestartStarts:
    """Fixed random postures over the joints' ranges, in the order of how near their tools are and how soon.

    Args:
        errors: (target, postures (N,n)) to the lengths of the task error (N,) [m].
        lower: lower joint limits (n,) [rad or m]; −inf for none.
        upper: upper joint limits (n,) [rad or m]; inf for none.
        pace: largest joint motion in a cycle on the way [rad or m].
        turning: joints that take the same posture after a whole turn (n,); None: none does.
        longest_error: that the task can have, about [m].
        limits: of the joints, which shorten a step of the way as a whole; None: only the pace does.
    """

    def __init__(
        self,
        errors: Callable[[Any, Array], Array],
        *,
        lower: Array,
        upper: Array,
        pace: float,
        turning: Bools | None,
        longest_error: float,
        limits: JointLimits | None,
    ) -> None:
        self._errors, self._longest_error = errors, longest_error
        self._lower, self._upper, self._pace, self._limits = lower, upper, pace, limits
        self._turning = np.zeros(len(lower), bool) if turning is None else turning
        # Joints without a limit start within half a turn of where they are.
        self._free = ~np.isfinite(upper - lower)
        low, high = (np.where(self._free, sign * np.pi, x) for sign, x in ((-1, lower), (1, upper)))
        self._starts = low + (high - low) * np.random.default_rng(0).random((STARTS, len(lower)))

    def __call__(self, desired: Any, q: Array) -> Array:
        """The postures (`STARTS`,n) for a target and joints at q (n,), the first one first."""
        starts = self._starts + np.where(self._free, q, 0.0)
        starts = np.clip(starts, self._lower, self._upper)
        sizes = self._errors(desired, starts) / self._longest_error
        sizes += WAY * self._pace * self.cycles(q, self.unwound(starts, q))
        ordered: Array = starts[np.argsort(sizes, kind="stable")]
        return ordered

    def cycles(self, q: Array, postures: Array) -> Array:
        """Cycles that the straight ways to postures (…,n) take (…,), at the pace of their slowest joints."""
        way = np.abs(postures - q)
        longest = way.max(axis=-1)
        if self._limits is None:
            return longest / self._pace
        steps = way * (self._pace / np.maximum(longest, 1e-300))[..., None]
        excess = (steps / np.maximum(self._limits.fastest, 1e-300)).max(axis=-1)
        return longest / self._pace * np.maximum(excess, 1.0)

    def unwound(self, posture: Array, q: Array) -> Array:
        """Postures (…,n), their joints that turn as few turns from q (n,) as their limits allow."""
        near = posture + np.where(self._turning, nearest_turn(posture, q), 0.0)
        return np.where((near >= self._lower) & (near <= self._upper), near, posture)
