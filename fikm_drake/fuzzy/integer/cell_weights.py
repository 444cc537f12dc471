"""The same inference in floating point: what integers are compared with, and fitted by."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.integer.integer_partition import IntegerPartition
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.fuzzy.triangular_partition import TriangularPartition


def cell_weights(
    first: IntegerPartition,
    second: IntegerPartition,
    points: ArrayLike,
    conjunction: Conjunction,
) -> tuple[NDArray[np.intp], Array]:
    """The four rules that hold at each point, and their weights ω / Σ ω without rounding.

    Args:
        first: memberships of the first input (n1).
        second: memberships of the second input (n2).
        points: inputs (k, 2).
        conjunction: `min` or `product`.

    Returns:
        Numbers of the rules (k, 4), rule (i, j) being i n2 + j, and weights (k, 4) that sum to one.
    """
    x, y = np.asarray(points, dtype=float).T
    i, f = TriangularPartition(first.knots).locate_array(x)
    j, g = TriangularPartition(second.knots).locate_array(y)
    AND = np.minimum if conjunction == "min" else np.multiply
    rules, weights = [], []
    for row, a in ((i, 1.0 - f), (i + 1, f)):
        for column, b in ((j, 1.0 - g), (j + 1, g)):
            rules.append(row * len(second) + column)
            weights.append(AND(a, b))
    total = np.stack(weights, axis=-1)
    return np.stack(rules, axis=-1), total / total.sum(axis=-1, keepdims=True)


def interpolate(
    first: IntegerPartition,
    second: IntegerPartition,
    values: ArrayLike,
    points: ArrayLike,
    conjunction: Conjunction,
) -> Array:
    """Equation 5 in floating point for singletons (n1, n2, outputs) at points (k, 2): (k, outputs)."""
    rules, weights = cell_weights(first, second, points, conjunction)
    table = np.asarray(values, dtype=float)
    flat = table.reshape(-1, table.shape[-1])
    return (weights[..., None] * flat[rules]).sum(axis=1)
