"""Many memberships at once."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.memberships import (
    Gaussian,
    Membership,
    gaussian_grades,
    sloped,
    trapezoid_grades,
)

Array = NDArray[np.float64]


class MembershipStack:
    """Memberships as arrays, one row each: a call costs the same for one as for ten."""

    def __init__(self, memberships: Sequence[Membership]) -> None:
        """Stacks valid memberships (n), at least one."""
        self._gaussian = np.array([isinstance(m, Gaussian) for m in memberships])
        corners = [m.corners for m in memberships if not isinstance(m, Gaussian)]
        self._corners = sloped(np.reshape(corners, (-1, 4)).T)
        bells = [(m.mean, m.sigma) for m in memberships if isinstance(m, Gaussian)]
        self._bells = np.reshape(bells, (-1, 2)).T

    @property
    def has_gaussian(self) -> bool:
        """Whether one of them is a Gaussian; the others are linear between corners."""
        return bool(self._bells.size)

    def grades(self, x: Array) -> Array:
        """Grades of values.

        Args:
            x: values of each membership, shape (n, ...), or the same for all, shape (1, ...).

        Returns:
            Grades, shape (n, ...).
        """
        tail = (1,) * (x.ndim - 1)
        if not self.has_gaussian:
            return trapezoid_grades(x, self._corners.reshape(4, -1, *tail))
        x = np.broadcast_to(x, (self._gaussian.size, *x.shape[1:]))
        grades = np.empty(x.shape)
        grades[~self._gaussian] = trapezoid_grades(
            x[~self._gaussian], self._corners.reshape(4, -1, *tail)
        )
        grades[self._gaussian] = gaussian_grades(
            x[self._gaussian], self._bells.reshape(2, -1, *tail)
        )
        return grades

    def cuts(self, level: Array) -> tuple[Array, Array]:
        """Ends of the intervals where the grades are at least a level in [0, 1].

        Args:
            level: one of each membership, shape (n, N).

        Returns:
            Left and right ends, each of shape (n, N); infinite for a Gaussian at level 0.
        """
        left, right = np.empty(level.shape), np.empty(level.shape)
        first, top_left, top_right, last = self._corners[:, :, None]
        rows = level[~self._gaussian]
        left[~self._gaussian] = first + rows * (top_left - first)
        right[~self._gaussian] = last - rows * (last - top_right)
        mean, sigma = self._bells[:, :, None]
        with np.errstate(divide="ignore"):
            reach = sigma * np.sqrt(-2.0 * np.log(level[self._gaussian]))
        left[self._gaussian], right[self._gaussian] = mean - reach, mean + reach
        return left, right
