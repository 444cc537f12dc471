"""The pseudo-inverse, exact and unsafe near singular postures."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class PseudoInverse:
    """dθ = J⁺ dr, a law `(J, dr) -> joint_step`.

    Args:
        cutoff: singular values up to this fraction of the largest count as zero [-].

    Raises:
        ValueError: the cutoff is not in [0, 1).
    """

    def __init__(self, cutoff: float = 1e-9) -> None:
        if not 0.0 <= cutoff < 1.0:
            raise ValueError(f"cutoff must be in [0, 1), got {cutoff!r}")
        self.cutoff = float(cutoff)

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) [rad or m] for a Jacobian (…,m,n) and a task error (…,m)."""
        dr = np.asarray(dr, dtype=float)
        inverse = np.linalg.pinv(np.asarray(J, dtype=float), self.cutoff)
        return (inverse @ dr[..., None])[..., 0]

    step = __call__
