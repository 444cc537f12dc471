"""One step of the scaled fuzzy mapping for many targets at once."""

import numpy as np

from fikm_drake.arrays import Array

FLOOR = 0.05
"""Row and column sums are bounded from below by this fraction of the largest [-]."""


def batch_step(
    J: Array, error: Array, damping: Array, *, weights: Array | None = None, floor: float = FLOOR
) -> Array:
    """Joint steps dθ = C^-½ x, where x minimises |S x − R^-½ e|² + damping |x|².

    S = R^-½ J C^-½ is the Jacobian scaled by the fuzzy mapping's row sums R and column sums C, so
    its norm is at most 1 and the damping is dimensionless. Conjugate gradients of m steps reach the
    same minimum (`laws.conjugate_gradients`); here the m x m normal equations
    (S Sᵀ + damping) y = R^-½ e are solved directly, in three quarters of the time.

    Args:
        J: Jacobians (m,n,N), rows in m.
        error: task errors (m,N) [m].
        damping: (N,) or one number, the square of λ [-].
        weights: mobilities of the joints (n,N) in [0,1], which multiply 1/c_j; None: all 1.
        floor: r_i becomes sqrt(r_i² + (floor max r)²), which is smooth where a row vanishes; c_j too.

    Returns:
        (n,N) [rad or m].
    """
    A = np.abs(J)
    r = np.sqrt(_reciprocal(A.sum(1), floor))
    c = _reciprocal(A.sum(0), floor)
    if weights is not None:
        c *= weights
    JC = J * c
    m = len(J)
    M = np.zeros((m, m, J.shape[-1]))
    for i in range(m):
        np.sum(JC[i] * J[: i + 1], axis=1, out=M[i, : i + 1])
        M[i, : i + 1] *= r[: i + 1]
        M[i, : i + 1] *= r[i]
        M[i, i] += damping
    y = solve_positive_definite(M, error * r)
    y *= r
    return np.sum(JC * y[:, None], axis=0)


def solve_positive_definite(M: Array, b: Array) -> Array:
    """Solve M y = b for N symmetric positive definite M by L D Lᵀ.

    Args:
        M: (m,m,N), overwritten; only the lower triangles are read.
        b: (m,N), overwritten.

    Returns:
        y (m,N), in the place of b.
    """
    m = len(b)
    inverse = np.empty_like(b)
    for k in range(m):
        np.divide(1.0, M[k, k], out=inverse[k])
        column = M[k + 1 :, k]
        scaled = column * inverse[k]
        b[k + 1 :] -= scaled * b[k]
        for i in range(m - k - 1):
            M[k + 1 + i, k + 1 : k + 2 + i] -= scaled[i] * column[: i + 1]
        M[k + 1 :, k] = scaled
    b *= inverse
    for k in range(m - 2, -1, -1):
        b[k] -= np.sum(M[k + 1 :, k] * b[k + 1 :], axis=0)
    return b


def _reciprocal(sums: Array, floor: float) -> Array:
    """1 / sqrt(sums² + (floor max sums)²), finite where all are zero."""
    least = floor * sums.max(axis=0)
    squares = sums * sums
    squares += least * least + np.finfo(float).tiny
    return 1.0 / np.sqrt(squares)
