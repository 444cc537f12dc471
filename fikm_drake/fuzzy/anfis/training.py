"""Two ways to learn the premises; the coefficients always follow by least squares.

Both are iterators over epochs, so that whoever runs them can stop, watch or validate.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.anfis.least_squares import LeastSquares
from fikm_drake.fuzzy.anfis.network import Network

Array = NDArray[np.float64]
FIRST_STEP = 0.05
"""Length of the first gradient step in the premise parameters [-]."""
LONGER, SHORTER = 1.1, 0.9
"""Factors of the step after four decreases in a row, and after two rises and falls (Jang 1993)."""
FIRST_DAMPING = 1e-6
"""Of Levenberg and Marquardt, a row [-]."""


class Epoch(NamedTuple):
    """A network at the end of an epoch."""

    network: Network
    coefficients: Array


def hybrid(data: LeastSquares, network: Network) -> Iterator[Epoch]:
    """Jang's hybrid rule: least squares, then a step of the premises down the gradient.

    The gradient is scaled to the length of the step; the step adapts to the last errors.
    """
    step, errors = FIRST_STEP, np.empty(0)
    while True:
        coefficients, objective = data.project(network)
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

    An epoch tries one step; one that does not lower the objective is not taken, and the next is shorter.
    """
    damping = FIRST_DAMPING * data.y.size
    best = data.project(network)
    linear = data.linearise(network, best.coefficients)
    while True:
        A, b = linear
        padded = np.concatenate([A, np.sqrt(damping) * np.eye(len(A))])
        step = np.linalg.lstsq(padded, np.concatenate([b, np.zeros(len(A))]), rcond=None)[0]
        tried = network.with_parameters(network.parameters + step)
        found = data.project(tried)
        if found.objective < best.objective:
            network, best = tried, found
            linear = data.linearise(network, best.coefficients)
            damping /= 3.0
        else:
            damping *= 4.0
        yield Epoch(network, best.coefficients)


METHODS: dict[str, Callable[[LeastSquares, Network], Iterator[Epoch]]] = {
    "hybrid": hybrid,
    "variable_projection": variable_projection,
}
"""Ways to train by name."""
