"""Three links in a plane: lengths, limits, and the triangle that every closed form of them is made of.

    x = a_1 cos θ_1 + a_2 cos θ_2 + a_3 cos θ_3,   y = a_1 sin θ_1 + a_2 sin θ_2 + a_3 sin θ_3

with θ from the x axis. Limits are of the relative angles θ_1, θ_2 − θ_1, θ_3 − θ_2, which turn each
link against the one before it; here angles are relative, one column a posture. The LabVolt 5250 behind
its turning base is such an arm, and so is a `Planar3R`, its bent angles taken for the relative ones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array

Number = float | Array
EDGE = 1e-12
"""A cosine this far beyond 1 [-], or an angle this far beyond a limit [rad], counts as at it."""


@dataclass(frozen=True)
class PlanarLinks:
    """Lengths and limits of three links in a plane, from the first joint, which is the origin."""

    lengths: tuple[float, float, float]
    """Lengths of the links a_1, a_2, a_3 [m]."""
    lower: tuple[float, float, float]
    """Lower limits of the relative angles θ_1, θ_2 − θ_1, θ_3 − θ_2 [rad]."""
    upper: tuple[float, float, float]
    """Upper limits [rad]."""

    @cached_property
    def reach(self) -> float:
        """Reach of the stretched arm from its first joint [m]."""
        return sum(self.lengths)

    @cached_property
    def middle(self) -> Array:
        """The middle of the limits (3,), relative angles [rad]."""
        return 0.5 * (np.array(self.lower) + np.array(self.upper))

    def tool(self, relative: Array) -> Array:
        """Tool points (2,N) [m] of relative angles (3,N) [rad], equations 1 and 2 of paper 4."""
        angles, lengths = np.cumsum(relative, axis=0), np.array(self.lengths)
        return np.array([lengths @ np.cos(angles), lengths @ np.sin(angles)])

    def error(self, relative: Array, target: Array) -> Array:
        """Distances (N,) [m] of the tool from targets (2,N) [m] at relative angles (3,N) [rad]."""
        return np.hypot(*(self.tool(relative) - target))

    def contains(self, relative: Array, tolerance: float) -> NDArray[np.bool_]:
        """Whether relative angles (3,…) [rad] are inside the limits; NaN is not."""
        inside = np.ones(relative.shape[1:], dtype=bool)
        for q, low, high in zip(relative, self.lower, self.upper):
            inside &= (q >= low - tolerance) & (q <= high + tolerance)
        return inside

    def clip(self, relative: Array) -> Array:
        """Relative angles (3,N) [rad], those beyond a limit moved to it."""
        lower, upper = (np.array(limit)[:, None] for limit in (self.lower, self.upper))
        return np.clip(relative, lower, upper)


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
