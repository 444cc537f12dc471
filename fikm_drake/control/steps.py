"""The small steps of a control cycle on vectors: the blocks and the fused block call the same."""

from math import isfinite, sqrt
from typing import TypeVar

from fikm_drake.arrays import Array

Signal = TypeVar("Signal", float, Array)


def length(vector: Array) -> float:
    """Euclidean length of a vector (n,); not finite if an element is not (or passes 1e154)."""
    return sqrt(vector.dot(vector))


def all_finite(vector: Array) -> bool:
    """True if no element of a vector (n,) is NaN or infinite (or passes 1e154)."""
    return isfinite(vector.dot(vector))


def amplify(gain: float, error: Array, size: float, limit: float) -> Array:
    """The error times the gain, the error, of length `size`, first shortened to the length `limit`."""
    return (gain * limit / size if size > limit else gain) * error


def low_pass(value: Signal, previous: Signal, smoothing: float) -> Signal:
    """(1 − smoothing) · value + smoothing · previous (equations 30 and 31 with 2/3).

    In the order of Drake's LinearSystem, so that the fused block rounds as the Diagram does.
    """
    return smoothing * previous + (1.0 - smoothing) * value
