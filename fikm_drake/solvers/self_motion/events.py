"""Where a joint reaches a limit, or turns back, between two points of a self-motion."""

from collections.abc import Callable

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.solvers.self_motion.curve import ROUNDING, CurvePoint, SelfMotionCurve

HALVINGS = 60
"""At most."""
ZERO = 1e-12
"""A root is found where the function, or the gap that holds it, is under this."""


def first_limit(
    curve: SelfMotionCurve, here: CurvePoint, there: CurvePoint, lower: Array, upper: Array
) -> tuple[CurvePoint, int, str] | None:
    """The first point after `here`, which is within the limits, where a joint is at a limit.

    A joint that leaves its limits and comes back before `there` is seen, if it turns once.

    Returns:
        The point, the joint (from 0) and `lower` or `upper`; None if no limit is passed.
    """
    there = _beyond_turning_point(curve, here, there, lower, upper) or there
    found = None
    while True:
        outside = np.flatnonzero((there.q < lower - ROUNDING) | (there.q > upper + ROUNDING))
        if not outside.size:
            return found
        crossings = []
        for joint in outside.tolist():
            side = "lower" if there.q[joint] < lower[joint] else "upper"
            limit = float((lower if side == "lower" else upper)[joint])
            point = _crossing(curve, here, there, joint, limit)
            crossings.append((float(here.tangent @ (point.q - here.q)), joint, side, point))
        _, joint, side, there = min(crossings, key=lambda crossing: crossing[0])
        found = (there, joint, side)
        # Another joint may have passed its limit before; each round leaves one joint fewer outside.
        lower, upper = lower.copy(), upper.copy()
        (lower if side == "lower" else upper)[joint] = -np.inf if side == "lower" else np.inf


def root_between(
    curve: SelfMotionCurve,
    here: CurvePoint,
    there: CurvePoint,
    function: Callable[[CurvePoint], float],
) -> CurvePoint:
    """The point where a function is zero, between two points where its signs differ."""
    low, high = 0.0, float(here.tangent @ (there.q - here.q))
    at_low, at_high = function(here), function(there)
    point, stayed = here, ""
    for _ in range(HALVINGS):
        # Regula falsi; an end that stays counts half as much each time (Illinois), so both close in.
        along = low + at_low / (at_low - at_high) * (high - low)
        point = _at(curve, here, there, along)
        value = function(point)
        if abs(value) < ZERO or high - low < ZERO:
            break
        if value * at_low > 0.0:
            at_high *= 0.5 if stayed == "high" else 1.0
            low, at_low, stayed = along, value, "high"
        else:
            at_low *= 0.5 if stayed == "low" else 1.0
            high, at_high, stayed = along, value, "low"
    return point


def turning_point(
    curve: SelfMotionCurve, here: CurvePoint, there: CurvePoint, joint: int
) -> CurvePoint:
    """The point where a joint turns back, between two points with opposite signs of its motion."""
    return root_between(curve, here, there, lambda point: float(point.tangent[joint]))


def _beyond_turning_point(
    curve: SelfMotionCurve, here: CurvePoint, there: CurvePoint, lower: Array, upper: Array
) -> CurvePoint | None:
    """A turning point of a joint between the two that lies outside its limits."""
    turned = here.tangent * there.tangent < 0.0
    chord = there.q - here.q
    excess = np.sqrt(chord @ chord) * np.minimum(np.abs(here.tangent), np.abs(there.tangent))
    near = (np.maximum(here.q, there.q) + excess > upper) & (here.tangent > 0.0)
    near |= (np.minimum(here.q, there.q) - excess < lower) & (here.tangent < 0.0)
    for joint in np.flatnonzero(turned & near).tolist():
        point = turning_point(curve, here, there, joint)
        if not lower[joint] - ROUNDING <= point.q[joint] <= upper[joint] + ROUNDING:
            return point
    return None


def _crossing(
    curve: SelfMotionCurve, here: CurvePoint, there: CurvePoint, joint: int, limit: float
) -> CurvePoint:
    """The point between the two where a joint, on either side of `limit`, is at it."""
    chord = there.q - here.q
    guess = here.q + chord * (limit - here.q[joint]) / chord[joint]
    point = curve.solve(guess, np.eye(chord.size)[joint], limit)
    if point is not None:
        along = float(here.tangent @ (point.q - here.q))
        off = point.q - guess
        if -ROUNDING <= along <= here.tangent @ chord + ROUNDING and off @ off <= chord @ chord:
            return point if point.tangent @ here.tangent > 0.0 else point.reversed()
    # The joint nearly turns back there: halve instead.
    low, high = 0.0, float(here.tangent @ chord)
    outward = float(np.sign(there.q[joint] - limit))
    point = here
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        point = _at(curve, here, there, middle)
        if outward * (point.q[joint] - limit) > 0.0:
            high = middle
        else:
            low = middle
    return _at(curve, here, there, low)


def _at(curve: SelfMotionCurve, here: CurvePoint, there: CurvePoint, along: float) -> CurvePoint:
    """The point between the two whose motion along the tangent of `here` is `along`."""
    tangent, chord = here.tangent, there.q - here.q
    guess = here.q + chord * (along / (tangent @ chord))
    return curve.solve(guess, tangent, float(tangent @ here.q) + along) or here
