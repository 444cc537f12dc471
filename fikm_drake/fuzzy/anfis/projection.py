"""The linear part of training: best coefficients for given premises, in memory for one block of rows.

The ridge λ keeps the normal equations regular where it is not smaller than their rounding errors (at the
default their condition number is about 1e11; of the data alone it is 1e20): they are solved, and the
solution is corrected by its own residuals, so that no accuracy is lost. With a smaller ridge the matrix is
never squared: Householder reflections reduce a block of rows after the other to one triangular factor.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.network import Network
from fikm_drake.fuzzy.anfis.squared import SquaredRegressors

BLOCK = 1 << 20
"""Numbers of the matrix that are held at a time: 8 MB."""
CACHED = 1 << 17
"""Numbers of an intermediate array that are held at a time, so that they stay in the cache."""
TALL = 6
"""Rows of a piece that is factored at once, over its columns."""
REGULAR = 1e-13
"""The least ridge over the sum of squares of the matrix for which normal equations are taken [-]."""
CORRECTIONS = 3
"""Corrections at most."""
CORRECTED = 1e-8
"""A correction that is smaller than this, relative to the coefficients, is the last one [-]."""


class Projection(NamedTuple):
    """The least squares problem of given premises, solved."""

    coefficients: Array
    """(num_coefficients,), the best."""
    objective: float
    """Sum of squared residuals plus λ times that of the coefficients."""
    inverse: Array | None
    """Of the normal equations' matrix; None where it is not to be trusted."""


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
        n, ridge = network.num_coefficients, self.ridge * self.y.size
        sums, products = SquaredRegressors(network), np.zeros(n)
        for x, y in self._blocks(n, CACHED):
            sums.add(x)
            products += network.weigh(x, y)
        G = sums.matrix()
        if not ridge >= REGULAR * np.trace(G):
            R = self._factor(network, None)
            coefficients = np.asarray(np.linalg.solve(R[:n, :n], R[:n, n]), dtype=float)
            return Projection(coefficients, float(R[n, n] ** 2), None)
        G.reshape(-1)[:: n + 1] += ridge
        inverse = np.asarray(np.linalg.inv(G), dtype=float)
        coefficients = inverse @ products
        for _ in range(CORRECTIONS):
            squares, downhill = ridge * float(coefficients @ coefficients), -ridge * coefficients
            for x, y in self._blocks(n, CACHED):
                residual = y - network.output(x, coefficients)
                squares += float(residual @ residual)
                downhill += network.weigh(x, residual)
            correction = inverse @ downhill
            coefficients = coefficients + correction
            # What is left after a correction: exact, since the objective is quadratic.
            objective = max(squares - float(downhill @ correction), 0.0)
            if np.abs(correction).max() <= CORRECTED * np.abs(coefficients).max():
                break
        return Projection(coefficients, objective, inverse)

    def linearise(self, network: Network, best: Projection) -> tuple[Array, Array]:
        """How the projected residuals change with the premises, reduced to P rows.

        Kaufman's form of variable projection: derivatives with the coefficients held, less what other
        coefficients can make up for.

        Args:
            network: the premises.
            best: of the same network.

        Returns:
            A (P,P) and b (P,): a change δ of the premise parameters makes the objective
            |b − A δ|² + a constant, to first order in the residuals.
        """
        n, P = network.num_coefficients, network.parameters.size
        if best.inverse is None:
            R = self._factor(network, best.coefficients)
            return R[n:-1, n:-1], R[n:-1, -1]
        AD = np.zeros((n, P))
        for x, _ in self._blocks(n + P, CACHED):
            AD += network.regressors(x) @ network.output_and_slopes(x, best.coefficients)[1].T
        change = best.inverse @ AD  # of the coefficients, with the premises
        R = np.column_stack([change, best.coefficients]) * -np.sqrt(self.ridge * self.y.size)
        for x, y in self._blocks(n + P, CACHED):
            output, slopes = network.output_and_slopes(x, best.coefficients)
            slopes -= change.T @ network.regressors(x)
            R = _triangle(
                np.concatenate([R, _short(np.concatenate([slopes, (y - output)[None]]).T)])
            )
        return R[:P, :P], R[:P, P]

    def gradient(self, network: Network, coefficients: Array) -> Array:
        """Derivative (P,) of half the sum of squared residuals by the premise parameters."""
        total = np.zeros(network.parameters.size)
        for x, y in self._blocks(network.num_coefficients, CACHED):
            output, slopes = network.output_and_slopes(x, coefficients)
            total += slopes @ (output - y)
        return total

    def rms_error(self, network: Network, coefficients: Array) -> float:
        """Root of the mean squared residual, in the unit of the output."""
        squares = 0.0
        for x, y in self._blocks(network.num_coefficients, CACHED):
            squares += float(np.sum((network.output(x, coefficients) - y) ** 2))
        return float(np.sqrt(squares / self.y.size))

    def _factor(self, network: Network, coefficients: Array | None) -> Array:
        """R of the columns (regressors, derivatives if coefficients are given, wanted outputs)."""
        n = network.num_coefficients
        size = n + 1 + (network.parameters.size if coefficients is not None else 0)
        R = np.zeros((size, size))
        R[range(n), range(n)] = np.sqrt(self.ridge * self.y.size)
        for x, y in self._blocks(size, BLOCK):
            columns = [network.regressors(x)]
            if coefficients is not None:
                columns.append(network.output_and_slopes(x, coefficients)[1])
            rows = np.concatenate([*columns, y[None]]).T
            R = _triangle(np.concatenate([R, _short(rows)]))
        return R

    def _blocks(self, width: int, numbers: int) -> Iterator[tuple[Array, Array]]:
        """The data in blocks of columns of so many numbers, longer than the factor is wide."""
        rows = max(numbers // width, 4 * width)
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
