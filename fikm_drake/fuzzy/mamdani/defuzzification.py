"""One number from an aggregate.

Each function takes an aggregate of n conclusions and their strengths (n, N), of which one in every
column is positive, to values (N,).
"""

from collections.abc import Callable

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.fuzzy.mamdani.aggregate import Aggregate, integral_weights

TIE = 1e-9
"""Heights within this fraction are equal; lengths under this fraction of the range are a point."""


def height(aggregate: Aggregate, strengths: Array) -> Array:
    """The mean of the middles of the cores, weighted by the strengths; exact."""
    return aggregate.cores.mean(axis=1) @ strengths / strengths.sum(axis=0)


def centroid(aggregate: Aggregate, strengths: Array) -> Array:
    """The centre of the area under the aggregate.

    Exact for a sum of triangles and trapezoids, whose areas and moments add. Everything else is
    taken to be linear between the samples of the grid.
    """
    if aggregate.adds and not aggregate.cuts_off:
        area, moment = aggregate.scaled @ strengths
    elif aggregate.adds and not aggregate.stack.has_gaussian:
        first, last = np.broadcast_to(aggregate.supports.T[..., None], (2, *strengths.shape))
        nodes = np.stack([first, *aggregate.tops(strengths), last])
        grades = aggregate.stack.grades(nodes.swapaxes(0, 1)).swapaxes(0, 1)
        heights = aggregate.implied(strengths, grades)
        area, moment = (integral_weights(nodes) * heights).sum(axis=(1, 2))
    else:
        area, moment = aggregate.weights @ aggregate.on_grid(strengths)
    return moment / area


def mean_of_maximum(aggregate: Aggregate, strengths: Array) -> Array:
    """The centre of where the aggregate is greatest; of several intervals, of all together.

    Where it is greatest at points only, their mean. Exact, but for a sum with Gaussians.
    """
    return (_top_of_sum if aggregate.adds else _top_of_maximum)(aggregate, strengths)


def _top_of_maximum(aggregate: Aggregate, strengths: Array) -> Array:
    """The top is where the strongest conclusions are cut off, or their cores."""
    left, right = aggregate.tops(strengths)
    strongest = strengths >= np.maximum.reduce(strengths) * (1.0 - TIE)
    upper = aggregate.bounds[1]
    # The union of intervals: the k-th end from the left closes what the k-th start or, if that is
    # further right, the end before has opened. The others are intervals of no width, out of the way.
    starts = np.sort(np.where(strongest, left, upper), axis=0)
    ends = np.sort(np.where(strongest, right, upper), axis=0)
    starts[1:] = np.maximum(starts[1:], ends[:-1])
    return _centre(aggregate, starts, ends - starts, left, strongest)


def _top_of_sum(aggregate: Aggregate, strengths: Array) -> Array:
    """A sum of concave pieces is greatest between ends of cuts or of cores: the nodes.

    A sum with Gaussians is looked at on the grid too.
    """
    nodes = np.concatenate(aggregate.tops(strengths))
    if aggregate.stack.has_gaussian:
        grid = np.broadcast_to(aggregate.grid[:, None], (aggregate.grid.size, nodes.shape[1]))
        nodes = np.concatenate([nodes, grid])
    nodes.sort(axis=0)
    widths = nodes[1:] - nodes[:-1]
    places = np.concatenate([nodes, nodes[:-1] + 0.5 * widths])
    grades = aggregate.stack.grades(places[None])
    heights = np.add.reduce(aggregate.implied(strengths[:, None], grades))
    top = heights >= np.maximum.reduce(heights[: len(nodes)]) * (1.0 - TIE)
    # Between nodes the sum is convex: level if its middle is as high as its ends.
    ends, middles = top[: len(nodes)], top[len(nodes) :]
    return _centre(aggregate, nodes[:-1], widths * (ends[:-1] & ends[1:] & middles), nodes, ends)


def _centre(
    aggregate: Aggregate, starts: Array, widths: Array, points: Array, on_top: Bools
) -> Array:
    """Centre of disjoint intervals; where all are mere points, the mean of the points on top."""
    lower, upper = aggregate.bounds
    least = TIE * (upper - lower)
    length = np.add.reduce(widths)
    moment = np.add.reduce(widths * (starts + 0.5 * widths))
    is_long = length > least
    if is_long.all():
        return moment / length
    # Points in one place count once.
    points = np.sort(np.where(on_top, points, 2.0 * lower - upper), axis=0)
    counted = points >= lower
    counted[1:] &= points[1:] - points[:-1] > least
    mean = np.add.reduce(points * counted) / np.add.reduce(counted)
    return np.where(is_long, moment / np.where(is_long, length, 1.0), mean)


DEFUZZIFY: dict[str, Callable[[Aggregate, Array], Array]] = {
    "centroid": centroid,
    "mean_of_maximum": mean_of_maximum,
    "height": height,
}
"""The methods by name."""
