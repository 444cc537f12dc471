"""A law's joint step, made safe."""

from functools import cache
from math import inf, isfinite, sqrt

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.limit_weights import LimitWeights
from fikm_drake.control.posture import posture_step
from fikm_drake.laws.law import Law

DEAD = 1e-3
"""A law whose step is shorter than this times the error sees no way [rad/m]."""
PASSES = 2
"""Weighted steps of a cycle: the first can turn other joints toward their limits [-]."""


class SafeStep:
    """A law's joint step that keeps away from joint limits, leaves dead points and is never too long.

    Args:
        law: the law.
        longest: a longer step is shortened to this length [rad or m].
        limits: weights of joints near their limits; None: there are none.
        posture: the preferred joint positions (n,) [rad or m]; None: there are none.
        posture_gain: the fraction of the way to them that a cycle takes, as far as the task leaves the
            joints free [-].
        singularity_nudge: motion of each joint, to one side or the other, at a dead point such as the
            stretched arm whose target lies straight inward, where the law sees no way [rad/m]. It is in
            proportion to the error, so that a supervisor that calms the error calms it too.
    """

    def __init__(
        self,
        law: Law,
        *,
        longest: float = inf,
        limits: LimitWeights | None = None,
        posture: Array | None = None,
        posture_gain: float = 0.0,
        singularity_nudge: float = 0.0,
    ) -> None:
        self._law = law.step
        self._longest = longest
        self._limits = limits
        self._posture = posture
        self._side_step = singularity_nudge
        self._dead = DEAD**2 if singularity_nudge else 0.0
        self._posture_gain = posture_gain

    def __call__(self, q: Array, J: Array, error: Array, damping: float | None = None) -> Array:
        """The joint step (n,) [rad or m]; zeros if the law's is not finite.

        Args:
            q: joint positions (n,) [rad or m].
            J: the task Jacobian at q (m,n).
            error: task error (m,) [m].
            damping: for a law that takes it [-], else None.
        """
        more = () if damping is None else (damping,)
        step = self._law(J, error, *more)
        if self._limits is not None and self._limits.near(q):
            weights = np.ones(len(q))
            for _ in range(PASSES):
                weights = np.minimum(weights, self._limits(q, step))
                step = weights * self._law(J * weights, error, *more)
        if self._posture is not None:
            step = step + posture_step(J, self._posture_gain * (self._posture - q))
        square = step.dot(step)
        if not isfinite(square):
            return np.zeros(len(step))
        if square > self._longest**2:
            return step * (self._longest / sqrt(square))
        if square < self._dead * error.dot(error):
            return step + self._side_step * sqrt(error.dot(error)) * aside(len(step))
        return step


@cache
def aside(size: int) -> Array:
    """Which way the joints (n,) step aside: neighbours against each other, as an arm folds."""
    way = np.where(np.arange(size) % 2, -1.0, 1.0)
    way.flags.writeable = False
    return way
