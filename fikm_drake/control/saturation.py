"""Joints at their bounds are fixed there, and the law solves again for the others."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Solve = Callable[[Array, Array], Array]
"""A law, or a law with its damping and weights: (J (m,n), error (m,)) to a joint step (n,)."""

GAIN = 1.02
"""The step that was solved again must bring the tool this many times as near as the shortened one [-]."""


def resolve(
    solve: Solve,
    J: Array,
    error: Array,
    step: Array,
    low: Array,
    high: Array,
    *,
    shortened: Array | None = None,
    longest: Callable[[Array], Array] | None = None,
    secondary: Array | None = None,
) -> Array:
    """A law's joint step (n,) inside bounds [rad or m]: what one joint may not do the others do.

    The joint that is farthest past its bound, for the size of the bound, is fixed at it. The law is
    asked again for what is left of the error, with the columns of J of the fixed joints set to zero,
    until no joint passes a bound or none is free: at most n times. Where that brings the tool no
    nearer than the step shortened as a whole, the shortened step is taken, which keeps the direction
    of the tool.

    One joint at a time reaches 0.94 of what the best step inside the bounds would gain (random J of
    3 to 6 rows, half of the joints too slow, pseudo-inverse), all at once 0.6 to 0.8.

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
        longest: (step (n,)) to the largest size (n,) of each joint's, beside the bounds, such as
            `JointLimits.longest` with limits of acceleration.
        secondary: null-space motion in `step` (n,) [rad or m]; the free joints keep their part.
    """
    inside = _inside(step, low, high, longest)
    if (inside == step).all():
        return step
    kept = inside if shortened is None else np.minimum(np.maximum(shortened, low), high)
    n = len(step)
    free, trial, fixed = np.ones(n), step, np.zeros(n)
    for _ in range(n):
        excess = free * np.abs(trial - inside) / (np.abs(inside) + 1e-300)
        largest = excess.max()
        if not 0.0 < largest:
            break
        over = excess == largest
        free[over], fixed[over] = 0.0, inside[over]
        trial = fixed
        if not free.any():
            break
        if secondary is not None:
            trial = trial + free * secondary
        trial = trial + np.where(free, solve(J * free, error - J.dot(trial)), 0.0)
        inside = _inside(trial, low, high, longest)
    trial = np.minimum(np.maximum(trial, low), high)
    size = _norm(error)
    near, other = (size - _norm(error - J.dot(x)) for x in (trial, kept))
    # `near` is NaN where the law's second answer is: then the first is kept.
    return trial if near > 0.0 and near > GAIN * other else kept


def _inside(
    step: Array, low: Array, high: Array, longest: Callable[[Array], Array] | None
) -> Array:
    if longest is not None:
        most = longest(step)
        step = np.minimum(np.maximum(step, -most), most)
    return np.minimum(np.maximum(step, low), high)


def _norm(vector: Array) -> float:
    return float(np.sqrt(vector.dot(vector)))
