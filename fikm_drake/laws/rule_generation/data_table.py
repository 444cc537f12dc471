"""The input/output table of equation 12 of Xu and Nechyba (1993), and the error over it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array

J_STEPS = 1000
"""Steps of J between 0 and j_max."""

DTHETA_LEVELS = (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0)
"""Values of dθ at each J, in units of dr_max / j_max: six, 0.04/0.1 apart."""


def data_table(j_max: float, dr_max: float = 0.1) -> Array:
    """The table that the rules are fitted to.

    Sweeping dθ, and computing dr = J dθ, avoids dr / J at J = 0. There the six vectors have the
    same inputs and different outputs, so that no rule base has an error of zero.

    Args:
        j_max: half the range of J, positive.
        dr_max: half the range of dr, positive; 0.1 m in the paper.

    Returns:
        Vectors (dr, J, dθ), shape (12006, 3): J ascending, dθ ascending at each J, no two alike.
    """
    return _table(np.arange(-J_STEPS, J_STEPS + 1), np.array(DTHETA_LEVELS), j_max, dr_max)


def quarter_table(j_max: float, dr_max: float = 0.1) -> Array:
    """The part of the table with J >= 0 and dθ > 0, from J = 0 outward.

    dθ is odd in dr and odd in J, so each of these vectors stands for its mirror images too: four
    vectors of the whole table, two where J = 0. Shape (3003, 3), columns (dr, J, dθ).
    """
    levels = np.array([level for level in DTHETA_LEVELS if level > 0.0])
    return _table(np.arange(J_STEPS + 1), levels, j_max, dr_max)


def _table(steps: NDArray[np.int_], levels: Array, j_max: float, dr_max: float) -> Array:
    jacobian, dtheta = np.meshgrid(
        steps * j_max / J_STEPS, levels * (dr_max / j_max), indexing="ij"
    )
    return np.column_stack([(jacobian * dtheta).ravel(), jacobian.ravel(), dtheta.ravel()])


def table_error(model: Callable[[Any, Any], Array], j_max: float, dr_max: float = 0.1) -> float:
    """Mean absolute error of dθ = model(dr, J) over the whole table (equation 21 without updates).

    Args:
        model: any vectorised function of (dr, J).
        j_max: half the range of J, positive.
        dr_max: half the range of dr, positive.

    Returns:
        The error, in the unit of dθ.
    """
    dr, jacobian, dtheta = data_table(j_max, dr_max).T
    return float(np.mean(np.abs(model(dr, jacobian) - dtheta)))
