"""Joints at their bounds are fixed there, and the law solves again for the others."""

from collections.abc import Callable
from math import sqrt

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.joint_limits import JointLimits

Solve = Callable[[Array, Array], Array]
"""A law, or a law with its damping and weights: (J (m,n), error (m,)) to a joint step (n,)."""

PASSES = 4
"""Times that the law is asked again; what is then left past a bound is cut off [-]."""
TINY = 1e-100
"""Added to bounds before a step is compared with them, since a bound may be zero [rad or m]."""
HALF = 0.5 - 1e-9
"""Joints that are this part as far past their bounds as the farthest go with it; of equal joints rounding
does not decide [-]."""
BETTER = 1.0 + 1e-9
"""A step that brings the tool this many times as near as another is better [-]."""
GAIN = 1.02
"""The step that was solved again must bring the tool this many times as near as the shortened one [-]..."""
BRAKING_GAIN = 1.5
"""...or as this where joints have limits of acceleration: a change of direction then costs them time [-]."""


def resolve(
    solve: Solve,
    J: Array,
    error: Array,
    step: Array,
    low: Array,
    high: Array,
    *,
    shortened: Array | None = None,
    secondary: Array | None = None,
    gain: float = GAIN,
) -> Array:
    """A law's joint step (n,) inside bounds [rad or m]: what one joint may not do the others do.

    The joint that is farthest past its bound, for the size of the bound, is fixed at it, with those
    that are half as far past theirs. The law is asked again for what is left of the error, with the
    columns of J of the fixed joints set to zero, until no joint passes a bound or none is free, at
    most `PASSES` times. Where that brings the tool no nearer to the motion J · step than the step
    shortened as a whole, the shortened step is taken, which keeps the direction of the tool.

    So it reaches 0.89 to 0.94 of what the best step inside the bounds would gain (random J of 2 to 6
    rows, a third of the joints too slow, pseudo-inverse), all joints at once 0.6 to 0.8, one at a
    time, in up to n passes, 0.96.

    A step inside the bounds is returned as it is.

        step = law.step(J, error)
        low, high = limits.step_bounds(command, velocity)
        step = resolve(law.step, J, error, step, low, high, shortened=limits.shorten(step))

    Args:
        solve: the law.
        J: task Jacobian (m,n).
        error: what the law was asked for (m,) [m].
        step: what it answered, with `secondary` (n,) [rad or m].
        low: least step of each joint (n,) [rad or m].
        high: greatest step of each joint (n,) [rad or m], not below `low`.
        shortened: the alternative that keeps the direction (n,), cut off at the bounds here; None:
            `step` itself, cut off.
        secondary: null-space motion in `step` (n,) [rad or m]; the free joints keep their part.
        gain: how many times as near it must bring the tool as the shortened step does [-].
    """
    inside = np.minimum(np.maximum(step, low), high)
    if (inside == step).all():
        return step
    kept = inside if shortened is None else np.minimum(np.maximum(shortened, low), high)
    asked = J.dot(step)
    n = len(step)
    free, fixed, trial = np.ones(n, bool), np.zeros(n), step
    for _ in range(min(n, PASSES)):
        excess = np.where(free, np.abs(trial - inside) / (np.abs(inside) + TINY), 0.0)
        largest = excess.max()
        if not largest > 0.0:
            break
        over = excess >= HALF * largest
        free[over], fixed[over] = False, inside[over]
        trial = fixed if secondary is None else np.where(free, secondary, fixed)
        if free.any():
            trial = trial + np.where(free, solve(J * free, error - J.dot(trial)), 0.0)
        inside = np.minimum(np.maximum(trial, low), high)
    near, other = (_nearer(asked, J.dot(x)) for x in (inside, kept))
    # `near` is NaN where the law's second answer is: then the first is kept.
    return inside if near > 0.0 and near > gain * other else kept


def brake(
    solve: Solve,
    J: Array,
    error: Array,
    step: Array,
    limits: JointLimits,
    *,
    secondary: Array | None = None,
) -> Array:
    """A law's joint step (n,) that can be braked within its own length [rad or m].

    Joints that are slow to brake hold back the others if the whole step is shortened for them. They get
    what they can brake while the others do, and the law is asked again for the rest with the others,
    shortened as a whole for the slowest of these; the slowest of what is left are slow in turn, at most
    `PASSES` times. Where that does not bring the tool `BRAKING_GAIN` times as near, as where all joints
    are alike, the whole step is shortened, which keeps its direction.

    Args:
        solve: the law.
        J: task Jacobian (m,n).
        error: what the law was asked for (m,) [m].
        step: what it answered, with `secondary` (n,) [rad or m].
        limits: of the joints.
        secondary: null-space motion in `step` (n,) [rad or m].
    """
    kept = limits.brakeable(step)
    if kept is step:
        return step
    asked = J.dot(step)
    best, most = kept, BRAKING_GAIN * _nearer(asked, J.dot(kept))
    free, fixed, trial = np.ones(len(step), bool), np.zeros(len(step)), step
    for _ in range(PASSES):
        sizes = np.abs(trial)
        longest = limits.braking(sizes)
        excess = np.where(free, sizes / (longest + TINY), 0.0)
        slow = free & (excess >= HALF * excess.max())
        free &= ~slow
        if not free.any():
            break
        cycles = max(1.0, float(limits.braking_cycles(longest)[free].max()))
        longest = np.minimum(longest, limits.braked_in(cycles))
        fixed[slow] = np.copysign(np.minimum(sizes, longest), trial)[slow]
        rest = fixed if secondary is None else np.where(free, secondary, fixed)
        rest = rest + np.where(free, solve(J * free, error - J.dot(rest)), 0.0)
        trial = np.where(free, limits.brakeable(np.where(free, rest, 0.0)), fixed)
        near = _nearer(asked, J.dot(trial))
        if near > BETTER * most:
            best, most = trial, near
        trial = rest
    return best


def _nearer(asked: Array, motion: Array) -> float:
    """|asked| − |asked − motion| of vectors (m,) [m], to all digits where the motion is small, too."""
    rest = asked - motion
    sizes = sqrt(asked.dot(asked)) + sqrt(rest.dot(rest))
    return float((asked + rest).dot(motion)) / sizes if sizes > 0.0 else 0.0
