"""Checks of an ANFIS's data."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array


def checked_inputs(name: str, X: ArrayLike, dimensions: int) -> Array:
    """Inputs (N,d) as an array; ValueError if they have another shape."""
    array = np.asarray(X, dtype=float)
    if array.ndim != 2 or array.shape[1] != dimensions:
        raise ValueError(f"{name} must have shape (N, {dimensions}), got {array.shape}")
    return array


def checked_rows(
    name: str, X: ArrayLike, output_name: str, Y: ArrayLike, dimensions: int
) -> tuple[Array, Array]:
    """Inputs (N,d) and outputs (N,), N > 0, finite; ValueError, naming which, if they are not."""
    inputs, outputs = checked_inputs(name, X, dimensions), np.asarray(Y, dtype=float)
    if outputs.shape != (len(inputs),) or not outputs.size:
        raise ValueError(
            f"{output_name} must have shape ({len(inputs)},), at least 1, got {outputs.shape}"
        )
    for what, array in ((name, inputs), (output_name, outputs)):
        for row in np.flatnonzero(~np.isfinite(array.reshape(len(array), -1)).all(axis=1)):
            raise ValueError(f"{what} must be finite, row {row} is {array[row]}")
    return inputs, outputs
