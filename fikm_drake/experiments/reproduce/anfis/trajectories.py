"""The trajectories of the thesis."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array


@dataclass(frozen=True)
class Trajectory:
    """Straight sides from corner to corner; each side is the same share of the whole."""

    name: str
    """A letter."""
    corners: tuple[tuple[float, float], ...]
    """(x, y) [m], in order."""

    def at(self, percent: ArrayLike) -> Array:
        """Points (…,2) [m] at shares (…) of the trajectory [%]."""
        shares = np.linspace(0.0, 100.0, len(self.corners))
        x, y = np.transpose(self.corners)
        percent = np.asarray(percent, dtype=float)
        return np.stack([np.interp(percent, shares, x), np.interp(percent, shares, y)], axis=-1)


A = Trajectory("A", ((-1.0, 2.0), (1.0, 2.0), (1.0, 4.0), (-1.0, 4.0), (-1.0, 2.0)))
"""Table 3.2: a square."""
B = Trajectory("B", ((-2.0, 1.0), (2.5, 1.0), (2.5, 2.0), (-2.0, 2.0), (-2.0, 1.0)))
"""Table 3.3: a rectangle that leaves the workspace."""
C = Trajectory("C", ((-0.5, 2.5), (1.5, 3.0), (1.5, 1.5), (-0.5, 2.5)))
"""Figure 4.15: a triangle. The thesis draws it and gives no numbers; these are ours."""
