"""What every differential-IK law offers."""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array


class Law(Protocol):
    """A pure function (J, dr) to a joint step; `DifferentialIk` and the controllers take any.

    A law with an attribute `takes_damping` that is true takes the supervisor's damping as a third
    argument of `step`.
    """

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) for a Jacobian (…,m,n) and a task error (…,m)."""

    def step(self, J: Array, dr: Array) -> Array:
        """The same for one (m,n) and one (m,), unchecked, for a control loop."""


def takes_damping(law: Law) -> bool:
    """True if the law's `step` takes a damping."""
    return bool(getattr(law, "takes_damping", False))


def as_arrays(J: ArrayLike, dr: ArrayLike) -> tuple[Array, Array]:
    """A Jacobian (…,m,n) and a task error (…,m); ValueError, naming the shapes, if they do not fit."""
    J, dr = np.asarray(J, dtype=float), np.asarray(dr, dtype=float)
    if J.ndim < 2 or dr.ndim < 1 or not J.shape[-2] == dr.shape[-1] > 0 < J.shape[-1]:
        raise ValueError(f"J must be (…, m, n) and dr (…, m), got {J.shape} and {dr.shape}")
    return J, dr
