"""The border of what three links in a plane reach, and the point of it nearest to one beyond, in closed form.

On the border the joints that are free cannot move the tool in two directions. So no joint is free but
one, or two are and the arm is straight or folded from both of them to the tool, or all three are and
all of it is. In each case the border is an arc of a circle, which one joint draws while the others stand
still. There are about forty such arcs; all of each is reachable, so the nearest of them is exact.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product
from math import atan2, cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.angles import nearest_turn
from fikm_drake.kinematics.planar_links import EDGE, PlanarLinks, chord

FOLDS = (0.0, pi)
"""Straight on, and back [rad]."""


@dataclass(frozen=True)
class BorderArcs:
    """Circular arcs, each drawn by one joint, columns (K,1)."""

    joint: NDArray[np.intp]
    """(K,): the joint that moves."""
    posture: Array
    """(3,K): relative angles at its start [rad]."""
    centre: Array
    """(2,K,1) [m]."""
    radius: Array
    """(K,1) [m]."""
    start: Array
    """(K,1): direction of the tool from the centre at the start [rad]."""
    span: Array
    """(K,1): how far the joint turns, a whole turn at most [rad]."""


def nearest_on_border(links: PlanarLinks, target: Array) -> tuple[Array, Array]:
    """The reachable point nearest to each of N points that are out of reach.

    Args:
        links: the arm, without an infinite limit.
        target: points from its first joint (2,N) [m], none of them reachable.

    Returns:
        Relative angles (3,N) [rad] that put the tool there, distances (N,) [m].
    """
    arcs = border_arcs(links)
    x, y = target[0] - arcs.centre[0], target[1] - arcs.centre[1]
    turn = np.mod(np.arctan2(y, x) - arcs.start, 2.0 * pi)
    beyond = np.where(turn - arcs.span < 2.0 * pi - turn, arcs.span, 0.0)
    turn = np.where(turn <= arcs.span, turn, beyond)
    angle = arcs.start + turn
    distance = np.hypot(x - arcs.radius * np.cos(angle), y - arcs.radius * np.sin(angle))
    best = distance.argmin(axis=0)
    lanes = np.arange(target.shape[1])
    q = arcs.posture[:, best]
    q[arcs.joint[best], lanes] += turn[best, lanes]
    return links.clip(q), distance[best, lanes]


@cache
def border_arcs(links: PlanarLinks) -> BorderArcs:
    """Every arc that can be a part of the border; each lies inside what is reachable."""
    first, second, third = links.lengths
    ends = list(zip(links.lower, links.upper))
    # The first joint moves: all straight or folded, or one joint at a limit, or two.
    pairs = [*product(FOLDS, FOLDS), *product(ends[1], ends[2])]
    for elbow in ends[1]:
        direction = float(chord(first, second, elbow)[1])
        pairs += [(elbow, direction - elbow + fold) for fold in FOLDS]
    for wrist in ends[2]:
        direction = float(chord(second, third, wrist)[1])
        pairs += [(fold - direction, wrist) for fold in FOLDS]
    postures = [(0, (links.lower[0], elbow, wrist)) for elbow, wrist in pairs]
    # The second moves, the third straight, folded or at a limit; then the third.
    postures += [
        (1, (shoulder, links.lower[1], wrist))
        for shoulder, wrist in product(ends[0], (*FOLDS, *ends[2]))
    ]
    postures += [(2, (*pair, links.lower[2])) for pair in product(ends[0], ends[1])]
    turned = [(joint, _near_middle(links, posture)) for joint, posture in postures]
    arcs = [arc for arc in turned if links.contains(np.array(arc[1])[:, None], EDGE)[0]]
    joint, posture = np.array([arc[0] for arc in arcs]), np.array([arc[1] for arc in arcs]).T
    circles = np.array([_circle(links, j, q) for j, q in arcs])
    span = np.array([min(links.upper[j] - links.lower[j], 2.0 * pi) for j in joint])
    return BorderArcs(
        joint,
        posture,
        circles[:, :2].T[:, :, None],
        circles[:, 2, None],
        circles[:, 3, None],
        span[:, None],
    )


def _near_middle(links: PlanarLinks, posture: tuple[float, ...]) -> tuple[float, ...]:
    """The same posture, angles that are no limits turned to lie inside the limits if they can."""
    turned = []
    for q, low, high, middle in zip(posture, links.lower, links.upper, links.middle.tolist()):
        turned.append(q if q in (low, high) else q + float(nearest_turn(q, middle)))
    return tuple(turned)


def _circle(
    links: PlanarLinks, joint: int, posture: tuple[float, ...]
) -> tuple[float, float, float, float]:
    """Centre x, y and radius [m], direction of the tool from it [rad]."""
    points = [(0.0, 0.0)]
    angle = 0.0
    for length, turn in zip(links.lengths, posture):
        angle += turn
        x, y = points[-1]
        points.append((x + length * cos(angle), y + length * sin(angle)))
    (x, y), (tool_x, tool_y) = points[joint], points[-1]
    return x, y, hypot(tool_x - x, tool_y - y), atan2(tool_y - y, tool_x - x)
