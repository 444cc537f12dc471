"""Two links in a plane: the triangle that every closed form here is made of."""

import numpy as np

from fikm_drake.arrays import Array

Number = float | Array
EDGE = 1e-12
"""A cosine this far beyond 1 [-], or an angle this far beyond a limit [rad], counts as at it."""


def two_links(inner: Number, outer: Number, point: Array, side: Number) -> tuple[Array, Array]:
    """Angles that put the end of two links on a point.

    Args:
        inner: length of the link at the origin [m].
        outer: length of the other [m].
        point: (2,…) [m].
        side: 1 to bend to the left, counter-clockwise, −1 to the right.

    Returns:
        Direction of the inner link, angle of the outer one from it [rad]; NaN where the links are too
        short or too unequal. The point is met to rounding, also where the links are nearly straight.
    """
    x, y = point
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = (x * x + y * y - (inner * inner + outer * outer)) / (2.0 * inner * outer)
        cosine[np.abs(cosine) > 1.0 + EDGE] = np.nan
        cosine = np.minimum(np.maximum(cosine, -1.0), 1.0)
        sine = np.sqrt(1.0 - cosine * cosine)
    turn = np.arctan2(outer * sine, inner + outer * cosine)
    return np.arctan2(y, x) - side * turn, side * np.arccos(cosine)


def chord(inner: Number, outer: Number, bend: Number) -> tuple[Array, Array]:
    """Two links with a fixed angle between them, seen as one.

    Args:
        inner: length of the first link [m].
        outer: length of the second [m].
        bend: angle of the second from the first [rad].

    Returns:
        Its length [m] and its direction from the first link [rad].
    """
    x, y = inner + outer * np.cos(bend), outer * np.sin(bend)
    return np.hypot(x, y), np.arctan2(y, x)


def wrap(angle: Array) -> Array:
    """The angle in [−π, π] [rad]."""
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
