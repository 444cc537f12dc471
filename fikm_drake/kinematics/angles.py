"""Whole turns of angles, and the middle of limits."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array

TURN = 2.0 * np.pi


def nearest_turn(angle: ArrayLike, middle: ArrayLike) -> Array:
    """The whole turns [rad] that bring an angle nearest to `middle`."""
    return TURN * np.round((np.asarray(middle) - np.asarray(angle)) / TURN)


def wrap(angle: ArrayLike) -> Array:
    """The same direction in [−π, π] [rad]."""
    return np.asarray(angle) + nearest_turn(angle, 0.0)


def middle_of_limits(lower: Array, upper: Array) -> Array:
    """The middle (n,) of limits (n,); half a turn from the only limit, zero without any [rad]."""
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper, 0.0) - TURN)
    high = np.where(np.isfinite(upper), upper, low + TURN)
    return np.where(np.isfinite(lower) | np.isfinite(upper), 0.5 * (low + high), 0.0)
