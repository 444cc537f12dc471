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

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import wrap
from fikm_drake.kinematics.planar_links import EDGE, PlanarLinks, chord, two_links

SIDES = np.array([1.0, -1.0])[:, None]


def candidates(geometry: PlanarLinks, target: Array) -> Array:
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
        direction, bend = two_links(second, third, rest, SIDES)
        q[0, 2 * i : 2 * i + 2], q[2, 2 * i : 2 * i + 2] = angle, bend
        q[1, 2 * i : 2 * i + 2] = wrap(direction - angle)
    for i, angle in enumerate((geometry.lower[1], geometry.upper[1]), start=2):
        length, turn = chord(first, second, angle)
        direction, bend = two_links(length, third, target[:, None], SIDES)
        q[:, 2 * i : 2 * i + 2] = np.broadcast_arrays(direction - turn, angle, bend + turn - angle)
    for i, angle in enumerate((geometry.lower[2], geometry.upper[2], 0.0), start=4):
        q[:, 2 * i : 2 * i + 2] = _posture(geometry, target[:, None], angle, SIDES)
    return wrap(q)


def widest_arc(geometry: PlanarLinks, target: Array) -> Array:
    """The middle of the widest stretch of postures inside the limits.

    Args:
        geometry: of the arm.
        target: points in the arm's plane (2,N) [m].

    Returns:
        Relative angles (3,N) [rad], NaN where the point cannot be reached.
    """
    ends = candidates(geometry, target)
    feasible = geometry.contains(ends, EDGE)
    lanes = np.arange(target.shape[1])
    # A whole curve inside the limits, or one that touches them in a point: any candidate will do.
    posture = ends[:, feasible.argmax(axis=0), lanes]
    posture[:, ~feasible.any(axis=0)] = np.nan
    cut = np.flatnonzero(feasible[:12].any(axis=0))
    if cut.size:
        q, width = _widest_middle(geometry, target[:, cut], ends[:, :12, cut], feasible[:12, cut])
        posture[:, cut[width > 0.0]] = q[:, width > 0.0]
    return geometry.clip(posture)


def _widest_middle(
    geometry: PlanarLinks, target: Array, ends: Array, feasible: Bools
) -> tuple[Array, Array]:
    """Middles of the widest arcs (3,N), and their widths in t (N,); a width below 0: there is none."""
    widest_bend = _widest_bend(geometry, np.hypot(*target))
    rows, lanes = np.nonzero(feasible)
    most = int(feasible.sum(axis=0).max())
    t = np.full((most + 1, target.shape[1]), np.inf)
    t[feasible.cumsum(axis=0)[rows, lanes] - 1, lanes] = _curve_angle(
        geometry, ends[:, rows, lanes], widest_bend[lanes]
    )
    t.sort(axis=0)
    # After the last end comes the first again, a turn on.
    t[feasible.sum(axis=0), np.arange(t.shape[1])] = t[0] + 2.0 * np.pi
    middle = 0.5 * (t[1:] + t[:-1])
    gaps, lanes = np.nonzero(np.isfinite(middle))
    middle = middle[gaps, lanes]
    side = np.where(np.cos(middle) >= 0.0, 1.0, -1.0)
    q = np.full((3, most, t.shape[1]), np.nan)
    bend = widest_bend[lanes] * np.sin(middle)
    q[:, gaps, lanes] = wrap(_posture(geometry, target[:, lanes], bend, side))
    with np.errstate(invalid="ignore"):
        width = np.where(geometry.contains(q, EDGE), t[1:] - t[:-1], -1.0)
    best, lanes = width.argmax(axis=0), np.arange(t.shape[1])
    return q[:, best, lanes], width[best, lanes]


def _posture(geometry: PlanarLinks, target: Array, bend: float | Array, side: Array) -> Array:
    """Relative angles (3,…) for given θ_3 − θ_2 and sides of the elbow; not wrapped."""
    first, second, third = geometry.lengths
    length, turn = chord(second, third, bend)
    direction, elbow = two_links(first, length, target, side)
    return np.array(np.broadcast_arrays(direction, elbow - turn, bend))


def _widest_bend(geometry: PlanarLinks, distance: Array) -> Array:
    """β: the largest |θ_3 − θ_2| (N,) [rad]."""
    first, second, third = geometry.lengths
    limit = max(abs(geometry.lower[2]), abs(geometry.upper[2]))
    joined = np.abs(distance - first)  # the two outer links have to span this
    cosine = (joined**2 - second**2 - third**2) / (2.0 * second * third)
    return np.minimum(np.arccos(np.clip(cosine, -1.0, 1.0)), limit)


def _curve_angle(geometry: PlanarLinks, q: Array, widest_bend: Array) -> Array:
    """The t of postures (3,N), in [−π/2, 3π/2]."""
    _, second, third = geometry.lengths
    _, direction = chord(second, third, q[2])
    with np.errstate(invalid="ignore", divide="ignore"):
        t = np.arcsin(np.clip(q[2] / widest_bend, -1.0, 1.0))
        return np.where(wrap(q[1] + direction) >= 0.0, t, np.pi - t)
