"""The Jacobian transpose with the step length that is best along it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.laws.law import as_arrays


@dataclass
class JacobianTranspose:
    """dθ = α Jᵀ dr with the α that leaves the least |dr − J dθ|, a law `(J, dr) -> joint_step`.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> fd.JacobianTranspose()(np.eye(2), np.ones(2)).tolist()
        [1.0, 1.0]
    """

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) [rad or m] for a Jacobian (…,m,n) and a task error (…,m)."""
        J, dr = as_arrays(J, dr)
        direction = (dr[..., None, :] @ J)[..., 0, :]
        image = (J @ direction[..., None])[..., 0]
        along = (image * dr).sum(-1, keepdims=True)
        square = (image * image).sum(-1, keepdims=True)
        # At the dead point, Jᵀ dr = 0, there is no direction to go.
        return direction * np.divide(along, square, out=np.zeros_like(along), where=square > 1e-200)

    step = __call__
