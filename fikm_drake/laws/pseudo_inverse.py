"""The pseudo-inverse, exact and unsafe near singular postures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_below_one
from fikm_drake.laws.law import as_arrays


@dataclass
class PseudoInverse:
    """dθ = J⁺ dr, a law `(J, dr) -> joint_step`.

    Attributes:
        cutoff: singular values up to this fraction of the largest count as zero [-].

    Raises:
        ValueError: the cutoff is not in [0, 1).

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> fd.PseudoInverse()(np.diag([1.0, 2.0]), np.ones(2)).tolist()
        [1.0, 0.5]
    """

    cutoff: float = 1e-9

    def __post_init__(self) -> None:
        check_below_one("cutoff", self.cutoff)

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) [rad or m] for a Jacobian (…,m,n) and a task error (…,m)."""
        J, dr = as_arrays(J, dr)
        return (np.linalg.pinv(J, self.cutoff) @ dr[..., None])[..., 0]

    step = __call__
