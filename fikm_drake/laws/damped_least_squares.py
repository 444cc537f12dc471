"""Damped least squares, the strongest ordinary alternative."""

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class DampedLeastSquares:
    """dθ = Jᵀ (J Jᵀ + λ² I)⁻¹ dr, a law `(J, dr) -> joint_step`.

    Args:
        damping: λ, in the unit of J (m for position rows).

    Raises:
        ValueError: the damping is not positive and finite.
    """

    def __init__(self, damping: float = 0.05) -> None:
        if not (isfinite(damping) and damping > 0.0):
            raise ValueError(f"damping must be positive and finite, got {damping!r}")
        self.damping = float(damping)

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) [rad or m] for a Jacobian (…,m,n) and a task error (…,m)."""
        J, dr = np.asarray(J, dtype=float), np.asarray(dr, dtype=float)
        JT = np.swapaxes(J, -1, -2)
        square = J @ JT + self.damping**2 * np.eye(J.shape[-2])
        return (JT @ np.linalg.solve(square, dr[..., None]))[..., 0]

    step = __call__
