"""The least-squares step inside the limits, exactly: a quadratic in a box."""

import numpy as np

from fikm_drake.arrays import Array, all_finite

ROUNDING = 1e-12
"""A joint that is past a bound by this fraction of the box's size is at it [-]."""
BLOCKS = 3
"""Passes without fewer wrong joints after which one joint at a time is put right [-]."""
PASSES = 12
"""At most, for each joint; then the step is cut off at the bounds [-]."""


def least_in_box(H: Array, g: Array, low: Array, high: Array) -> Array:
    """The x (n,) that minimises ½ xᵀ H x − gᵀ x with low ≤ x ≤ high.

    Joints are free or fixed at a bound. In each pass the free ones take their minimum; those that pass a
    bound are fixed at it, those fixed that would rather move inward are freed: all that are wrong at once,
    or, where that makes no headway, the last of them, which always comes to an end (Murty 1974, Júdice &
    Pires 1994). Few joints are ever wrong: two or three passes are usual.

    So a joint at its bound lets go as soon as the others have reason for it, and the error never grows:
    both fail where bounds are only added (`control.saturation`).

    Args:
        H: symmetric, positive definite (n,n).
        g: (n,).
        low: (n,).
        high: (n,), not below `low`.

    Returns:
        (n,) inside the bounds; zeros, moved inside them, if H or g is not finite or H is singular.

    Example:
        >>> import numpy as np
        >>> H = np.array([[2.0, 1.0], [1.0, 2.0]])
        >>> least_in_box(H, np.array([3.0, 3.0]), np.full(2, -1.0), np.array([0.5, 9.0])).tolist()
        [0.5, 1.25]
    """
    n = len(g)
    if not (np.isfinite(H).all() and all_finite(g)):
        return np.minimum(np.maximum(0.0, low), high)
    slack = ROUNDING * (high - low)
    side, fewest, patience = np.zeros(n, dtype=int), n + 1, BLOCKS
    x = np.zeros(n)
    for _ in range(PASSES * n):
        free = side == 0
        x = np.where(side < 0, low, high)
        x[free] = 0.0
        try:
            x[free] = np.linalg.solve(H[np.ix_(free, free)], (g - H.dot(x))[free])
        except np.linalg.LinAlgError:
            x = np.full(n, np.nan)
        if not np.isfinite(x).all():
            return np.minimum(np.maximum(0.0, low), high)
        pull = g - H.dot(x)  # of a fixed joint: outward if it belongs there
        below, above = x < low - slack, x > high + slack
        wrong = np.where(free, below | above, (side * pull < 0.0) & (low < high))
        count = int(wrong.sum())
        if not count:
            break
        if count < fewest:
            fewest, patience = count, BLOCKS
        else:
            patience -= 1
        if patience < 0:
            wrong &= np.arange(n) == np.flatnonzero(wrong)[-1]
        side = np.where(wrong, np.where(free, np.where(below, -1, 1), 0), side)
    return np.minimum(np.maximum(x, low), high)
