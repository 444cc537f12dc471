"""Which structure of an ANFIS learns a function best: memberships, their kind, the order of the rules.

All structures of a grid learn from the same data; each keeps its best epoch by validation data, and the
structures are compared by these too. What the winner is worth is told by held-out data that nothing was
chosen by.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import product
from time import process_time

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.executors import completed
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.fuzzy.anfis.anfis_data import ORDERS
from fikm_drake.fuzzy.anfis.membership_kinds import KINDS


@dataclass(frozen=True)
class Structure:
    """One structure, trained."""

    anfis: Anfis
    """In the state of its best epoch."""
    validation: float
    """Root mean square error over the validation data, by which structures are compared."""
    held_out: float
    """The same over the held-out data; NaN without any."""
    held_out_largest: float
    """The largest error there."""
    seconds: float
    """CPU time of the training [s]."""

    @property
    def numbers(self) -> int:
        """Coefficients and parameters of memberships: what a processor has to store."""
        anfis = self.anfis
        inputs = len(anfis.memberships)
        premises = sum(anfis.memberships) * (2 if anfis.kind == "gaussian" else 3)
        return anfis.num_rules * (1 + inputs * anfis.order) + premises

    def __str__(self) -> str:
        counts = " x ".join(map(str, self.anfis.memberships))
        return f"{counts} {self.anfis.kind}, order {self.anfis.order}"


def search_structures(
    data: tuple[ArrayLike, ArrayLike],
    validation: tuple[ArrayLike, ArrayLike],
    held_out: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    memberships: Sequence[int] = (4, 6, 8, 10),
    kinds: Sequence[str] = tuple(KINDS),
    orders: Sequence[int] = tuple(ORDERS),
    epochs: int = 40,
    method: str = "variable_projection",
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Structure]:
    """Train every structure of a grid; the best by the validation data comes first.

        best, *others = search_structures((X, Y), (X_valid, Y_valid), (X_test, Y_test))

    Args:
        data: inputs (N,d) and outputs (N,) to learn from.
        validation: inputs and outputs that choose the epoch and the structure.
        held_out: inputs and outputs that only tell what the structures are worth.
        memberships: how many; every input has as many.
        kinds: of memberships, `gaussian` or `bell`.
        orders: of the rules, 0 or 1.
        epochs: of each.
        method: `hybrid` or `variable_projection`.
        executor: that trains, such as a ProcessPoolExecutor; None: this process.
        progress: called with the fraction done.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    check_counts(epochs=epochs)
    grid = list(product(memberships, kinds, orders))
    if not grid:
        raise ValueError("there must be at least one of memberships, kinds and orders")
    inputs = np.shape(np.asarray(data[0]))[-1]
    blanks = [Anfis((count,) * inputs, kind, order) for count, kind, order in grid]
    jobs = [(anfis, data, validation, held_out, epochs, method) for anfis in blanks]
    found: dict[int, Structure] = {}
    for number, structure in completed(executor, _trained, jobs):
        found[number] = structure
        if progress:
            progress(len(found) / len(grid))
    in_order = [found[number] for number in range(len(grid))]
    return sorted(in_order, key=lambda structure: structure.validation)


def _trained(
    anfis: Anfis,
    data: tuple[ArrayLike, ArrayLike],
    validation: tuple[ArrayLike, ArrayLike],
    held_out: tuple[ArrayLike, ArrayLike] | None,
    epochs: int,
    method: str,
) -> Structure:
    """A structure of the grid, trained."""
    began = process_time()
    anfis.fit(*data, epochs=epochs, method=method, validation=validation)
    seconds = process_time() - began
    told = _errors(anfis, *held_out) if held_out is not None else (np.nan, np.nan)
    return Structure(anfis, _errors(anfis, *validation)[0], *told, seconds)


def split_rows(
    X: Array, Y: Array, *, shares: tuple[float, float] = (0.2, 0.2), seed: int = 0
) -> Iterator[tuple[Array, Array]]:
    """Rows (N,d), (N,) at random to training, validation and held-out data, in this order.

    Args:
        X: inputs.
        Y: outputs.
        shares: of validation and of held-out data.
        seed: of the order.

    Raises:
        ValueError: fewer than ten rows, or shares that leave nothing to learn from.
    """
    if len(X) < 10 or not 0.0 < sum(shares) < 1.0 or min(shares) <= 0.0:
        raise ValueError(
            f"needs ten rows or more, and shares within (0, 1), got {len(X)}, {shares}"
        )
    order = np.random.default_rng(seed).permutation(len(X))
    first = round(len(X) * (1.0 - sum(shares)))
    second = first + max(1, round(len(X) * shares[0]))
    for rows in (order[:first], order[first:second], order[second:]):
        yield X[rows], Y[rows]


def _errors(anfis: Anfis, X: ArrayLike, Y: ArrayLike) -> tuple[float, float]:
    """Root mean square and largest error."""
    off = anfis.predict(X) - np.asarray(Y, dtype=float)
    return float(np.sqrt(np.mean(off**2))), float(np.abs(off).max())
