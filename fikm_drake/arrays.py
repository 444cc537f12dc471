"""The array types of the signatures: shapes stand in the docstrings, `(N,n)` or `(…,4,4)`."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Numbers: lengths in metres, angles in radians, whatever the docstring says."""

LARGEST = 1e100
"""A vector that is longer counts as not finite: what is computed from it could overflow."""

Bools = NDArray[np.bool_]
"""A mask, such as which of N targets were reached."""


def all_finite(vector: Array) -> bool:
    """True if no element of a vector (n,) is NaN or infinite, and its length is below `LARGEST`."""
    return bool(vector.dot(vector) < LARGEST**2)
