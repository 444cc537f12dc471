"""The last word of a control cycle: no step passes that is not finite, too long or beyond a limit."""

from math import inf, sqrt

import numpy as np

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import check_positive
from fikm_drake.control.joint_limits import SURE, StepBox
from fikm_drake.control.steps import length

ROUNDED = 1.0 + 1e-14
"""The square of a step that was shortened may be as much too long [-]: it is not shortened again."""


class Guard:
    """The last function of a control cycle; nothing is added to a joint step after it.

    Whatever a law, a step aside, secondary motion or a search asks for, the step that comes out

    - is finite: what is not becomes the shortest step that the bounds allow, which is none, or with
      limits of acceleration the one that brakes;
    - is inside the bounds of this cycle, joint by joint;
    - is at most `max_joint_step` long, shortened toward that shortest step (so in its own direction
      where the joints may stand still). Only if even that one is longer, as after a limit was lowered in
      mid-motion, it stays as it is: limits of acceleration come before the length.

    A step that keeps all this comes out as it went in, to the bit.

        guard = Guard(0.5)
        low, high = limits.step_bounds(command, velocity)
        command += guard(joint_step, low, high)

    Args:
        max_joint_step: the greatest Euclidean length of a joint step [rad or m].

    Raises:
        ValueError: it is not positive.
    """

    def __init__(self, max_joint_step: float = inf) -> None:
        self.max_joint_step = check_positive("max_joint_step", max_joint_step)

    def surely_passes(self, step: Array, box: StepBox) -> bool:
        """True if a step (n,) is so short that it passes as it is; False says nothing."""
        size = length(step)
        return size <= self.max_joint_step * SURE and box.surely_holds(size)

    def __call__(self, step: Array, low: Array, high: Array) -> Array:
        """The step (n,) that is taken [rad or m].

        Args:
            step: what is asked for (n,) [rad or m]; anything, NaN included.
            low: least step of each joint (n,) [rad or m], as of `JointLimits.step_bounds`.
            high: greatest step of each joint (n,) [rad or m], not below `low`.
        """
        if not all_finite(step):
            return shortest(low, high)
        inside = np.minimum(np.maximum(step, low), high)
        longest = self.max_joint_step
        if inside.dot(inside) <= longest * longest * ROUNDED:
            return inside
        # From the shortest step of the box, along a straight line, up to the length.
        start = shortest(low, high)
        way = inside - start
        a, b, c = 0.0, 0.0, longest * longest
        for x, y in zip(start.tolist(), way.tolist()):  # in the kernel's order, to round as it does
            a, b, c = a + y * y, b + x * y, c - x * x
        if c <= 0.0 or a == 0.0:
            return start
        # a t² + 2 b t = c; of the root's two forms the one that does not cancel.
        root = sqrt(b * b + a * c)
        t = c / (b + root) if b > 0.0 else (root - b) / a
        return np.minimum(np.maximum(start + min(t, 1.0) * way, low), high)


def shortest(low: Array, high: Array) -> Array:
    """The shortest step (n,) between `low` and `high` (n,): zero where they leave it."""
    return np.minimum(np.maximum(0.0, low), high)
