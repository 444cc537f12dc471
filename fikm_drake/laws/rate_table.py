"""The rules of rate control from a look-up table, as Kim & Lee 1993 propose for a digital computer.

The push of one row of the task depends on a = dr_i / D and j = J_ik / L_k alone: a square table of it, filled
once by the rules, replaces the inference. The nearest entry is taken, without interpolation, so an error
below about D / size is no error to the table: it rests there. (With bilinear interpolation the 3 x 2 rules
themselves are an exact table, and nothing is left to look up.)
"""

from collections.abc import Sequence

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.laws.rate_inference import Many, One, rate_rules


def rate_table(size: int) -> Array:
    """Pushes of one row (size, size) in [−1, 1]: rows of a, columns of j, both from −1 to 1.

    Args:
        size: entries a side; an odd number has a zero.

    Raises:
        ValueError: fewer than 2.
    """
    check_counts(2, table_size=size)
    ticks = np.linspace(-1.0, 1.0, size)
    return rate_rules()(ticks[:, None], ticks)


def table_inference(size: int) -> tuple[Many, One]:
    """`smooth`, the sum of the rows, from a table: the forms for arrays and for one case."""
    table = rate_table(size)
    entries: list[list[float]] = table.tolist()
    half = 0.5 * (size - 1)

    def index(values: Array) -> np.ndarray:
        return np.rint((np.clip(values, -1.0, 1.0) + 1.0) * half).astype(np.intp)

    def many(column: Array, error: Array, inverse: Array, error_range: float) -> Array:
        finite = np.isfinite(column) & np.isfinite(error)
        a = index(np.where(finite, error / error_range, 0.0))
        j = index(np.where(finite, column * inverse, 0.0))
        pushes = np.where(finite, table[a, j], np.nan)
        return error_range * inverse * pushes.sum(axis=0)

    def one(
        column: Sequence[float], error: Sequence[float], inverse: float, error_range: float
    ) -> float:
        push = 0.0
        for c, e in zip(column, error):
            if c - c or e - e:  # not finite
                return float("nan")
            a = min(max(e / error_range, -1.0), 1.0)
            j = min(max(c * inverse, -1.0), 1.0)
            push += entries[round((a + 1.0) * half)][round((j + 1.0) * half)]
        return error_range * inverse * push

    return many, one
