"""A curve given by points and unit tangents: lengths, points between, points beside it."""

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import wrap

GAUSS = np.polynomial.legendre.leggauss(4)
"""Nodes and weights on [−1, 1]."""
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


def is_on(line: Array, q: Array, periodic: Bools) -> bool:
    """Whether a point (k,) is on a dense polyline (D,k), whole turns of periodic joints aside."""
    offset = q - line
    offset = np.where(periodic, wrap(offset), offset)
    nearest = int(np.argmin(np.sum(offset * offset, axis=1)))
    miss = offset[nearest]
    if len(line) > 1:
        low, high = max(nearest - 1, 0), min(nearest + 1, len(line) - 1)
        chord = line[high] - line[low]
        size = float(chord @ chord)
        if size > 0.0:
            share = np.clip((miss @ chord) / size, -1.0, 1.0)
            miss = miss - share * chord
    return bool(np.sqrt(miss @ miss) < ON_LINE)
