"""Limits of position, speed and acceleration of a joint command."""

from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array

FARTHEST = 1e9
"""A joint without a position limit goes no farther, so that a command keeps its digits [rad or m]."""

NEAR = 1e-6
"""Nearer to a limit than this the bounds decide, joint by joint [rad or m]."""

SURE = 1.0 - 1e-12
"""Leaves rounding a place [-]."""


class JointLimits:
    """What a joint step of this cycle may be, so that the arm can always stop inside its limits.

    `step_bounds` is the law of the limits: a box of steps, never empty, that holds the shortest
    stop. The guard of a cycle keeps to it; `control.saturation` solves for the other joints where one is at
    its bound.

    `integrate` is for steps of which nothing more is known: one that is too fast for a joint is shortened
    as a whole, which keeps its direction. With limits of acceleration each joint's step then changes
    by no more than they allow from the last one, and is no longer than what can be braked before the joint's
    limit; and the whole is shortened so that it can be braked within its own length, since that is
    what is known of the way to the target.

    Args:
        lower: lower position limits (n,) [rad or m]; −inf for none.
        upper: upper position limits (n,) [rad or m]; inf for none.
        period: of the control cycle [s].
        velocity_limits: largest speed, one for all joints or (n,) [rad/s or m/s].
        acceleration_limits: largest acceleration, one for all joints or (n,) [rad/s² or m/s²].

    Raises:
        ValueError: a limit is not positive or of another size.
    """

    def __init__(
        self,
        lower: Array,
        upper: Array,
        *,
        period: float,
        velocity_limits: ArrayLike = inf,
        acceleration_limits: ArrayLike = inf,
    ) -> None:
        self.lower, self.upper = np.maximum(lower, -FARTHEST), np.minimum(upper, FARTHEST)
        self.period = period
        n = len(self.lower)
        self.fastest = each_limit("velocity_limits", velocity_limits, n) * period
        self._slowest = -self.fastest
        self.change = each_limit("acceleration_limits", acceleration_limits, n) * period**2
        self.brakes = bool(np.isfinite(self.change).any())
        """Whether a joint has a limit of acceleration."""
        self._fast = bool(np.isfinite(self.fastest).any())
        self._all_may = float(self.fastest.min())
        self._ends = self.lower.tolist(), self.upper.tolist()

    def room(self, position: Array) -> float:
        """A step that is shorter than this is inside the bounds and leads to no limit [rad or m].

        It spares the bounds to most cycles. Zero near a limit, and with limits of acceleration.

        Args:
            position: of the command (n,) [rad or m].
        """
        if self.brakes:
            return 0.0
        room = self._all_may
        for q, lower, upper in zip(position.tolist(), *self._ends):
            if q - lower < room:
                room = q - lower
            if upper - q < room:
                room = upper - q
        return SURE * room if room > NEAR else 0.0

    def step_bounds(self, position: Array, velocity: Array) -> tuple[Array, Array]:
        """The least and the greatest step (n,), (n,) of each joint in this cycle [rad or m].

        Never empty: a joint that kept to these bounds before can go on to do so, and limits of position
        and speed come before those of acceleration for one that did not. A joint that is beyond a
        limit, as a robot may be at the start, may not go farther out; nothing makes it jump back.

        Args:
            position: of the command (n,) [rad or m].
            velocity: the change of the command in the last cycle over the period (n,) [rad/s or m/s].
        """
        return self.changing_bounds(*self.steady_bounds(position), velocity)

    def steady_bounds(self, position: Array) -> tuple[Array, Array]:
        """The same (n,), (n,) by the limits of position and speed alone, whatever the last step was."""
        low = np.minimum(self.lower - position, 0.0)
        high = np.maximum(self.upper - position, 0.0)
        if self.brakes:
            low, high = -self.braking(-low), self.braking(high)
        if self._fast:
            low, high = np.maximum(low, self._slowest), np.minimum(high, self.fastest)
        return low, high

    def changing_bounds(self, low: Array, high: Array, velocity: Array) -> tuple[Array, Array]:
        """The bounds of `steady_bounds`, narrowed to what acceleration allows after the last step."""
        if not self.brakes:
            return low, high
        last = velocity * self.period
        slower, faster = last - self.change, last + self.change
        return (
            np.minimum(np.maximum(low, slower), high),
            np.maximum(np.minimum(high, faster), low),
        )

    def brakeable(self, step: Array) -> Array:
        """The step (n,), shortened as a whole so that each joint's can be braked within its own length.

        Nothing else is known of the way to the target, so this is where an arm with limits of acceleration
        begins to brake before it. Without such limits it is the step itself. `control.saturation` lets
        the others go on where one joint brakes slowly.
        """
        return self._shorten(step, self.braking(np.abs(step))) if self.brakes else step

    def shorten(self, step: Array) -> Array:
        """The step (n,), shortened as a whole to the speed that every joint may have."""
        return self._shorten(step, self.fastest) if self._fast else step

    def add(self, position: Array, step: Array) -> Array:
        """The position (n,) after a step that a guard let through; rounding takes it no farther out."""
        low, high = np.minimum(self.lower, position), np.maximum(self.upper, position)
        return np.minimum(np.maximum(position + step, low), high)

    def integrate(self, position: Array, step: Array, velocity: Array) -> Array:
        """The position (n,) after the step, as far as it is allowed.

        Args:
            position: joint positions (n,) inside the limits [rad or m].
            step: the joint step that is asked for (n,) [rad or m].
            velocity: the change of the position in the last cycle over the period (n,) [rad/s or m/s].
        """
        step = self._rate(position, step, velocity)
        return np.minimum(np.maximum(position + step, self.lower), self.upper)

    def limits(self, position: Array, step: Array, velocity: Array) -> bool:
        """True if a limit takes away a part of the step; the arguments are those of `integrate`."""
        moved = position + step
        if (moved < self.lower).any() or (moved > self.upper).any():
            return True
        return bool((self._rate(position, step, velocity) != step).any())

    def _rate(self, position: Array, step: Array, velocity: Array) -> Array:
        step = self.shorten(self.brakeable(step))
        if not self.brakes:
            return step
        low, high = self.step_bounds(position, velocity)
        return np.minimum(np.maximum(step, low), high)

    @staticmethod
    def _shorten(step: Array, longest: Array) -> Array:
        excess = float((np.abs(step) / np.maximum(longest, 1e-300)).max())
        return step / excess if excess > 1.0 else step

    def braking(self, distance: Array) -> Array:
        """The longest step (n,) after which a stop within `distance` (n,) is possible.

        A step s in k·change ≤ s < (k + 1)·change and the shorter ones that follow, each by `change`,
        cover (k + 1) s − ½ k (k + 1)·change.
        """
        a = self.change
        with np.errstate(invalid="ignore"):
            k = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * distance / a) - 1.0))
            step = distance / (k + 1.0) + 0.5 * k * a
        return np.where(np.isfinite(step), step, distance)

    def braked_in(self, cycles: float) -> Array:
        """The longest step (n,) that is braked to nothing in so many cycles [rad or m]."""
        return cycles * self.change

    def braking_cycles(self, step: Array) -> Array:
        """Cycles in which a step of these lengths (n,) is braked to nothing (n,) [-]."""
        return step / self.change


class StepBox:
    """The steps that limits allow in one cycle; the bounds are worked out if somebody asks for them.

    Args:
        limits: of the joints.
        command: joint positions (n,) [rad or m].
    """

    def __init__(self, limits: JointLimits, command: Array) -> None:
        self.limits, self._command = limits, command
        self._room = limits.room(command)

    def surely_holds(self, length: float) -> bool:
        """True if a step of this length is inside all bounds, whatever its direction; False says nothing."""
        return length < self._room

    @cached_property
    def steady_bounds(self) -> tuple[Array, Array]:
        """See `JointLimits.steady_bounds`."""
        return self.limits.steady_bounds(self._command)

    def bounds(self, velocity: Array) -> tuple[Array, Array]:
        """See `JointLimits.step_bounds`."""
        return self.limits.changing_bounds(*self.steady_bounds, velocity)


def each_limit(name: str, limit: ArrayLike, size: int) -> Array:
    """A limit of each joint (n,), from one for all or n; ValueError, by `name`, unless they are positive."""
    values = np.array(limit, dtype=float)
    if values.shape not in ((), (size,)) or not (values > 0.0).all():
        raise ValueError(f"{name} must be positive, one number or {size}, got {values.tolist()}")
    return np.full(size, values)
