"""Many memberships at once."""

from collections.abc import Sequence

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.memberships import (
    Gaussian,
    Membership,
    gaussian_grades,
    trapezoid_edges,
    trapezoid_grades,
)


class MembershipStack:
    """Memberships as arrays, one row each: a call costs about the same for one as for ten."""

    def __init__(self, memberships: Sequence[Membership]) -> None:
        """Stacks valid memberships (n), at least one."""
        bells = [shape for shape in memberships if isinstance(shape, Gaussian)]
        cornered = [shape for shape in memberships if not isinstance(shape, Gaussian)]
        self._is_bell = np.array([isinstance(shape, Gaussian) for shape in memberships])
        self._means = np.reshape([(bell.mean, bell.sigma) for bell in bells], (-1, 2)).T
        self._bell_supports = np.reshape([bell.support for bell in bells], (-1, 2)).T
        corners = np.reshape([shape.corners for shape in cornered], (-1, 4)).T
        self._edges = trapezoid_edges(corners)
        self._tops = corners[1:3]
        left, rise, right, fall = self._edges
        inside = 4.0 * np.spacing(np.maximum(np.abs(left), np.abs(right)))
        self._cut_from = _columns([left + inside, rise, corners[1]], 2)
        self._cut_to = _columns([right - inside, fall, corners[2]], 2)
        # Ready to broadcast with values (n, N) and (n, K, N).
        self._edges_of = {ndim: _columns(self._edges, ndim) for ndim in (2, 3)}
        self._means_of = {ndim: _columns(self._means, ndim) for ndim in (2, 3)}

    @property
    def has_gaussian(self) -> bool:
        """Whether one of them is a Gaussian; the others are linear between corners."""
        return self._means.size > 0

    @property
    def flanks(self) -> Array:
        """Foot and top of every slope, shape (k, 2)."""
        left, _, right, _ = self._edges
        feet = [left, right, *self._bell_supports]
        tops = [*self._tops, self._means[0], self._means[0]]
        return np.stack([np.concatenate(feet), np.concatenate(tops)], axis=1)

    def grades(self, x: Array) -> Array:
        """Grades of values.

        Args:
            x: values of each membership, shape (n, N) or (n, K, N); or the same for all, with 1 in
                the place of n.

        Returns:
            Grades, shape (n, N) or (n, K, N).
        """
        edges = self._edges_of[x.ndim]
        if not self.has_gaussian:
            return trapezoid_grades(x, edges)
        x = np.broadcast_to(x, (self._is_bell.size, *x.shape[1:]))
        grades = np.empty(x.shape)
        grades[~self._is_bell] = trapezoid_grades(x[~self._is_bell], edges)
        grades[self._is_bell] = gaussian_grades(x[self._is_bell], self._means_of[x.ndim])
        return grades

    def cuts(self, level: Array) -> tuple[Array, Array]:
        """Ends of the intervals where the grades are at least a level.

        The ends are more than a rounding error inside the intervals, where these are wider: so the
        grade there is no less than the level, however low it is.

        Args:
            level: one of each membership, in [0, 1], shape (n, N).

        Returns:
            Left and right ends, each of shape (n, N); infinite for a Gaussian at level 0.
        """
        if not self.has_gaussian:
            return self._cuts_of_cornered(level)
        ends = np.empty((2, *level.shape))
        ends[:, ~self._is_bell] = self._cuts_of_cornered(level[~self._is_bell])
        mean, sigma = self._means_of[2]
        with np.errstate(divide="ignore"):
            reach = sigma * np.sqrt(-2.0 * np.log(level[self._is_bell]))
        ends[:, self._is_bell] = mean - reach, mean + reach
        return ends[0], ends[1]

    def _cuts_of_cornered(self, level: Array) -> tuple[Array, Array]:
        left, rise, top_left = self._cut_from
        right, fall, top_right = self._cut_to
        return np.minimum(left + level * rise, top_left), np.maximum(
            right - level * fall, top_right
        )


def _columns(rows: Sequence[Array] | Array, ndim: int) -> tuple[Array, ...]:
    """Each row (n,) with shape (n, 1, …) of so many dimensions."""
    return tuple(np.reshape(row, (-1, *(1,) * (ndim - 1))) for row in rows)
