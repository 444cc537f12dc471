"""Singletons from data by least squares."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.integer.cell_weights import cell_weights
from fikm_drake.fuzzy.integer.integer_partition import IntegerPartition
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction


def fit_singletons(
    first: IntegerPartition,
    second: IntegerPartition,
    points: ArrayLike,
    outputs: ArrayLike,
    conjunction: Conjunction,
) -> Array:
    """The singletons whose inference is nearest to data in the sense of least squares.

    Args:
        first: memberships of the first input (n1).
        second: memberships of the second input (n2).
        points: inputs (k, 2).
        outputs: wanted outputs (k, outputs).
        conjunction: `min` or `product`.

    Returns:
        (n1, n2, outputs), not rounded.

    Raises:
        ValueError: the data do not determine every singleton.
    """
    rules, weights = cell_weights(first, second, points, conjunction)
    outputs = np.asarray(outputs, dtype=float)
    size = len(first) * len(second)
    # Each point touches four rules, so the normal equations are added up pair by pair.
    pairs = rules[:, :, None] * size + rules[:, None, :]
    products = weights[:, :, None] * weights[:, None, :]
    normal = np.bincount(pairs.ravel(), products.ravel(), size * size).reshape(size, size)
    right = np.stack(
        [
            np.bincount(rules.ravel(), (weights * column[:, None]).ravel(), size)
            for column in outputs.T
        ],
        axis=1,
    )
    fitted, _, rank, _ = np.linalg.lstsq(normal, right, rcond=1e-10)
    if rank < size:
        raise ValueError(
            f"{len(outputs)} points determine {rank} of the {size} singletons; "
            "take fewer labels or more points"
        )
    return np.asarray(fitted).reshape(len(first), len(second), -1)
