"""The fewest rules for a stated true error: knots from theory, consequents from least squares.

dθ is linear in dr, so two memberships of dr are exact and what remains is one function of J. With
J = j_max s and dθ = (dr_max / j_max) t the table of equation 12 is the same for every range: the
rules read dθ = (dr / j_max) G(s), with G odd and linear between knots, and their error at (s, t) is
|t| |s G(s) - 1|. So a design is made once for each number of knots and serves every range; only
the relative error that it has to meet depends on the range.

A chord of 1/s over a short interval has a relative error in proportion to the square of the
interval's length in log s. The total over a given number of knots is least when they are evenly
spaced in the cube root of s. One number is left, the innermost knot, and is searched for. There is
no membership at J = 0: an odd function passes through zero there without one.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition
from fikm_drake.laws.rule_generation.data_table import DTHETA_LEVELS, J_STEPS, table_error
from fikm_drake.laws.rule_generation.generated_rule_base import GeneratedRuleBase

_FLOOR = 1.0 / (2 * J_STEPS + 1)  # relative error of the best model: all is lost at J = 0 only
_MAX_PAIRS = 200
_PASSES = 4


class _Design(NamedTuple):
    """Knots s in (0, 1] and heights G there, shape (pairs,), with the relative table error."""

    knots: Array
    heights: Array
    error: float


def _fit(knots: Array) -> _Design:
    """Fits the heights by least squares, reweighted a few times towards the mean absolute error."""
    s = np.arange(1, J_STEPS + 1) / J_STEPS
    i, f = TriangularPartition(np.concatenate([[0.0], knots])).locate_array(s)
    low, high = s * (1.0 - f), s * f  # s G(s) = low G_i + high G_{i+1}, with G_0 = 0
    size = len(knots) + 1

    def total(index: NDArray[np.intp], values: Array) -> Array:
        return np.bincount(index, values, size).astype(float)

    # Only neighbours share data, so the normal equations are tridiagonal.
    weights = np.ones_like(s)
    best = None
    for _ in range(_PASSES):
        diagonal = total(i, weights * low**2) + total(i + 1, weights * high**2)
        beside = total(i, weights * low * high)
        right = total(i, weights * low) + total(i + 1, weights * high)
        diagonal += 1e-12 * diagonal.max()  # knots with no data between them
        beside = beside[1:-1]
        normal = np.diag(diagonal[1:]) + np.diag(beside, 1) + np.diag(beside, -1)
        heights = np.asarray(np.linalg.solve(normal, right[1:]), dtype=float)
        padded = np.concatenate([[0.0], heights])
        residual = np.abs(low * padded[i] + high * padded[i + 1] - 1.0)
        error = (1.0 + 2.0 * float(residual.sum())) * _FLOOR  # J = 0, and both halves
        if best is None or error < best.error:
            best = _Design(knots, heights, error)
        weights = 1e-3 / np.maximum(residual, 1e-3)
    assert best is not None
    return best


@cache
def _design(pairs: int) -> _Design:
    """The best design with memberships of J at `pairs` knots and their mirror images."""
    if pairs == 1:
        return _fit(np.ones(1))
    steps = np.arange(pairs) / (pairs - 1)

    def fit(log_innermost: float) -> _Design:
        root = np.exp(log_innermost / 3.0)
        knots = (root + (1.0 - root) * steps) ** 3
        knots[-1] = 1.0
        return _fit(knots)

    # A grid, since the data are discrete and there are small local minima; then golden sections.
    grid = np.linspace(np.log(0.5 / J_STEPS), np.log(0.5), 13)
    designs = [fit(x) for x in grid]
    k = int(np.argmin([design.error for design in designs]))
    best = designs[k]
    low, high = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(10):
        left, right = high - golden * (high - low), low + golden * (high - low)
        a, b = fit(left), fit(right)
        low, high = (low, right) if a.error < b.error else (left, high)
        best = min(best, a, b, key=lambda design: design.error)
    return best


def _fewest(error: float) -> _Design:
    """The design with the fewest knots whose relative error is below `error`."""
    high = 1
    while _design(high).error >= error:
        if high == _MAX_PAIRS:
            raise ValueError
        high = min(2 * high, _MAX_PAIRS)
    low = high // 2  # the error falls with the number of knots (to 0.1 %), so bisect
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _design(middle).error < error else (middle, high)
    return _design(high)


def generate_least_squares(
    j_max: float, *, dr_max: float = 0.1, max_error: float = 0.0013
) -> GeneratedRuleBase:
    """Generates the fewest rules of dθ(dr, J) whose table error is below max_error.

    Args:
        j_max: half the range of J; finite, positive.
        dr_max: half the range of dr; finite, positive.
        max_error: bound on the mean absolute error over the whole table [unit of dθ].

    Returns:
        The rule base, with two memberships of dr and an even number of memberships of J.

    Raises:
        ValueError: an argument is out of its range, or no rule base of this kind is that accurate;
            the message names the limit.
    """
    for name, value in (("j_max", j_max), ("dr_max", dr_max), ("max_error", max_error)):
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} must be finite and positive, got {value}")
    mean_output = float(np.mean(np.abs(DTHETA_LEVELS))) * dr_max / j_max
    try:
        design = _fewest(max_error / mean_output)
    except ValueError:
        limit = _design(_MAX_PAIRS).error * mean_output
        raise ValueError(
            f"max_error must be above {limit:.3g} for j_max = {j_max} and dr_max = {dr_max} "
            f"(the vectors at J = 0 alone contribute {_FLOOR * mean_output:.3g}), got {max_error}"
        ) from None

    half = design.heights * (dr_max / j_max)
    row = np.concatenate([-half[::-1], half])
    knots = np.concatenate([-design.knots[::-1], design.knots]) * j_max
    rules = RuleBase(
        TriangularPartition([-dr_max, dr_max]), TriangularPartition(knots), [-row, row]
    )
    error = table_error(rules, j_max, dr_max)
    return GeneratedRuleBase(
        rules.first,
        rules.second,
        rules.consequents,
        method="least_squares",
        max_error=max_error,
        error=error,
        table_error=error,
        history=[error],
    )
