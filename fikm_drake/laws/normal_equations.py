"""The minimum that m steps of conjugate gradients reach on m rows, by one direct solve."""

from functools import cache

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.laws.written_out_solve import MOST_ROWS, written_out_solve

LARGEST_GROWTH = 1e4
"""|R^½ y| over |R^-½ dr| up to which the direct solve is taken. Rounding errors grow with it, and past
it, near a singular posture without damping, conjugate gradients leave out what cannot be moved."""
LEAST_DAMPING = LARGEST_GROWTH**-0.5
"""From this damping on no posture is singular [-]."""


def normal_equations_of_one(
    J: Array, dr: Array, rows: Array, columns: Array, damping: float
) -> Array | None:
    """dθ = C⁻¹ Jᵀ y with (J C⁻¹ Jᵀ + damping² R) y = dr, for one J.

    With S = R^-½ J C^-½ it is C^-½ x of the x that minimises |S x − R^-½ dr|² + damping² |x|².

    Args:
        J: Jacobian (m,n).
        dr: task error (m,).
        rows: R, the divisors of the rows (m,); infinite: the row is left out.
        columns: C, those of the columns (n,); infinite: the joint stays.
        damping: of S [-].

    Returns:
        (n,), or None where the equations are singular or nearly so: iterations do better there.
    """
    JC = J / columns
    y = _solve(JC.dot(J.T), damping * damping * rows if damping else _none(len(dr)), dr)
    if y is None:
        return None
    if damping < LEAST_DAMPING:  # from there on damping bounds the growth, by 1 / damping²
        with np.errstate(invalid="ignore", over="ignore"):
            growth, size = (y * y).dot(rows), (dr * dr).dot(1.0 / rows)
        if not growth <= LARGEST_GROWTH**2 * size:  # NaN compares false
            return None
    return y.dot(JC)


_none = cache(np.zeros)


def _solve(M: Array, diagonal: Array, b: Array) -> Array | None:
    """The x (m,) with (M + diag) x = b, M symmetric (m,m); None where that is singular."""
    try:
        if len(b) <= MOST_ROWS:
            return np.array(written_out_solve(len(b))(M, diagonal, b))
        M.ravel()[:: len(b) + 1] += diagonal
        return np.linalg.solve(M, b).astype(float, copy=False)
    except (ZeroDivisionError, np.linalg.LinAlgError):
        return None


def normal_equations(
    J: Array, dr: Array, rows: Array, columns: Array, damping: Array | float
) -> tuple[Array, Array] | None:
    """The same, vectorised over leading axes.

    Args:
        J: (…,m,n).
        dr: (…,m).
        rows: 1 / R (…,m), zero: the row is left out.
        columns: 1 / C (…,n), zero: the joint stays.
        damping: of S (…,) [-].

    Returns:
        Steps (…,n), and where they are to be trusted (…,); None if any of the equations is singular.
    """
    JC = J * columns[..., None, :]
    M = JC @ np.swapaxes(J, -1, -2)
    with np.errstate(all="ignore"):
        R = 1.0 / rows
        if np.any(damping):
            np.einsum("...ii->...i", M)[...] += np.square(damping)[..., None] * R
        try:
            y = np.linalg.solve(M, dr[..., None])[..., 0]
        except np.linalg.LinAlgError:
            return None
        growth = np.einsum("...i,...i,...i->...", y, y, R)
        good = growth <= LARGEST_GROWTH**2 * np.einsum("...i,...i,...i->...", dr, dr, rows)
        return (y[..., None, :] @ JC)[..., 0, :], good
