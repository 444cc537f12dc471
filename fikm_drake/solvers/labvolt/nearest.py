"""The reachable point nearest to one that is out of reach, in closed form.

On the border of what the arm reaches the joints that are free cannot move the tool in two directions.
So no joint is free but one, or two are and the arm is straight from both of them to the tool, or all
three are and the arm is stretched. In each case the border is an arc of a circle, which one joint
draws while the others stand still. There are a score of such arcs; all of each is reachable, so the
nearest of them is exact.
"""

from dataclasses import dataclass
from functools import cache
from math import atan2, cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.solvers.labvolt.geometry import Geometry
from fikm_drake.solvers.labvolt.two_links import chord


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
    """(K,1): how far the joint turns [rad]."""


def nearest(geometry: Geometry, target: Array) -> tuple[Array, Array]:
    """The reachable point nearest to each of N points that are out of reach.

    Args:
        geometry: of the arm.
        target: points in the arm's plane (2,N) [m], none of them reachable.

    Returns:
        Relative angles (3,N) [rad] that put the tool there, distances (N,) [m].
    """
    arcs = border_arcs(geometry)
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
    return geometry.clip(q), distance[best, lanes]


@cache
def border_arcs(geometry: Geometry) -> BorderArcs:
    """Every arc that can be a part of the border; each lies inside what is reachable."""
    first, second, third = geometry.lengths
    bends = [(geometry.lower[i], geometry.upper[i]) for i in range(3)]
    # The shoulder moves: the arm stretched, straight but for one limit, or at two limits.
    pairs = [(0.0, 0.0), *((elbow, wrist) for elbow in bends[1] for wrist in bends[2])]
    for elbow in bends[1]:
        direction = float(chord(first, second, elbow)[1])
        pairs += [(elbow, _turned(direction - elbow + fold)) for fold in (0.0, pi)]
    for wrist in bends[2]:
        direction = float(chord(second, third, wrist)[1])
        pairs += [(_turned(fold - direction), wrist) for fold in (0.0, pi)]
    arcs = [(0, (geometry.lower[0], elbow, wrist)) for elbow, wrist in pairs]
    # The elbow moves, the forearm and hand straight or at a limit; then the wrist.
    arcs += [
        (1, (shoulder, geometry.lower[1], wrist))
        for shoulder in bends[0]
        for wrist in (0.0, *bends[2])
    ]
    arcs += [
        (2, (shoulder, elbow, geometry.lower[2])) for shoulder in bends[0] for elbow in bends[1]
    ]
    arcs = [arc for arc in arcs if geometry.contains(np.array(arc[1])[:, None], 0.0)[0]]
    joint, posture = np.array([arc[0] for arc in arcs]), np.array([arc[1] for arc in arcs]).T
    circles = np.array([_circle(geometry, j, q) for j, q in arcs])
    span = np.array([geometry.upper[j] - geometry.lower[j] for j in joint])
    return BorderArcs(
        joint,
        posture,
        circles[:, :2].T[:, :, None],
        circles[:, 2, None],
        circles[:, 3, None],
        span[:, None],
    )


def _circle(
    geometry: Geometry, joint: int, posture: tuple[float, float, float]
) -> tuple[float, float, float, float]:
    """Centre x, y and radius [m], direction of the tool from it [rad]."""
    points = [(0.0, 0.0)]
    angle = 0.0
    for length, turn in zip(geometry.lengths, posture):
        angle += turn
        x, y = points[-1]
        points.append((x + length * cos(angle), y + length * sin(angle)))
    (x, y), (tool_x, tool_y) = points[joint], points[-1]
    return x, y, hypot(tool_x - x, tool_y - y), atan2(tool_y - y, tool_x - x)


def _turned(angle: float) -> float:
    """The angle in (−π, π]."""
    return pi - (pi - angle) % (2.0 * pi)
