"""Many memberships at once."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.memberships import (
    Gaussian,
    Membership,
    gaussian_grades,
    trapezoid_edges,
    trapezoid_grades,
)

Array = NDArray[np.float64]


class MembershipStack:
    """Memberships as arrays, one row each: a call costs about the same for one as for ten."""

    def __init__(self, memberships: Sequence[Membership]) -> None:
        """Stacks valid memberships (n), at least one."""
        bells = [isinstance(shape, Gaussian) for shape in memberships]
        self._bells, self._cornered = np.flatnonzero(bells), np.flatnonzero(np.logical_not(bells))
        corners = [shape.corners for shape in memberships if not isinstance(shape, Gaussian)]
        self._edges = trapezoid_edges(np.reshape(corners, (-1, 4)).T)
        left, rise, right, fall = self._edges
        rounding = 4.0 * np.spacing(np.maximum(np.abs(left), np.abs(right)))
        self._insides = np.stack([left + rounding, left + rise, right - rounding, right - fall])
        means = [(shape.mean, shape.sigma) for shape in memberships if isinstance(shape, Gaussian)]
        self._means = np.reshape(means, (-1, 2)).T

    @property
    def has_gaussian(self) -> bool:
        """Whether one of them is a Gaussian; the others are linear between corners."""
        return self._bells.size > 0

    @property
    def flanks(self) -> Array:
        """Foot and top of every slope, shape (k, 2). The foot of a Gaussian is at six sigmas."""
        left, rise, right, fall = self._edges
        mean, sigma = self._means
        feet = [left, right, mean - 6.0 * sigma, mean + 6.0 * sigma]
        tops = [left + rise, right - fall, mean, mean]
        return np.stack([np.concatenate(feet), np.concatenate(tops)], axis=1)

    def grades(self, x: Array) -> Array:
        """Grades of values.

        Args:
            x: values of each membership, shape (n, ...), or the same for all, shape (1, ...).

        Returns:
            Grades, shape (n, ...).
        """
        tail = (1,) * (x.ndim - 1)
        edges = self._edges.reshape(4, -1, *tail)
        if not self.has_gaussian:
            return trapezoid_grades(x, edges)
        grades = np.empty((self._bells.size + self._cornered.size, *x.shape[1:]))
        x = np.broadcast_to(x, grades.shape)
        grades[self._cornered] = trapezoid_grades(x[self._cornered], edges)
        means = self._means.reshape(2, -1, *tail)
        grades[self._bells] = gaussian_grades(x[self._bells], means)
        return grades

    def cuts(self, level: Array) -> tuple[Array, Array]:
        """Ends of the intervals where the grades are at least a level.

        The ends are more than a rounding error inside the intervals, where these are wider: so the
        grade there is no less than the level, however low it is.

        Args:
            level: one of each membership, in (0, 1], shape (n, N).

        Returns:
            Left and right ends, each of shape (n, N).
        """
        first, top_left, last, top_right = self._insides[:, :, None]
        _, rise, _, fall = self._edges[:, :, None]
        cornered = level[self._cornered] if self.has_gaussian else level
        left = np.minimum(first + cornered * rise, top_left)
        right = np.maximum(last - cornered * fall, top_right)
        if not self.has_gaussian:
            return left, right
        mean, sigma = self._means[:, :, None]
        with np.errstate(divide="ignore"):
            reach = sigma * np.sqrt(-2.0 * np.log(level[self._bells]))
        order = np.argsort(np.concatenate([self._cornered, self._bells]))
        return np.concatenate([left, mean - reach])[order], np.concatenate([right, mean + reach])[
            order
        ]
