"""Joints draw back from their limits while the tool is far from its target."""

from math import inf

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.box_step import least_in_box
from fikm_drake.control.joint_limits import StepBox
from fikm_drake.control.steps import length
from fikm_drake.laws.quadratic import Quadratic

FAR, FARTHEST = 0.02, 0.2
"""Errors over the arm's reach between which the tool counts as far more and more [-]."""
STEEP = 6
"""Power with which the retreat grows from the middle of the limits to a limit [-]."""


class LimitRetreat:
    """A weak pull of each joint to the middle of its limits, which ends before the target.

    The rule is: the nearer a joint is to a limit and the farther the tool is from its target, the more the
    joint is drawn to the middle. It is added to what the law minimises, as

        ½ Σ_j w s² c_j |(q_j − middle_j) / half range_j|⁶ (dθ_j − (middle_j − q_j))²

    with w the strength, c_j the law's metric of the joints, and s from 0, where the error is `FAR` of the
    arm's reach, to 1 at `FARTHEST`. The minimum is taken inside the limits, exactly (`box_step`): a
    joint at its limit lets go as soon as that brings the tool nearer. So joints that the task can spare turn
    away from their limits on the way, before they are caught in a corner of them. Near the target, and
    behind a target that moves, there is no pull: unless a limit is in the way, the step is the law's to the
    last bit.

    Args:
        lower: lower limits (n,) [rad or m]; −inf for none.
        upper: upper limits (n,) [rad or m]; inf for none.
        strength: w [-].
        reach: of the arm [m].
        margin: distance from a limit within which a joint that moves toward it slows down in
            proportion [rad or m]; at most a quarter of the joint's range. 0: it stops there at once.
    """

    def __init__(
        self, lower: Array, upper: Array, *, strength: float, reach: float, margin: float
    ) -> None:
        both = np.isfinite(lower) & np.isfinite(upper)
        low, high = np.where(both, lower, -1.0), np.where(both, upper, 1.0)
        self._middle = np.where(both, 0.5 * (low + high), 0.0)
        self._half = np.where(both & (high > low), 0.5 * (high - low), inf)
        self._lower, self._upper = lower, upper
        self.zone = np.maximum(np.minimum(margin, 0.25 * (upper - lower)), 1e-12)
        """Where joints slow down (n,) [rad or m]."""
        self._strength, self._reach = strength, reach
        self.near = FAR * reach
        """An error up to this length draws nothing back [m]."""

    @property
    def numbers(self) -> tuple[Array, ...]:
        """What the native kernel takes: the limits, the middle and half of the range, the zones (n,) each."""
        return self._lower, self._upper, self._middle, self._half, self.zone

    @property
    def options(self) -> tuple[float, ...]:
        """Its other numbers, as `native/limits.h` lists them."""
        return self.near, self._strength, self._reach, FAR, FARTHEST, STEEP

    def bounds(self, box: StepBox, q: Array) -> tuple[Array, Array]:
        """The least and the greatest step (n,), (n,): those of the box, narrowed by the margin [rad or m]."""
        low, high = box.steady_bounds
        fastest = np.minimum(
            box.limits.fastest, 1.0 / self.zone
        )  # no speed limit: a finite product
        down = np.minimum(np.maximum((q - self._lower) / self.zone, 0.0), 1.0)
        up = np.minimum(np.maximum((self._upper - q) / self.zone, 0.0), 1.0)
        return np.maximum(low, -fastest * down), np.minimum(high, fastest * up)

    def step(self, quadratic: Quadratic, q: Array, error: Array, low: Array, high: Array) -> Array:
        """The joint step (n,) between `low` and `high` that is least, with the pull [rad or m].

        Args:
            quadratic: what the law minimises.
            q: joint positions (n,) [rad or m].
            error: task error (m,) [m].
            low: (n,) [rad or m].
            high: (n,) [rad or m].
        """
        H, g, columns = quadratic
        size = length(error)
        if size > self.near:
            share = (min(size / self._reach, FARTHEST) - FAR) / (FARTHEST - FAR)
            way = self._middle - q
            pull = self._strength * share**2 * columns * np.abs(way / self._half) ** STEEP
            H, g = H.copy(), g + pull * way
            H.ravel()[:: len(q) + 1] += pull
        return least_in_box(H, g, low, high)
