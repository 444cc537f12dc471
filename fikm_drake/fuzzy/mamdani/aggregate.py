"""The united conclusions of the rules, a membership over the range of an output."""

from collections.abc import Sequence

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.membership_stack import MembershipStack
from fikm_drake.fuzzy.memberships import Membership

FLANK = np.linspace(0.0, 1.0, 17)
"""Samples of a narrow flank, from foot to top: so that a narrow membership is not lost."""


class Aggregate:
    """Conclusions that strengths cut off or scale and that are then united.

    Attributes:
        bounds: lower and upper end of the output.
        cuts_off: whether the implication is the minimum; else it is the product.
        adds: whether the conclusions are added; else their maximum is taken.
        stack: memberships of the conclusions (n).
        cores: from where to where each has grade one, inside the range, shape (n, 2).
        supports: from where to where each is not zero, inside the range, shape (n, 2).
        grid: even samples of the range, all corners, and more on narrow flanks, shape (K,).
        weights: `integral_weights` of the grid, shape (2, K).
        scaled: area and first moment of each membership on the grid, shape (2, n).
    """

    def __init__(
        self,
        shapes: Sequence[Membership],
        bounds: tuple[float, float],
        *,
        cuts_off: bool,
        adds: bool,
        samples: int,
    ) -> None:
        """Prepares the conclusions; see the class. `samples` is the size of the even grid."""
        self.bounds, self.cuts_off, self.adds = bounds, cuts_off, adds
        lower, upper = bounds
        self._imply = np.minimum if cuts_off else np.multiply
        self._unite = np.add if adds else np.maximum
        self.stack = MembershipStack(shapes)
        self.cores = np.clip([shape.core for shape in shapes], lower, upper)
        self.supports = np.clip([shape.support for shape in shapes], lower, upper)
        self.grid = _grid(lower, upper, samples, self.stack.flanks)
        self.weights = integral_weights(self.grid)
        all_grades = self.stack.grades(self.grid[None])
        self.scaled = self.weights @ all_grades.T
        # The part of the grid where a membership is not zero, and its grades there.
        self._parts = [
            (slice(inside[0], inside[-1] + 1), grades[inside[0] : inside[-1] + 1, None])
            for grades in all_grades
            for inside in [np.flatnonzero(grades)]
        ]

    @property
    def size(self) -> int:
        """Numbers in the largest array that a point needs, for any defuzzification."""
        if not self.adds:
            return self.grid.size
        n = len(self.cores)
        return max(self.grid.size, 2 * n * (2 * n + self.stack.has_gaussian * self.grid.size))

    def tops(self, strengths: Array) -> tuple[Array, Array]:
        """Where each conclusion is cut off, or its core if it is scaled: from, to, inside the range.

        Args:
            strengths: shape (n, N).

        Returns:
            Left and right ends, each of shape (n, N).
        """
        left, right = self.stack.cuts(strengths if self.cuts_off else np.ones(strengths.shape))
        return np.maximum(left, self.bounds[0]), np.minimum(right, self.bounds[1])

    def implied(self, strengths: Array, grades: Array) -> Array:
        """Grades of the conclusions cut off or scaled; arguments that broadcast."""
        return self._imply(strengths, grades)

    def on_grid(self, strengths: Array) -> Array:
        """Heights of the aggregate on the grid, shape (K, N), of strengths (n, N)."""
        heights = np.zeros((self.grid.size, strengths.shape[1]))
        for strength, (part, grades) in zip(strengths, self._parts):
            inside = heights[part]
            self._unite(inside, self._imply(strength, grades), out=inside)
        return heights


def _grid(lower: float, upper: float, samples: int, flanks: Array) -> Array:
    even = np.linspace(lower, upper, samples)
    foot, way = flanks[:, :1], np.diff(flanks)
    narrow = np.abs(way[:, 0]) < (FLANK.size - 1) * (even[1] - even[0])
    more = foot[narrow] + way[narrow] * FLANK
    return np.unique(np.clip(np.concatenate([even, flanks, more], axis=None), lower, upper))


def integral_weights(nodes: Array) -> Array:
    """Weights of a function's values in its integral and in its first moment.

    Args:
        nodes: where the values are, along the first axis, shape (K, ...), not decreasing.

    Returns:
        Shape (2, K, ...); exact for functions that are linear between nodes.
    """
    left, right = nodes[:-1], nodes[1:]
    width = right - left
    weights = np.zeros((2, *nodes.shape))
    weights[0, :-1] += width / 2.0
    weights[0, 1:] += width / 2.0
    weights[1, :-1] += width * (2.0 * left + right) / 6.0
    weights[1, 1:] += width * (left + 2.0 * right) / 6.0
    return weights
