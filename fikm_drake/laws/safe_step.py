"""A law's joint step, made safe."""

from collections.abc import Callable
from math import isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from fikm_drake.laws.law import Law
from fikm_drake.laws.side_step import is_dead_point, leave_dead_point

Array = NDArray[np.float64]


def safe_step(
    law: Law,
    jacobian: Callable[[Array], Array],
    q: Array,
    J: Array,
    error: Array,
    longest: float,
    aside: float,
) -> Array:
    """The law's joint step (n,): zeros if it is not finite, never too long, out of dead points.

    Args:
        law: the law.
        jacobian: q to the task Jacobian (m,n).
        q: joint positions (n,) [rad or m].
        J: the Jacobian at q (m,n).
        error: task error (m,) [m].
        longest: a longer step is shortened to this length [rad or m].
        aside: largest joint motion of a step out of a dead point [rad or m]; 0: none is taken.
    """
    step = law.step(J, error)
    square = step.dot(step)
    if not isfinite(square):
        return np.zeros(len(step))
    if square > longest * longest:
        return step * (longest / sqrt(square))
    if aside and is_dead_point(square, error.dot(error)):
        return leave_dead_point(jacobian, q, error, aside)
    return step
