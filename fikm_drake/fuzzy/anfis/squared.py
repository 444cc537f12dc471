"""The normal equations' matrix of an ANFIS, out of products of memberships, without the matrix itself.

A regressor is a product a_i(x1) b_j(x2) … t_k(x) of shares and a term, so a product of two is a product of
pairs a_i a_i′, b_j b_j′, …, t_k t_k′, of which there are m (m + 1) / 2 each. One product of matrices, the
pairs of the first input times those of all others, holds all sums over the data: for 8 x 8 rules of first
order a fifth of the arithmetic of A Aᵀ, and no A.
"""

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.network import Network


class SquaredRegressors:
    """Sums over the data of products of two regressors.

    Args:
        network: whose regressors.
    """

    def __init__(self, network: Network) -> None:
        self._network = network
        self._sizes = (*network.shape, network.num_terms)
        counts = [m * (m + 1) // 2 for m in self._sizes]
        self._sums = np.zeros((counts[0], int(np.prod(counts[1:]))))
        self._counts = counts

    def add(self, x: Array) -> None:
        """Add the products at inputs (d,N)."""
        factors = [_pairs(factor) for factor in (*self._network.shares(x), self._network.terms(x))]
        right = factors[1]
        for factor in factors[2:]:
            right = (right[:, None] * factor).reshape(-1, x.shape[1])
        self._sums += factors[0] @ right.T

    def matrix(self) -> Array:
        """A Aᵀ (num_coefficients,num_coefficients)."""
        sums = self._sums.reshape(self._counts)
        count, where = len(self._sizes), []
        for axis, size in enumerate(self._sizes):
            shape = [1] * (2 * count)
            shape[axis] = shape[axis + count] = size
            where.append(_places(size).reshape(shape))
        n = self._network.num_coefficients
        return sums[tuple(where)].reshape(n, n)


def _pairs(factor: Array) -> Array:
    """Products (m (m + 1) / 2,N) of rows i ≤ j of (m,N)."""
    m, count = factor.shape
    pairs, start = np.empty((m * (m + 1) // 2, count)), 0
    for i in range(m):
        np.multiply(factor[i], factor[i:], out=pairs[start : start + m - i])
        start += m - i
    return pairs


def _places(m: int) -> NDArray[np.intp]:
    """Where the pair (i, j) or (j, i) stands in `_pairs` (m,m)."""
    places = np.zeros((m, m), dtype=np.intp)
    upper = np.triu_indices(m)
    places[upper] = np.arange(len(upper[0]))
    return np.maximum(places, places.T)
