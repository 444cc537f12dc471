"""The linear part of training: best coefficients for given premises, in memory for one block of rows.

The matrix is never squared: memberships that overlap make the condition number of normal equations
1e20. Householder reflections reduce a block of rows after the other to one triangular factor, and a ridge
(rows √λ I above the data) makes the factor regular.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.network import Network

BLOCK = 1 << 20
"""Numbers of the matrix that are held at a time: 8 MB."""

TALL = 6
"""Rows of a piece that is factored at once, over its columns."""


class Projection(NamedTuple):
    """The least squares problem of given premises, solved."""

    coefficients: Array
    """(num_coefficients,), the best."""
    objective: float
    """Sum of squared residuals plus λ times that of the coefficients."""


@dataclass(frozen=True)
class LeastSquares:
    """Data and ridge; residuals are output minus wanted output."""

    x: Array
    """(d,N) scaled inputs."""
    y: Array
    """(N,) wanted outputs."""
    ridge: float
    """λ a row [-]."""

    def project(self, network: Network) -> Projection:
        """The best coefficients for the premises of a network."""
        n = network.num_coefficients
        R = self._factor(network, None)
        coefficients = np.asarray(np.linalg.solve(R[:n, :n], R[:n, n]), dtype=float)
        return Projection(coefficients, float(R[n, n] ** 2))

    def linearise(self, network: Network, coefficients: Array) -> tuple[Array, Array]:
        """How the projected residuals change with the premises, reduced to P rows.

        Kaufman's form of variable projection: derivatives with the coefficients held, less what other
        coefficients can make up for.

        Returns:
            A (P,P) and b (P,): a change δ of the premise parameters makes the objective
            |b − A δ|² + a constant, to first order in the residuals.
        """
        n = network.num_coefficients
        R = self._factor(network, coefficients)
        return R[n:-1, n:-1], R[n:-1, -1]

    def gradient(self, network: Network, coefficients: Array) -> Array:
        """Derivative (P,) of half the sum of squared residuals by the premise parameters."""
        total = np.zeros(network.parameters.size)
        for x, y in self._blocks(network.num_coefficients):
            output, slopes = network.output_and_slopes(x, coefficients)
            total += slopes @ (output - y)
        return total

    def rms_error(self, network: Network, coefficients: Array) -> float:
        """Root of the mean squared residual, in the unit of the output."""
        squares = 0.0
        for x, y in self._blocks(network.num_coefficients):
            squares += float(np.sum((network.output(x, coefficients) - y) ** 2))
        return float(np.sqrt(squares / self.y.size))

    def _factor(self, network: Network, coefficients: Array | None) -> Array:
        """R of the columns (regressors, derivatives if coefficients are given, wanted outputs)."""
        n = network.num_coefficients
        size = n + 1 + (network.parameters.size if coefficients is not None else 0)
        R = np.zeros((size, size))
        R[range(n), range(n)] = np.sqrt(self.ridge * self.y.size)
        for x, y in self._blocks(size):
            columns = [network.regressors(x)]
            if coefficients is not None:
                columns.append(network.output_and_slopes(x, coefficients)[1])
            rows = np.concatenate([*columns, y[None]]).T
            R = _triangle(np.concatenate([R, _short(rows)]))
        return R

    def _blocks(self, width: int) -> Iterator[tuple[Array, Array]]:
        """The data in blocks of columns that fit in memory, and are longer than the factor is wide."""
        rows = max(BLOCK // width, 4 * width)
        for start in range(0, self.y.size, rows):
            block = slice(start, start + rows)
            yield self.x[:, block], self.y[block]


def _triangle(rows: Array) -> Array:
    """R (…,w,w) of QR factors of rows (…,N,w)."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=float)


def _short(rows: Array) -> Array:
    """At most `TALL` times as many rows as columns, with the same R: factors of pieces in the cache."""
    width = rows.shape[1]
    piece = TALL * width
    while len(rows) > piece:
        whole = len(rows) // piece * piece
        factors = _triangle(rows[:whole].reshape(-1, piece, width)).reshape(-1, width)
        rows = np.concatenate([factors, rows[whole:]])
    return rows
