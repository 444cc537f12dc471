"""The small steps of a control cycle on vectors: the blocks and the fused block call the same."""

from math import inf, sqrt
from typing import TypeVar

from fikm_drake.arrays import LARGEST, Array

SQUARE = LARGEST**2
Signal = TypeVar("Signal", float, Array)


def length(vector: Array) -> float:
    """Euclidean length of a vector (n,); inf if an element is NaN, or the length passes `LARGEST`.

    Summed in order, as the native kernel does, so that both give the same whatever the BLAS does.
    """
    square = 0.0
    for x in vector.tolist():
        square += x * x
    return sqrt(square) if square < SQUARE else inf


def amplify(gain: float, error: Array, size: float, limit: float) -> Array:
    """The error times the gain, the error, of length `size`, first shortened to the length `limit`."""
    return (gain * limit / size if size > limit else gain) * error


def low_pass(value: Signal, previous: Signal, smoothing: float) -> Signal:
    """(1 − smoothing) · value + smoothing · previous (equations 30 and 31 with 2/3).

    In the order of Drake's LinearSystem, so that the fused block rounds as the Diagram does.
    """
    return smoothing * previous + (1.0 - smoothing) * value
