"""One number from an aggregate.

Each function takes an aggregate of n conclusions and their strengths (n, N), of which one in every
column is positive, to values (N,).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.mamdani.aggregate import Aggregate, integral_weights

Array = NDArray[np.float64]

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
        left, right = aggregate.stack.cuts(strengths)
        nodes = np.clip([first, left, right, last], *aggregate.range)
        grades = aggregate.stack.grades(nodes.swapaxes(0, 1)).swapaxes(0, 1)
        heights = aggregate.implied(strengths, grades)
        area, moment = (integral_weights(nodes) * heights).sum(axis=(1, 2))
    else:
        area, moment = aggregate.weights @ aggregate(strengths, aggregate.samples[:, :, None])
    return moment / area


def mean_of_maximum(aggregate: Aggregate, strengths: Array) -> Array:
    """The centre of where the aggregate is greatest; of several intervals, of all together.

    Where it is greatest at points only, their mean. Exact but for a sum with Gaussians: the maximum
    of concave pieces is between ends of tops or of cuts, and only these are looked at. A sum with
    Gaussians is looked at on the grid too.
    """
    ends = aggregate.stack.cuts(strengths if aggregate.cuts_off else np.ones(strengths.shape))
    nodes = np.clip(np.concatenate(ends), *aggregate.range)
    if aggregate.adds and aggregate.stack.has_gaussian:
        grid = np.broadcast_to(aggregate.grid[:, None], (aggregate.grid.size, nodes.shape[1]))
        nodes = np.concatenate([nodes, grid])
    nodes.sort(axis=0)
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    places = np.concatenate([nodes, middles])
    heights = aggregate(strengths, aggregate.stack.grades(places[None]))
    greatest = heights >= heights.max(axis=0) * (1.0 - TIE)
    # Between nodes the aggregate is convex: level if its middle is as high as its ends.
    top, level = np.split(greatest, [len(nodes)])
    widths = np.where(top[1:] & top[:-1] & level, np.diff(nodes, axis=0), 0.0)
    length = widths.sum(axis=0)
    is_point = length <= TIE * (aggregate.range[1] - aggregate.range[0])
    points = np.where(top, nodes, 0.0).sum(axis=0) / top.sum(axis=0)
    length[is_point] = 1.0
    return np.where(is_point, points, (widths * middles).sum(axis=0) / length)


DEFUZZIFY: dict[str, Callable[[Aggregate, Array], Array]] = {
    "centroid": centroid,
    "mean_of_maximum": mean_of_maximum,
    "height": height,
}
"""The methods by name."""
