"""Inputs of an ANFIS: checked, and scaled."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array

HELD = 1.1
"""Scaled inputs are held within this: a little beyond the data the rules still hold, far away they do not."""


@dataclass(frozen=True)
class InputScale:
    """Scales the range of each of d inputs to [−1, 1]."""

    lower: Array
    """(d,) least value, in the unit of the input."""
    upper: Array
    """(d,) greatest value."""

    @property
    def middle(self) -> Array:
        """(d,) what becomes 0."""
        return 0.5 * (self.lower + self.upper)

    @property
    def half(self) -> Array:
        """(d,) how far from the middle is 1."""
        return 0.5 * (self.upper - self.lower)

    def scaled(self, X: Array) -> Array:
        """Scaled inputs (d,N), held near the range, of inputs (N,d)."""
        return np.clip((X.T - self.middle[:, None]) / self.half[:, None], -HELD, HELD)


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
