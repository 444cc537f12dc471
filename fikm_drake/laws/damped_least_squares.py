"""Damped least squares, the strongest ordinary alternative."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_positive_finite
from fikm_drake.laws.law import as_arrays

ROUNDING = 1e-12
"""λ² is at least this fraction of the trace of J Jᵀ: less is lost in rounding where J is singular [-]."""


@dataclass
class DampedLeastSquares:
    """dθ = Jᵀ (J Jᵀ + λ² I)⁻¹ dr, a law `(J, dr) -> joint_step`.

    Attributes:
        damping: λ, in the unit of J (m for position rows); more is calmer and slower. It
            counts as at least a millionth of J's size.

    Raises:
        ValueError: the damping is not positive and finite.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> fd.DampedLeastSquares(damping=1e-6)(np.diag([1.0, 2.0]), np.ones(2)).round(3).tolist()
        [1.0, 0.5]
    """

    damping: float = 0.05

    def __post_init__(self) -> None:
        check_positive_finite("damping", self.damping, "unit of J")

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) [rad or m] for a Jacobian (…,m,n) and a task error (…,m)."""
        J, dr = as_arrays(J, dr)
        JT = np.swapaxes(J, -1, -2)
        square = J @ JT
        trace = np.trace(square, axis1=-2, axis2=-1)[..., None, None]
        most = np.maximum(self.damping * self.damping, ROUNDING * trace)
        square = square + np.where(np.eye(J.shape[-2]), most, 0.0)
        return (JT @ np.linalg.solve(square, dr[..., None]))[..., 0]

    step = __call__
