"""How often each element of a vector changes its sign, over the last cycles."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts


class SignChanges:
    """Counts the changes of sign of each element within a window of cycles (figure 7's input).

    What it remembers is a vector that the caller keeps, so that a block's Context can: how many
    cycles there were, the last sign of each element, and the changes of the last cycles as a ring.
    An element within the dead band, or not finite, has no sign and ends no streak.

    Args:
        size: n, the number of elements.
        window: cycles that are looked at; a change needs two, so up to `window` − 1 are counted.
        dead_band: an element within ± this has no sign, in its unit.
    """

    def __init__(self, size: int, *, window: int, dead_band: float) -> None:
        self._shape = (window, size)
        self._dead_band = dead_band

    def initial_memory(self) -> Array:
        """The memory before the first cycle."""
        return np.zeros(1 + self._shape[0] * self._shape[1])

    def count(self, memory: Array) -> Array:
        """Changes of sign of each element within the window (n,)."""
        return memory[1:].reshape(self._shape)[1:].sum(axis=0)

    def remember(self, memory: Array, vector: Array) -> None:
        """Write a cycle's vector (n,) into `memory`."""
        rows = memory[1:].reshape(self._shape)  # a view
        last, ring = rows[0], rows[1:]
        size = np.abs(vector)
        sign = np.where((size > self._dead_band) & (size < np.inf), np.sign(vector), 0.0)
        ring[int(memory[0]) % len(ring)] = sign * last < 0.0
        np.copyto(last, sign, where=sign != 0.0)
        memory[0] += 1.0


def check_sign_changes(prefix: str, sign_changes: int, window: int) -> None:
    """ValueError, naming the bad value, unless a window can hold that many changes of sign.

    Args:
        prefix: of the names `sign_changes` and `window` in the message.
        sign_changes: from 1 to `window` − 1.
        window: at least 2 [cycles].
    """
    check_counts(2, **{f"{prefix}window": window})
    if sign_changes not in range(1, window):
        raise ValueError(
            f"{prefix}sign_changes must be an integer from 1 to {prefix}window − 1 = {window - 1}, "
            f"got {sign_changes!r}"
        )
