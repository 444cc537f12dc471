"""What a law minimises, for what looks for the minimum inside limits."""

from collections.abc import Callable
from math import hypot
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.law import Law

LEAST = 1e-9
"""Damping² is at least this fraction of H's size, so that one step is the least [-]."""


class Quadratic(NamedTuple):
    """A law's step as the minimum of ½ dθᵀ H dθ − gᵀ dθ."""

    H: Array
    """(n,n), symmetric, positive definite."""
    g: Array
    """(n,)."""
    columns: Array
    """The metric of the joints (n,): H is the task's part and damping² times it."""


QuadraticOf = Callable[[Array, Array, float], Quadratic]
"""Jacobian (m,n), task error (m,) and more damping to what the step minimises."""


def quadratic_of(law: Law, num_rows: int) -> QuadraticOf | None:
    """What a law minimises; None: it is of no such kind.

    It is known of `DampedLeastSquares`, and of the indirect `FuzzyMapping` with one iteration, where
    H = C, or with as many as there are rows, where H = Jᵀ R⁻¹ J + λ² C; g = Jᵀ R⁻¹ dr.

    Args:
        law: the law.
        num_rows: m.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> from fikm_drake.laws.quadratic import quadratic_of
        >>> law, J, dr = fd.FuzzyMapping.iterated(), np.array([[1.0, 0.5]]), np.array([0.1])
        >>> H, g, _ = quadratic_of(law, 1)(J, dr, 0.0)
        >>> bool(np.allclose(np.linalg.solve(H, g), law.step(J, dr)))
        True
    """
    if type(law) is DampedLeastSquares:
        square = law.damping * law.damping  # `**` raises where that is too large
        return lambda J, dr, damping: _least_squares(J, dr, square)
    if type(law) is FuzzyMapping and law.method == "indirect":
        mapping = law
        if law.iterations == 1:
            return lambda J, dr, damping: _one_iteration(mapping, J, dr, damping)
        if law.iterations >= num_rows:
            return lambda J, dr, damping: _iterated(mapping, J, dr, damping)
    return None


def _least_squares(J: Array, dr: Array, square: float) -> Quadratic:
    H, n = J.T.dot(J), J.shape[1]
    H.ravel()[:: n + 1] += max(square, LEAST * float(np.trace(H)))
    return Quadratic(H, dr.dot(J), np.ones(n))


def _one_iteration(law: FuzzyMapping, J: Array, dr: Array, damping: float) -> Quadratic:
    rows, columns, J = _scaled(law, J, hypot(law.row_floor, damping))
    return Quadratic(np.diag(columns), (dr / rows).dot(J), columns)


def _iterated(law: FuzzyMapping, J: Array, dr: Array, damping: float) -> Quadratic:
    rows, columns, J = _scaled(law, J, law.row_floor)
    turn = dr / rows
    far = law.added_damping(turn)
    H = J.T.dot(J / rows[:, None])
    square = law.damping * law.damping + damping * damping + far * far
    H.ravel()[:: len(columns) + 1] += max(square, LEAST) * columns
    return Quadratic(H, turn.dot(J), columns)


def _scaled(law: FuzzyMapping, J: Array, floor: float) -> tuple[Array, Array, Array]:
    """R (m,), C (n,) and J without the rows and columns whose sums are zero."""
    A = np.abs(J)
    rows, no_row = _raised(A.sum(axis=1), floor, law.zero_threshold)
    columns, no_column = _raised(A.sum(axis=0), law.column_floor, law.zero_threshold)
    return rows, columns, np.where(no_row[:, None] | no_column, 0.0, J)


def _raised(sums: Array, floor: float, zero_threshold: float) -> tuple[Array, Bools]:
    """The sums raised by a floor, and which of them are zero: these count as the largest."""
    largest = float(sums.max())
    raised = np.hypot(sums, floor * largest)
    zero: Bools = raised <= zero_threshold * largest
    return np.where(zero, largest or 1.0, raised), zero
