"""All postures that reach a point, in closed form.

The postures for one point are curves: three joints, two equations. Where a limit cuts a curve, one of
the three relative angles is at its limit and the other two follow from a triangle, in two ways each.
A curve that no limit cuts passes θ_3 − θ_2 = 0. So 14 candidates, two for each of seven fixed angles,
decide exactly whether a point can be reached: it can if one of them is inside the limits.

A posture is described by b = θ_3 − θ_2 and by the side to which the elbow turns off the way to the
target, so a curve by one angle t: b = β sin t, the side is the sign of cos t. β is where both sides
meet, the arm stretched but for b, or the limit of b if that comes first.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.solvers.labvolt.geometry import Geometry
from fikm_drake.solvers.labvolt.two_links import EDGE, chord, two_links, wrap

Array = NDArray[np.float64]
SIDES = np.array([1.0, -1.0])[:, None]


def candidates(geometry: Geometry, target: Array) -> Array:
    """Postures with a relative angle at its limit, 12, or with θ_3 − θ_2 = 0, the last two.

    Args:
        geometry: of the arm.
        target: points in the arm's plane (2,N) [m].

    Returns:
        Relative angles (3,14,N) [rad], NaN where there is no such posture; limits are not looked at.
    """
    first, second, third = geometry.lengths
    q = np.empty((3, 14, target.shape[1]))
    for i, angle in enumerate((geometry.lower[0], geometry.upper[0])):
        rest = target - first * np.array([[np.cos(angle)], [np.sin(angle)]])
        direction, bend = two_links(second, third, rest[:, None], SIDES)
        q[:, 2 * i : 2 * i + 2] = np.broadcast_arrays(angle, direction - angle, bend)
    for i, angle in enumerate((geometry.lower[1], geometry.upper[1]), start=2):
        length, turn = chord(first, second, angle)
        direction, bend = two_links(length, third, target[:, None], SIDES)
        q[:, 2 * i : 2 * i + 2] = np.broadcast_arrays(direction - turn, angle, bend + turn - angle)
    for i, angle in enumerate((geometry.lower[2], geometry.upper[2], 0.0), start=4):
        q[:, 2 * i : 2 * i + 2] = _posture(geometry, target, angle, SIDES)
    return wrap(q)


def widest_arc(geometry: Geometry, target: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The middle of the widest stretch of postures inside the limits.

    Args:
        geometry: of the arm.
        target: points in the arm's plane (2,N) [m].

    Returns:
        Relative angles (3,N) [rad], NaN where the point cannot be reached; whether it can (N,).
    """
    ends = candidates(geometry, target)
    feasible = geometry.contains(ends, EDGE)
    widest_bend = _widest_bend(geometry, np.hypot(*target))
    t = np.where(feasible[:12], _curve_angle(geometry, ends[:, :12], widest_bend), np.inf)
    t.sort(axis=0)
    after = np.roll(t, -1, axis=0)
    last = np.maximum(np.isfinite(t).sum(axis=0) - 1, 0)
    lanes = np.arange(len(last))
    after[last, lanes] = t[0] + 2.0 * np.pi
    with np.errstate(invalid="ignore"):
        width, middle = after - t, 0.5 * (after + t)
        side = np.where(np.cos(middle) >= 0.0, 1.0, -1.0)
        q = wrap(_posture(geometry, target, widest_bend * np.sin(middle), side))
    width[~geometry.contains(q, EDGE)] = -1.0
    best = width.argmax(axis=0)
    posture = q[:, best, lanes]
    # A whole curve inside the limits, or one that touches them in a point.
    whole = width[best, lanes] <= 0.0
    posture[:, whole] = ends[:, feasible.argmax(axis=0), lanes][:, whole]
    reachable = feasible.any(axis=0)
    posture[:, ~reachable] = np.nan
    return geometry.clip(posture), reachable


def _posture(geometry: Geometry, target: Array, bend: ArrayLike, side: Array) -> Array:
    """Relative angles (3,K,N) for given θ_3 − θ_2 and sides of the elbow; not wrapped."""
    first, second, third = geometry.lengths
    length, turn = chord(second, third, bend)
    direction, elbow = two_links(first, length, target[:, None], side)
    return np.array(np.broadcast_arrays(direction, elbow - turn, bend))


def _widest_bend(geometry: Geometry, distance: Array) -> Array:
    """β: the largest |θ_3 − θ_2| (N,) [rad]."""
    first, second, third = geometry.lengths
    limit = max(abs(geometry.lower[2]), abs(geometry.upper[2]))
    joined = np.abs(distance - first)  # the two outer links have to span this
    cosine = (joined**2 - second**2 - third**2) / (2.0 * second * third)
    return np.minimum(np.arccos(np.clip(cosine, -1.0, 1.0)), limit)


def _curve_angle(geometry: Geometry, q: Array, widest_bend: Array) -> Array:
    """t of postures (3,K,N), in [−π/2, 3π/2]."""
    _, second, third = geometry.lengths
    _, direction = chord(second, third, q[2])
    with np.errstate(invalid="ignore", divide="ignore"):
        t = np.arcsin(np.clip(q[2] / widest_bend, -1.0, 1.0))
        return np.where(wrap(q[1] + direction) >= 0.0, t, np.pi - t)
