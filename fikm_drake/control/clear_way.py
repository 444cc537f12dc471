"""A way of the joints that is clear, looked for bit by bit."""

from math import gcd

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.clearance import Clearance

CHECKS = 6
"""Postures that are looked at in a look [-]."""
VIAS = 16
"""Ways with a posture in between that are tried after the straight one [-]."""
ASIDE = 0.8
"""How far from the middle of the way toward a random posture such a posture is [-]."""


class ClearWay:
    """Finds whether the straight way of the joints to a posture is clear, or else one with a bend.

    Ways are looked at as finely as the joints move along them, and from everywhere at once, so that one
    that is not clear is given up early. `CHECKS` postures are looked at in a call.

    What it remembers is a vector that the caller keeps: the posture in between (n,), the number of the
    way (0: straight), how many of its postures have been looked at.

    Args:
        clearance: tells what is clear.
        pace: largest joint motion between two postures [rad or m].
        lower: lower joint limits (n,) [rad or m].
        upper: upper joint limits (n,) [rad or m].
        starts: random postures (N,n), at least `VIAS` [rad or m].
    """

    def __init__(
        self, clearance: Clearance, *, pace: float, lower: Array, upper: Array, starts: Array
    ) -> None:
        self._clearance, self._pace = clearance, pace
        self._lower, self._upper, self._starts = lower, upper, starts[:VIAS]

    def initial_memory(self) -> Array:
        """The memory before a search."""
        return np.zeros(len(self._lower) + 2)

    def via(self, memory: Array) -> Array | None:
        """The posture in between (n,), while the joints are to go there first."""
        return memory[:-2] if memory[-2] else None

    def pass_via(self, memory: Array) -> None:
        """The joints are at the posture in between: what is left is straight."""
        memory[-2] = 0.0

    def length(self, memory: Array, q: Array, posture: Array) -> float:
        """Length of the way from q to a posture, by the fastest joint [rad or m]."""
        return sum(float(np.abs(b - a).max()) for a, b in self._legs(memory, q, posture))

    def look(
        self, memory: Array, q: Array, posture: Array, others: Array | None = None
    ) -> bool | None:
        """True if a way was found, False if there is none, None if it takes more looks.

        Args:
            memory: zeros at first; what is changed.
            q: where the joints are (n,) [rad or m].
            posture: where they shall go (n,) [rad or m].
            others: where obstacles are (p,), see `Clearance`.
        """
        for _ in range(CHECKS):
            legs = self._legs(memory, q, posture)
            counts = [max(1, int(np.ceil(np.abs(b - a).max() / self._pace))) for a, b in legs]
            done, total = int(memory[-1]), sum(counts)
            if done >= total:
                return True
            k = (done * _stride(total) + total - 1) % total  # the end first
            leg = 0
            while k >= counts[leg]:
                k, leg = k - counts[leg], leg + 1
            a, b = legs[leg]
            if self._clearance.is_clear(a + (k + 1) / counts[leg] * (b - a), others):
                memory[-1] += 1.0
                continue
            if (done == 0 and memory[-2] == 0.0) or memory[-2] >= len(self._starts):
                return False  # the posture itself is not clear, or all ways were tried
            middle = 0.5 * (q + posture)
            memory[-2:] = memory[-2] + 1.0, 0.0
            via = middle + ASIDE * (self._starts[int(memory[-2]) - 1] - middle)
            memory[:-2] = np.clip(via, self._lower, self._upper)
        return None

    def _legs(self, memory: Array, q: Array, posture: Array) -> list[tuple[Array, Array]]:
        via = self.via(memory)
        return [(q, posture)] if via is None else [(q, via), (via, posture)]


def _stride(total: int) -> int:
    """A step through `total` numbers that comes by all of them, far apart from one another."""
    stride = max(1, round(0.618 * total))
    while gcd(stride, total) != 1:
        stride += 1
    return stride
