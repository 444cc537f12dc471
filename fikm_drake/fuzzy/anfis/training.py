"""Two ways to learn the premises; the coefficients always follow by least squares.

Both are iterators over epochs, so that whoever runs them can stop, watch or validate.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.network import Network
from fikm_drake.fuzzy.anfis.projection import LeastSquares

FIRST_STEP = 0.05
"""Length of the first gradient step in the premise parameters [-]."""
LONGER, SHORTER = 1.1, 0.9
"""Factors of the step after four decreases in a row, and after two rises and falls (Jang 1993)."""
FIRST_DAMPING, MOST_DAMPING = 1e-6, 1e6
"""First and greatest damping of Levenberg and Marquardt, a row [-]."""


class Epoch(NamedTuple):
    """A network at the end of an epoch."""

    network: Network
    coefficients: Array


def first_networks(even: Network, count: int, seed: int) -> Iterator[Network]:
    """Networks to start from: the even one, then others with their memberships moved at random."""
    yield even
    rng = np.random.default_rng(seed)
    for _ in range(count - 1):
        moves = []
        for p, m in (premise.shape for premise in even.premises):
            moves += [rng.uniform(-1.0, 1.0, m) / m, rng.uniform(-0.5, 0.5, (p - 1) * m)]
        yield even.with_parameters(even.parameters + np.concatenate(moves))


def hybrid(data: LeastSquares, network: Network) -> Iterator[Epoch]:
    """Jang's hybrid rule: least squares, then a step of the premises down the gradient.

    The gradient is scaled to the length of the step; the step adapts to the last errors.
    """
    step, errors = FIRST_STEP, np.empty(0)
    while True:
        coefficients, objective, _ = data.project(network)
        yield Epoch(network, coefficients)
        errors = np.append(errors, objective)[-5:]
        signs = np.sign(np.diff(errors)).tolist()
        if signs == [-1, -1, -1, -1]:
            step, errors = LONGER * step, errors[-1:]
        elif signs in ([1, -1, 1, -1], [-1, 1, -1, 1]):
            step, errors = SHORTER * step, errors[-1:]
        slope = data.gradient(network, coefficients)
        length = float(np.linalg.norm(slope))
        if length > 0.0:
            network = network.with_parameters(network.parameters - step / length * slope)


def variable_projection(data: LeastSquares, network: Network) -> Iterator[Epoch]:
    """Levenberg-Marquardt on the residuals that are left after the best coefficients.

    An epoch tries one step. One that does not lower the objective is not taken. The damping follows
    how well the step's gain was foreseen (Nielsen 1999).
    """
    damping, growth = FIRST_DAMPING * data.y.size, 2.0
    best = data.project(network)
    A, b = data.linearise(network, best)
    while True:
        step = _damped_step(A, b, damping)
        tried = network.with_parameters(network.parameters + step)
        with np.errstate(over="ignore", invalid="ignore"):  # of a step too long: it is not taken
            found = data.project(tried)
        gain = best.objective - found.objective
        if gain > 0.0:
            foreseen = float(np.sum(b**2) - np.sum((b - A @ step) ** 2))
            # Where the data are met exactly what is foreseen is rounding, or nothing.
            quality = min(gain / foreseen, 2.0) if foreseen > 0.0 else 1.0
            damping *= max(1.0 / 3.0, 1.0 - (2.0 * quality - 1.0) ** 3)
            growth = 2.0
            network, best = tried, found
            A, b = data.linearise(network, best)
        else:
            damping = min(damping * growth, MOST_DAMPING * data.y.size)
            growth = min(2.0 * growth, MOST_DAMPING)
        yield Epoch(network, best.coefficients)


def _damped_step(A: Array, b: Array, damping: float) -> Array:
    """The δ (P,) that minimises |b − A δ|² + damping |δ|²."""
    P = A.shape[1]
    padded = np.concatenate([A, np.sqrt(damping) * np.eye(P)])
    return np.linalg.lstsq(padded, np.concatenate([b, np.zeros(P)]), rcond=None)[0]


METHODS: dict[str, Callable[[LeastSquares, Network], Iterator[Epoch]]] = {
    "hybrid": hybrid,
    "variable_projection": variable_projection,
}
"""Ways to train by name."""
