"""A walk along a curve of self-motion, in one direction until it ends."""

from dataclasses import dataclass, replace

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import wrap
from fikm_drake.solvers.self_motion.curve import FIRST_STEP, LEAST_STEP, CurvePoint, SelfMotionCurve
from fikm_drake.solvers.self_motion.events import first_limit

CLOSED = "closed"
"""End of a walk that came back to its start."""
SINGULAR = "singular"
"""End of a walk at a posture where the curve has no tangent."""
TOO_LONG = "too long"
"""End of a walk that was given up."""
SAME = 1e-6
"""Points of a curve nearer than this are the same [rad or m]."""
AT_LIMIT = 1e-12
"""A joint this near to a limit is at it [rad or m]."""
MOST_POINTS = 20_000
"""Most points of a walk."""


@dataclass(frozen=True)
class Walk:
    """Points of a curve from the start of a walk to its end."""

    q: Array
    """(K,k) positions of the moving joints [rad or m]."""
    tangents: Array
    """(K,k) directions of motion, of length 1."""
    end: str
    """`joint j lower`, `joint j upper` (its limit), or one of the above."""


@dataclass(frozen=True)
class Walls:
    """What a walk stays within."""

    lower: Array
    """(k,) [rad or m]."""
    upper: Array
    """(k,) [rad or m]."""
    periodic: Bools
    """(k,): joints for which a whole turn leads to the same posture."""


def walk(curve: SelfMotionCurve, start: CurvePoint, walls: Walls, max_step: float) -> Walk:
    """Walk from `start`, which is within the walls, along its tangent."""
    points = [start]
    end = _blocked(curve, start, walls)
    step = min(FIRST_STEP, max_step)
    while not end:
        before = None
        if len(points) > 1:
            step = _stride(curve, points, walls, max_step, step)
            before = points[-2]
        here = points[-1]
        there = curve.advance(here, before, step)
        if there is None:
            step *= 0.5
            end = SINGULAR if step < LEAST_STEP else ""
            continue
        closing = _closing(curve, start, here, there, walls.periodic) if before else None
        there = closing or there
        limit = first_limit(curve, here, there, walls.lower, walls.upper)
        if limit:
            there, joint, side = limit
            q = np.clip(there.q, walls.lower, walls.upper)
            q[joint] = (walls.lower if side == "lower" else walls.upper)[joint]  # to the last bit
            there = replace(there, q=q)
            end = limit_name(curve, joint, side)
        elif closing:
            end = CLOSED
        elif len(points) >= MOST_POINTS:
            end = TOO_LONG
        points.append(there)
        turn = there.tangent @ here.tangent
        step = min(max_step, 1.5 * step) if turn > 0.99 else step
    q, tangents = (np.array([getattr(p, name) for p in points]) for name in ("q", "tangent"))
    return Walk(q, tangents, end)


def _stride(
    curve: SelfMotionCurve, points: list[CurvePoint], walls: Walls, max_step: float, step: float
) -> float:
    """Let the native kernel walk on to the next event, where there is one; the next step."""
    if curve.native is None:
        return step
    before, here = ((point.q, point.tangent) for point in points[-2:])
    bounds = np.array([walls.lower, walls.upper, walls.periodic], dtype=float)
    q, tangents, step = curve.native.stride(
        before, here, int(points[-1].orientation), bounds, points[0].q, max_step, step
    )
    points += [CurvePoint(*row, points[-1].orientation) for row in zip(q, tangents)]
    return step


def limit_name(curve: SelfMotionCurve, joint: int, side: str) -> str:
    """Name of a limit of a moving joint (from 0), by its number in the plant (from 1)."""
    return f"joint {curve.task.moving[joint] + 1} {side}"


def _blocked(curve: SelfMotionCurve, start: CurvePoint, walls: Walls) -> str:
    """The limit that the start is at and the walk would pass; empty if there is none."""
    for side, out in (
        ("lower", (start.q <= walls.lower + AT_LIMIT) & (start.tangent < 0.0)),
        ("upper", (start.q >= walls.upper - AT_LIMIT) & (start.tangent > 0.0)),
    ):
        if out.any():
            return limit_name(curve, int(np.argmax(out)), side)
    return ""


def _closing(
    curve: SelfMotionCurve,
    start: CurvePoint,
    here: CurvePoint,
    there: CurvePoint,
    periodic: Bools,
) -> CurvePoint | None:
    """The start, whole turns on, if the curve passes it between the two points."""
    offset = start.q - here.q
    offset = np.where(periodic, wrap(offset), offset)
    chord = there.q - here.q
    along = float(here.tangent @ offset)
    if not (0.0 < along <= here.tangent @ chord and offset @ offset <= 2.0 * (chord @ chord)):
        return None
    point = curve.solve(here.q + offset, here.tangent, float(here.tangent @ here.q) + along)
    if point is None or point.tangent @ start.tangent < 0.5:
        return None
    same = np.abs(point.q - here.q - offset).max() < SAME
    return replace(start, q=here.q + offset) if same else None
