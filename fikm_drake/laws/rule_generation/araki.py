"""The rule generator of section 2.5 of Xu and Nechyba (1993), after Araki et al.

Sweeps over the data correct the consequents one vector at a time (equations 18-20). When a sweep
no longer lowers the error, the region of the dr-J plane with the greatest error gets a new
membership (figure 5, equations 23-26). It ends when the error is small enough.

The text leaves three things open. They are read so that Table II comes out:

- *Order of the sweep.* dθ is odd in dr and in J. Each vector is taken with its mirror images at
  once, from J = 0 outward. So the rules are antisymmetric at every moment, the consequents on the
  axes stay zero (the images' corrections cancel), and a quarter of the plane is all that has to be
  stored. New memberships come in mirrored pairs.
- *The error* that is compared with e_max is the in-sweep error: each vector's, before its update.
- *Which input to split.* Both are tried for one sweep, and the one that leaves the smaller error
  over the table is kept; if neither leaves a smaller one than a sweep without a split, the next
  region has its turn. So dr, in which dθ is linear, keeps its three memberships.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition
from fikm_drake.laws.rule_generation.data_table import quarter_table, table_error
from fikm_drake.laws.rule_generation.generated_rule_base import GeneratedRuleBase, Split

# A data vector with all that a sweep needs to know of it: its region (i, j), the truths of the four
# rules there, dθ, and how many vectors of the whole table it stands for. A bare tuple, because the
# sweep is sequential and must be cheap.
_Vector = tuple[int, int, float, float, float, float, float, int]


class _Quarter(NamedTuple):
    """The rules for dr >= 0 and J >= 0; knots begin at 0, weights[i][j] belongs to (dr_i, J_j)."""

    dr_knots: list[float]
    j_knots: list[float]
    weights: list[list[float]]

    def vectors(self, table: Array) -> list[_Vector]:
        """Prepares the table, shape (p, 3), for sweeps over these memberships."""
        dr, jacobian, dtheta = table.T
        i, f = TriangularPartition(self.dr_knots).locate_array(dr)
        j, g = TriangularPartition(self.j_knots).locate_array(jacobian)
        # Rules on the axes have no part in learning: zero truth holds them at zero.
        f_low = np.where(i == 0, 0.0, 1.0 - f)
        g_low = np.where(j == 0, 0.0, 1.0 - g)
        images = np.where(jacobian > 0.0, 4, 2)
        columns = (i, j, f_low * g_low, f_low * g, f * g_low, f * g, dtheta, images)
        return list(zip(*(column.tolist() for column in columns)))

    def split(self, name: str, region: int, knot: float) -> _Quarter:
        """Adds a membership; its rules are the means of their neighbours (equations 23-26)."""
        n = region + 1
        if name == "J":
            weights = [[*row[:n], 0.5 * (row[n - 1] + row[n]), *row[n:]] for row in self.weights]
            return _Quarter(self.dr_knots, [*self.j_knots[:n], knot, *self.j_knots[n:]], weights)
        between = [0.5 * (a + b) for a, b in zip(self.weights[n - 1], self.weights[n])]
        weights = [row[:] for row in [*self.weights[:n], between, *self.weights[n:]]]
        return _Quarter([*self.dr_knots[:n], knot, *self.dr_knots[n:]], self.j_knots, weights)

    def mirrored(self) -> RuleBase:
        """The rules of the whole plane."""
        quarter = np.array(self.weights)
        half = np.hstack([-quarter[:, :0:-1], quarter])
        whole = np.vstack([-half[:0:-1], half]) + 0.0  # + 0.0: no negative zeros on the axes
        dr_knots, j_knots = (
            [-knot for knot in knots[:0:-1]] + knots for knots in (self.dr_knots, self.j_knots)
        )
        return RuleBase(TriangularPartition(dr_knots), TriangularPartition(j_knots), whole)


def _sweep(
    vectors: Sequence[_Vector], quarter: _Quarter, rate: float
) -> tuple[float, list[list[float]]]:
    """Equations 18-21 for the whole table; corrects the weights in place.

    Returns:
        The mean absolute error before each update, and its sum in each region.
    """
    weights = quarter.weights
    region_errors = [[0.0] * (len(row) - 1) for row in weights[1:]]
    count = 0
    for i, j, m00, m01, m10, m11, dtheta, images in vectors:
        low = weights[i]
        high = weights[i + 1]
        k = j + 1
        error = m00 * low[j] + m01 * low[k] + m10 * high[j] + m11 * high[k] - dtheta
        region_errors[i][j] += images * abs(error)
        count += images
        error *= rate
        low[j] -= m00 * error
        low[k] -= m01 * error
        high[j] -= m10 * error
        high[k] -= m11 * error
    return sum(map(sum, region_errors)) / count, region_errors


def _trial(quarter: _Quarter, table: Array, rate: float) -> float:
    """Error over the table that one sweep from these rules would leave; they stay as they are."""
    copy = quarter._replace(weights=[row[:] for row in quarter.weights])
    vectors = copy.vectors(table)
    _sweep(vectors, copy, rate)
    return _sweep(vectors, copy, 0.0)[0]


def _cut(low: float, high: float, values: Array) -> float | None:
    """Halves [low, high], and then always the half with all the data, until both parts hold data.

    Returns:
        The new knot, or None if all values are the same, so that no cut divides them.
    """
    least, greatest = values.min(), values.max()
    if greatest - least <= 1e-9 * greatest:
        return None
    while True:
        middle = 0.5 * (low + high)
        if greatest < middle:
            high = middle
        elif least >= middle:
            low = middle
        else:
            return middle


def _grow(
    quarter: _Quarter,
    region_errors: list[list[float]],
    table: Array,
    rate: float,
    limit: int,
) -> tuple[_Quarter, str, float] | None:
    """Splits the worst region whose split is of use.

    A region cannot be split along an input that has `limit` knots already, nor along one in which
    its data cannot be separated: the vectors at J = 0, say, whose error no rule can remove.

    Returns:
        The new rules, the input that was split ("dr" or "J") and the new knot; None if there is no
        such region.
    """
    dr_knots, j_knots, _ = quarter
    i, _ = TriangularPartition(dr_knots).locate_array(table[:, 0])
    j, _ = TriangularPartition(j_knots).locate_array(table[:, 1])
    errors = np.array(region_errors)
    unsplit_error = _trial(quarter, table, rate)
    for flat in np.argsort(-errors, axis=None, kind="stable"):
        p, q = (int(index) for index in np.unravel_index(flat, errors.shape))
        data = table[(i == p) & (j == q)]
        if not len(data):
            continue
        best_error, best = unsplit_error, None
        for name, knots, region, values in (
            ("J", j_knots, q, data[:, 1]),
            ("dr", dr_knots, p, data[:, 0]),
        ):
            knot = _cut(knots[region], knots[region + 1], values) if len(knots) < limit else None
            if knot is None:
                continue
            candidate = quarter.split(name, region, knot)
            error = _trial(candidate, table, rate)
            if error < best_error:
                best_error, best = error, (candidate, name, knot)
        if best is not None:
            return best
    return None


def generate_araki(
    j_max: float,
    *,
    dr_max: float = 0.1,
    max_error: float = 0.0013,
    min_change: float = 5e-6,
    learning_rate: float = 0.6,
    max_memberships: int = 41,
    max_epochs: int = 1000,
) -> GeneratedRuleBase:
    """Generates the rules of dθ(dr, J) as the paper does.

    max_error and min_change are absolute, and the paper found its numbers by trial at one range;
    the output scales with dr_max / j_max. So at j_max of 1 or less the default asks for more than
    the method reaches within its bounds; `converged` of the result tells, `error` is what was
    reached. Multiplying both thresholds by 1.5 / j_max gives, for every range, the rules of
    j_max = 1.5 on another scale.

    Args:
        j_max: half the range of J; finite, positive.
        dr_max: half the range of dr; finite, positive.
        max_error: e_max, the in-sweep error to stop below [unit of dθ].
        min_change: Δe_max: an epoch that lowers the error by less calls for a new membership.
        learning_rate: c_w of equation 20, between 0 and 2 (excluded).
        max_memberships: bound on the memberships of each input, at least 3.
        max_epochs: bound on the sweeps over the data, at least 1.

    Returns:
        The rule base; memberships and consequents are antisymmetric in dr and in J.

    Raises:
        ValueError: an argument is out of its range.
    """
    for name, value in (("j_max", j_max), ("dr_max", dr_max), ("max_error", max_error)):
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} must be finite and positive, got {value}")
    if not 0.0 <= min_change < np.inf:
        raise ValueError(f"min_change must be finite and not negative, got {min_change}")
    if not 0.0 < learning_rate < 2.0:
        raise ValueError(f"learning_rate must be between 0 and 2, got {learning_rate}")
    if max_memberships < 3:
        raise ValueError(f"max_memberships must be at least 3, got {max_memberships}")
    if max_epochs < 1:
        raise ValueError(f"max_epochs must be at least 1, got {max_epochs}")

    table = quarter_table(j_max, dr_max)
    quarter = _Quarter([0.0, dr_max], [0.0, j_max], [[0.0, 0.0], [0.0, 0.0]])
    vectors = quarter.vectors(table)
    history: list[float] = []
    splits: list[Split] = []
    while len(history) < max_epochs:
        error, region_errors = _sweep(vectors, quarter, learning_rate)
        history.append(error)
        if error < max_error:
            break
        if len(history) > 1 and history[-2] - error < min_change:  # equation 22
            limit = (max_memberships + 1) // 2  # a quarter has half of the knots, and 0
            grown = _grow(quarter, region_errors, table, learning_rate, limit)
            if grown is None:
                break
            quarter, name, knot = grown
            vectors = quarter.vectors(table)
            splits.append(Split(len(history), name, knot, error))

    rules = quarter.mirrored()
    return GeneratedRuleBase(
        rules.first,
        rules.second,
        rules.consequents,
        method="araki",
        max_error=max_error,
        error=history[-1],
        table_error=table_error(rules, j_max, dr_max),
        history=history,
        splits=splits,
    )
