"""The minimum that m steps of conjugate gradients reach on m rows, by one direct solve."""

import numpy as np

from fikm_drake.arrays import Array

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
    M = JC.dot(J.T)
    if damping:
        M.ravel()[:: len(dr) + 1] += damping * damping * rows
    try:
        y = np.linalg.solve(M, dr)
    except np.linalg.LinAlgError:
        return None
    if damping < LEAST_DAMPING:  # from there on damping bounds the growth, by 1 / damping²
        with np.errstate(invalid="ignore", over="ignore"):
            growth, size = (y * y).dot(rows), (dr * dr).dot(1.0 / rows)
        if not growth <= LARGEST_GROWTH**2 * size:  # NaN compares false
            return None
    return y.dot(JC)


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
