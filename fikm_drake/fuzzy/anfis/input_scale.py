"""The scaling of inputs."""

from dataclasses import dataclass

import numpy as np

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
