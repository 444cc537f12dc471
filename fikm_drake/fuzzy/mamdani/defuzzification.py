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

GAP = 1e-12
"""An area less than this fraction of all is none."""


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


def bisector(aggregate: Aggregate, strengths: Array) -> Array:
    """Where half of the area is on either side; the aggregate is linear between samples of the grid.

    Exact for a sum of scaled triangles and trapezoids, whose corners are all on the grid. Where the
    half is a gap with no area, its middle.
    """
    heights = aggregate.on_grid(strengths)
    widths = np.diff(aggregate.grid)[:, None]
    areas = np.cumsum(0.5 * widths * (heights[1:] + heights[:-1]), axis=0)
    half = 0.5 * areas[-1]
    return 0.5 * (
        _reaches(aggregate.grid, heights, areas, half * (1.0 - GAP))
        + _reaches(aggregate.grid, heights, areas, half * (1.0 + GAP))
    )


def _reaches(grid: Array, heights: Array, areas: Array, wanted: Array) -> Array:
    """Where the area from the left (K - 1,N) reaches what is wanted (N,), linear heights (K,N)."""
    lane = np.arange(wanted.size)
    cell = np.minimum((areas < wanted).sum(axis=0), len(areas) - 1)
    left, right, width = heights[cell, lane], heights[cell + 1, lane], np.diff(grid)[cell]
    missing = wanted - np.where(cell > 0, areas[cell - 1, lane], 0.0)
    # left s + slope s²/2 = missing, by the root that has no cancellation.
    slope = (right - left) / width
    root = np.sqrt(np.maximum(left * left + 2.0 * slope * missing, 0.0))
    way = 2.0 * missing / np.maximum(left + root, np.finfo(float).tiny)
    return grid[cell] + np.clip(way, 0.0, width)


def smallest_of_maximum(aggregate: Aggregate, strengths: Array) -> Array:
    """The least place where the aggregate is greatest. Exact, but for a sum with Gaussians."""
    first, _ = _ends(aggregate, strengths)
    return first


def largest_of_maximum(aggregate: Aggregate, strengths: Array) -> Array:
    """The last place where the aggregate is greatest. Exact, but for a sum with Gaussians."""
    _, last = _ends(aggregate, strengths)
    return last


def _ends(aggregate: Aggregate, strengths: Array) -> tuple[Array, Array]:
    if aggregate.adds:
        left = right = nodes = _nodes(aggregate, strengths)
        heights = np.add.reduce(
            aggregate.implied(strengths[:, None], aggregate.stack.grades(nodes[None]))
        )
        top = heights >= np.maximum.reduce(heights) * (1.0 - TIE)
    else:
        left, right = aggregate.tops(strengths)
        top = strengths >= np.maximum.reduce(strengths) * (1.0 - TIE)
    first = np.where(top, left, np.inf).min(axis=0)
    return first, np.where(top, right, -np.inf).max(axis=0)


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
    nodes = _nodes(aggregate, strengths)
    widths = nodes[1:] - nodes[:-1]
    places = np.concatenate([nodes, nodes[:-1] + 0.5 * widths])
    grades = aggregate.stack.grades(places[None])
    heights = np.add.reduce(aggregate.implied(strengths[:, None], grades))
    top = heights >= np.maximum.reduce(heights[: len(nodes)]) * (1.0 - TIE)
    # Between nodes the sum is convex: level if its middle is as high as its ends.
    ends, middles = top[: len(nodes)], top[len(nodes) :]
    return _centre(aggregate, nodes[:-1], widths * (ends[:-1] & ends[1:] & middles), nodes, ends)


def _nodes(aggregate: Aggregate, strengths: Array) -> Array:
    """Where a sum can be greatest, sorted (nodes,N)."""
    nodes = np.concatenate(aggregate.tops(strengths))
    if aggregate.stack.has_gaussian:
        grid = np.broadcast_to(aggregate.grid[:, None], (aggregate.grid.size, nodes.shape[1]))
        nodes = np.concatenate([nodes, grid])
    nodes.sort(axis=0)
    return nodes


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
    "bisector": bisector,
    "mean_of_maximum": mean_of_maximum,
    "smallest_of_maximum": smallest_of_maximum,
    "largest_of_maximum": largest_of_maximum,
    "height": height,
}
"""The methods by name."""
