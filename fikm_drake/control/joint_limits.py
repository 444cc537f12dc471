"""Limits of position, speed and acceleration of a joint command."""

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array


class JointLimits:
    """Adds joint steps to a position, held to limits so that the arm can always stop inside them.

    A step that is too fast for a joint is shortened as a whole, which keeps its direction. With limits
    of acceleration each joint's step then changes by no more than they allow from the last one, and is
    no longer than what can be braked before the joint's limit; and the whole is shortened so that it
    can be braked within its own length, since that is what is known of the way to the target.

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
        self.lower, self.upper = lower, upper
        self._period = period
        n = len(lower)
        self._fastest = _each("velocity_limits", velocity_limits, n) * period
        self._change = _each("acceleration_limits", acceleration_limits, n) * period**2
        self._brakes = bool(np.isfinite(self._change).any())
        self._rated = self._brakes or bool(np.isfinite(self._fastest).any())

    def integrate(self, position: Array, step: Array, velocity: Array) -> Array:
        """The position (n,) after the step, as far as it is allowed.

        Args:
            position: joint positions (n,) inside the limits [rad or m].
            step: the joint step that is asked for (n,) [rad or m].
            velocity: the change of the position in the last cycle over the period (n,) [rad/s or m/s].
        """
        if self._rated:
            step = self._rate(position, step, velocity)
        return np.minimum(np.maximum(position + step, self.lower), self.upper)

    def limits(self, position: Array, step: Array, velocity: Array) -> bool:
        """True if a limit takes away a part of the step; the arguments are those of `integrate`."""
        moved = position + step
        if (moved < self.lower).any() or (moved > self.upper).any():
            return True
        return self._rated and bool((self._rate(position, step, velocity) != step).any())

    def _rate(self, position: Array, step: Array, velocity: Array) -> Array:
        size = np.abs(step)
        fastest = self._fastest
        if self._brakes:
            fastest = np.minimum(fastest, self._braking(size))
        excess = float((size / np.maximum(fastest, 1e-300)).max())
        if excess > 1.0:
            step = step / excess
        if not self._brakes:
            return step
        last = velocity * self._period
        step = np.clip(step, last - self._change, last + self._change)
        low, high = self._braking(position - self.lower), self._braking(self.upper - position)
        return np.clip(step, -low, high)

    def _braking(self, distance: Array) -> Array:
        """The longest step (n,) after which a stop within `distance` (n,) is possible.

        A step s in k·change ≤ s < (k + 1)·change and the shorter ones that follow, each by `change`,
        cover (k + 1) s − ½ k (k + 1)·change.
        """
        a = self._change
        with np.errstate(invalid="ignore"):
            k = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * distance / a) - 1.0))
            step = distance / (k + 1.0) + 0.5 * k * a
        return np.where(np.isfinite(step), step, distance)


def _each(name: str, limit: ArrayLike, size: int) -> Array:
    values = np.array(limit, dtype=float)
    if values.shape not in ((), (size,)) or not (values > 0.0).all():
        raise ValueError(f"{name} must be positive, one number or {size}, got {values.tolist()}")
    return np.full(size, values)
