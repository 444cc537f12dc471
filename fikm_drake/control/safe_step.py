"""A law's joint step, made safe."""

from functools import cache
from math import inf

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.control.joint_limits import StepBox
from fikm_drake.control.limit_weights import LimitWeights
from fikm_drake.control.posture import posture_step
from fikm_drake.control.saturation import BRAKING_GAIN, GAIN, brake, resolve
from fikm_drake.control.steps import length
from fikm_drake.laws.law import Law

DEAD = 1e-3
"""A law whose step is shorter than this times the error sees no way [rad/m]."""
UNMOVED = 1e-9
"""A joint whose column is below this fraction of the largest does not move the tool [-]."""
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
        self.longest = longest
        self.limits = limits
        self.posture = posture
        self.side_step = singularity_nudge
        self.dead = DEAD if singularity_nudge else 0.0
        self.posture_gain = posture_gain

    def __call__(self, q: Array, J: Array, error: Array, damping: float | None = None) -> Array:
        """The joint step (n,) [rad or m]; zeros if the law's is not finite.

        Args:
            q: joint positions (n,) [rad or m].
            J: the task Jacobian at q (m,n).
            error: task error (m,) [m].
            damping: for a law that takes it [-], else None.
        """
        step, _, _ = self._free(q, J, error, damping)
        size, asked = length(step), length(error)
        return step if self._passes(size, asked) else self._short(step, size, asked, J)

    def inside(
        self,
        q: Array,
        J: Array,
        error: Array,
        box: StepBox,
        damping: float | None = None,
        *,
        resolved: bool = True,
    ) -> tuple[Array, bool]:
        """The joint step (n,) inside limits [rad or m], and whether they took a part of it away.

        Zeros, and nothing taken away, where the error is not finite (`steps.length`).

        What a joint at its limit of position or speed may not do, or could not brake on the way that it
        has, the law does with the others, see `control.saturation`. How fast a step may change is left to
        the guard: to make up for that with other joints, in this cycle, would let the arm swing.

        Args:
            q: joint positions (n,) [rad or m].
            J: the task Jacobian at q (m,n).
            error: task error (m,) [m].
            box: what the joints may do.
            damping: for a law that takes it [-], else None.
            resolved: False: the step keeps its direction, and limits are left to what follows, since
                it knows of more than they are (`Clearance`).
        """
        asked = length(error)
        if asked == inf:
            return np.zeros(len(q)), False
        free, weights, secondary = self._free(q, J, error, damping)
        size = length(free)
        short = free if self._passes(size, asked) else self._short(free, size, asked, J)
        if box.surely_holds(size if short is free else length(short)):
            return short, False
        limits, (low, high) = box.limits, box.steady_bounds
        if not resolved:
            step = limits.brakeable(short)
            inside = (np.minimum(np.maximum(step, low), high) == step).all()
            return step, step is not short or not inside
        more = () if damping is None else (damping,)
        J = seen(J)  # else, once all others are fixed, rounding is all that is left, and moves them

        def solve(J: Array, error: Array) -> Array:
            if weights is None:
                return self._law(J, error, *more)
            return weights * self._law(J * weights, error, *more)

        if short is not free:  # the law for an error that asks for this step
            share = length(short) / max(length(free), length(short), 1e-300)
            error = share * error
            secondary = None if secondary is None else share * secondary
        step, gain = short, GAIN
        if limits.brakes:
            step, gain = brake(solve, J, error, short, limits, secondary=secondary), BRAKING_GAIN
        if (np.minimum(np.maximum(step, low), high) == step).all():
            return step, step is not short
        if step is not short:
            share = length(step) / max(length(short), length(step), 1e-300)
            error = share * error
            secondary = None if secondary is None else share * secondary
        kept = limits.shorten(step)
        return resolve(
            solve, J, error, step, low, high, shortened=kept, secondary=secondary, gain=gain
        ), True

    def _free(
        self, q: Array, J: Array, error: Array, damping: float | None
    ) -> tuple[Array, Array | None, Array | None]:
        """The step as it comes, the weights of the joints and the motion of the posture in it."""
        more = () if damping is None else (damping,)
        step, weights, secondary = self._law(J, error, *more), None, None
        if self.limits is not None and self.limits.near(q):
            weights = np.ones(len(q))
            for _ in range(PASSES):
                weights = np.minimum(weights, self.limits(q, step))
                step = weights * self._law(J * weights, error, *more)
        if self.posture is not None:
            secondary = posture_step(J, self.posture_gain * (self.posture - q))
            step = step + secondary
        return step, weights, secondary

    def _passes(self, size: float, asked: float) -> bool:
        """True if a step of this length is neither too long nor dead, for an error of length `asked`."""
        return self.dead * asked <= size <= self.longest and size < inf

    def _short(self, step: Array, size: float, asked: float, J: Array) -> Array:
        """The step no longer than the longest, aside where it is dead, zeros if it is not finite."""
        if size == inf:
            return np.zeros(len(step))
        if size > self.longest:
            return step * (self.longest / size)
        # A joint that the task does not see would drift.
        aside_too = step + self.side_step * asked * aside(len(step)) * is_seen(J)
        size = length(aside_too)
        return aside_too * (self.longest / size) if size > self.longest else aside_too


def seen(J: Array) -> Array:
    """J (m,n) without the columns of joints that do not move the tool."""
    return np.where(is_seen(J), J, 0.0)


def is_seen(J: Array) -> Bools:
    """Which joints (n,) move the tool at all, by J (m,n)."""
    reach = np.abs(J).max(axis=0)
    return np.asarray(reach > UNMOVED * reach.max())


@cache
def aside(size: int) -> Array:
    """Which way the joints (n,) step aside: neighbours against each other, as an arm folds."""
    way = np.where(np.arange(size) % 2, -1.0, 1.0)
    way.flags.writeable = False
    return way
