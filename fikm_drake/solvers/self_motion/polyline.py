"""A curve given by points and unit tangents: lengths, points between, points beside it."""

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import wrap

GAUSS = np.polynomial.legendre.leggauss(4)
"""Nodes and weights on [−1, 1]."""
FINE = 16
"""Segments of a dense polyline for each of a walk's."""
TINY = float(np.finfo(float).tiny)
ON_LINE = 1e-3
"""How near a dense polyline a point is on it [rad or m]."""


def arc_lengths(q: Array, tangents: Array) -> Array:
    """Length of the curve from its first point to each (K,); `q` and `tangents` are (K,k).

    Each piece is the cubic with these ends; the error falls with the fourth power of the step.
    """
    chord = np.linalg.norm(np.diff(q, axis=0), axis=1)
    size = chord
    u = 0.5 * (GAUSS[0][:, None, None] + 1.0)
    for _ in range(2):
        rate = (
            6.0 * u * (1.0 - u) * np.diff(q, axis=0)
            + (1.0 - 4.0 * u + 3.0 * u * u) * size[:, None] * tangents[:-1]
            + (3.0 * u * u - 2.0 * u) * size[:, None] * tangents[1:]
        )
        size = 0.5 * np.tensordot(GAUSS[1], np.linalg.norm(rate, axis=2), axes=1)
    return np.concatenate([[0.0], np.cumsum(size)])


def interpolate(q: Array, tangents: Array, lengths: Array, at: Array) -> Array:
    """Points (M,k) at lengths `at` (M,) of a curve of K points, by cubics."""
    i = np.clip(np.searchsorted(lengths, at, side="right") - 1, 0, max(len(q) - 2, 0))
    j = np.minimum(i + 1, len(q) - 1)
    size = (lengths[j] - lengths[i])[:, None]
    u = np.divide(at[:, None] - lengths[i, None], size, out=np.zeros_like(size), where=size > 0.0)
    return (
        (1.0 + 2.0 * u) * (1.0 - u) ** 2 * q[i]
        + u * (1.0 - u) ** 2 * size * tangents[i]
        + u * u * (3.0 - 2.0 * u) * q[j]
        - u * u * (1.0 - u) * size * tangents[j]
    )


class Polylines:
    """Dense polylines, and whether points are on one of them.

    Pieces of `FINE` segments lie in balls; only in those that a point is in are its segments looked at.

    Args:
        periodic: (k,): joints for which a whole turn leads to the same posture.
    """

    def __init__(self, periodic: Bools) -> None:
        self._periodic = np.flatnonzero(periodic)
        k = len(periodic)
        self._pieces, self._centers, self._squares = (
            np.empty((0, FINE + 1, k)),
            np.empty((0, k)),
            np.empty(0),
        )

    def add(self, line: Array) -> None:
        """Add a polyline (D,k) of whole pieces, as `dense` makes them."""
        first = np.arange(0, max(len(line) - 1, 1), FINE)
        pieces = line[np.minimum(first[:, None] + np.arange(FINE + 1), len(line) - 1)]
        centers = pieces[:, FINE // 2]
        away = pieces - centers[:, None]
        squares = np.einsum("pfk,pfk->pf", away, away).max(axis=1)
        self._pieces = np.concatenate([self._pieces, pieces])
        self._centers = np.concatenate([self._centers, centers])
        self._squares = np.concatenate([self._squares, (np.sqrt(squares) + ON_LINE) ** 2])

    def meet(self, q: Array) -> bool:
        """Whether a point (k,) is on one of them, whole turns of periodic joints aside."""
        offset = self._offset(q, self._centers)
        near = np.flatnonzero(np.einsum("pk,pk->p", offset, offset) <= self._squares)
        if not near.size:
            return False
        pieces = self._pieces[near]
        chords = np.diff(pieces, axis=1)
        offset = self._offset(q, pieces[:, :-1])
        squares = np.einsum("pfk,pfk->pf", chords, chords)
        share = np.einsum("pfk,pfk->pf", offset, chords) / np.maximum(squares, TINY)
        offset -= np.clip(share, 0.0, 1.0)[..., None] * chords
        return bool(np.einsum("pfk,pfk->pf", offset, offset).min() < ON_LINE**2)

    def _offset(self, q: Array, points: Array) -> Array:
        offset = q - points
        if self._periodic.size:
            offset[..., self._periodic] = wrap(offset[..., self._periodic])
        return offset
