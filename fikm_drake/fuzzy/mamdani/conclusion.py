"""From the strengths of the rules to one output."""

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani.mamdani_config import MamdaniConfig
from fikm_drake.fuzzy.membership_stack import MembershipStack

Array = NDArray[np.float64]

LEAST_STRENGTH = 1e-100
"""Of a rule that fires; what is less could underflow in an area."""
TIE = 1e-9
"""Heights within this fraction are equal, lengths under this fraction of the range are a point."""


class Conclusion:
    """Implication, aggregation and defuzzification of one output.

    The *aggregate* is the united membership. Rules with the same label are united first, except
    where cut-off conclusions are summed, which has to be done rule by rule.

    - *centroid*: the aggregate is sampled on a grid that has all corners of the memberships on it,
      and taken to be linear between samples. The error falls with the square of the spacing.
      Exact, without samples, for the sum of scaled triangles and trapezoids.
    - *mean of maximum*: exact for triangles and trapezoids, and for Gaussians under the maximum: the
      aggregate is greatest on intervals that end where a conclusion is cut off, or at tops. A sum of
      Gaussians is looked at on the grid too. Where it is greatest on several intervals this is the
      centre of all together; where only at points, the mean of the points.
    - *height*: exact: the middles of the cores, weighted by the strengths.
    """

    def __init__(self, variable: FuzzyVariable, config: MamdaniConfig) -> None:
        """Prepares the samples of an output of a valid config."""
        self._lower, self._upper = variable.lower, variable.upper
        default = variable.default
        self._default = 0.5 * (variable.lower + variable.upper) if default is None else default
        self._implication = np.minimum if config.implication == "minimum" else np.multiply
        self._aggregation = np.add if config.aggregation == "sum" else np.maximum

        name = variable.name
        rules = [n for n, rule in enumerate(config.rules) if name in rule.then]
        rules.sort(key=lambda n: variable.labels.index(config.rules[n].then[name]))
        labels = [config.rules[n].then[name] for n in rules]
        self._rules = np.array(rules)
        self._cuts_off = self._implication is np.minimum
        self._united = not (self._cuts_off and self._aggregation is np.add)
        if self._united:
            starts = [n for n, label in enumerate(labels) if n == 0 or label != labels[n - 1]]
            self._starts, labels = np.array(starts), [labels[n] for n in starts]

        shapes = [variable.memberships[label] for label in labels]
        self._stack = MembershipStack(shapes)
        cores = np.clip([shape.core for shape in shapes], self._lower, self._upper)
        self._middles = cores.mean(axis=1)
        ends = np.array([(*shape.core, *shape.support) for shape in shapes])
        inside = ends[(ends > self._lower) & (ends < self._upper)]
        self._grid = np.union1d(np.linspace(self._lower, self._upper, config.samples), inside)
        self._samples = self._stack.grades(self._grid[None])
        self._moments = _moments(self._grid)
        self._defuzzify = {
            "centroid": self._centroid,
            "mean_of_maximum": self._mean_of_maximum,
            "height": self._height,
        }[config.defuzzification]
        self.cost = self._samples.size
        """Numbers that one point of a batch needs at a time."""

    def __call__(self, strengths: Array) -> tuple[Array, Array]:
        """The output and whether a rule fired.

        Args:
            strengths: of all rules, shape (rules, N).

        Returns:
            The output, shape (N,), in the unit of the variable, inside its range; the default where
            no rule fired. Whether one did, shape (N,).
        """
        strengths = strengths[self._rules]
        if self._united:
            strengths = self._aggregation.reduceat(strengths, self._starts, axis=0)
        fired = strengths.max(axis=0) > LEAST_STRENGTH
        if fired.all():
            return np.clip(self._defuzzify(strengths), self._lower, self._upper), fired
        value = np.full(fired.shape, self._default)
        if fired.any():
            value[fired] = np.clip(self._defuzzify(strengths[:, fired]), self._lower, self._upper)
        return value, fired

    def _height(self, strengths: Array) -> Array:
        return self._middles @ strengths / strengths.sum(axis=0)

    def _centroid(self, strengths: Array) -> Array:
        if self._aggregation is np.add and not self._cuts_off:
            area, moment = (self._moments @ self._samples.T) @ strengths
        else:
            area, moment = self._moments @ self._aggregate(strengths, self._samples[:, :, None])
        return moment / area

    def _mean_of_maximum(self, strengths: Array) -> Array:
        nodes = np.concatenate(
            self._stack.cuts(strengths if self._cuts_off else np.ones(strengths.shape))
        )
        if self._stack.has_gaussian and self._aggregation is np.add:
            grid = np.broadcast_to(self._grid[:, None], (self._grid.size, nodes.shape[1]))
            nodes = np.concatenate([nodes, grid])
        nodes = np.sort(np.clip(nodes, self._lower, self._upper), axis=0)
        middles = 0.5 * (nodes[1:] + nodes[:-1])
        heights = self._aggregate(strengths, self._stack.grades(nodes[None]))
        floor = heights.max(axis=0) * (1.0 - TIE)
        top = heights >= floor
        # Between nodes the aggregate is convex, so flat where its middle is as high as its ends.
        flat = self._aggregate(strengths, self._stack.grades(middles[None])) >= floor
        widths = np.where(top[1:] & top[:-1] & flat, np.diff(nodes, axis=0), 0.0)
        length = widths.sum(axis=0)
        wide = length > TIE * (self._upper - self._lower)
        points = np.where(top, nodes, 0.0).sum(axis=0) / top.sum(axis=0)
        return np.where(wide, (widths * middles).sum(axis=0) / np.where(wide, length, 1.0), points)

    def _aggregate(self, strengths: Array, grades: Array) -> Array:
        """The aggregate (K, N) from strengths (n, N) and grades (n, K, N or 1)."""
        return self._aggregation.reduce(self._implication(strengths[:, None], grades), axis=0)


def _moments(grid: Array) -> Array:
    """Weights (2, K) that give area and first moment of a function linear between samples."""
    left, right = grid[:-1], grid[1:]
    width = right - left
    weights = np.zeros((2, grid.size))
    weights[0, :-1] += width / 2.0
    weights[0, 1:] += width / 2.0
    weights[1, :-1] += width * (2.0 * left + right) / 6.0
    weights[1, 1:] += width * (left + 2.0 * right) / 6.0
    return weights
