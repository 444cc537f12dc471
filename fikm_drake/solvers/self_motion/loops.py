"""The whole curve of a self-motion, without limits, and a posture in each piece within the limits."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.angles import nearest_turn, wrap
from fikm_drake.solvers.self_motion.curve import CurvePoint, SelfMotionCurve
from fikm_drake.solvers.self_motion.polyline import FINE, arc_lengths, interpolate
from fikm_drake.solvers.self_motion.spare_task import SpareTask
from fikm_drake.solvers.self_motion.walk import CLOSED, Walls, walk

NEAR = 1e-3
"""How far outside the limits a point of a dense polyline may be within them [rad or m]."""


def free_line(curve: SelfMotionCurve, start: CurvePoint, max_step: float) -> tuple[Array, bool]:
    """The curve through a point as a dense polyline (D,k), limits ignored, and whether it closes."""
    endless = np.full(start.q.size, np.inf)
    walls = Walls(-endless, endless, curve.task.revolute)
    piece = both_ways(curve, start, walls, max_step)
    return dense(piece), piece.ends[0] == CLOSED


@dataclass(frozen=True)
class Piece:
    """A piece of a curve between two ends."""

    q: Array
    """(K,k) positions of the moving joints [rad or m]."""
    tangents: Array
    """(K,k) directions of motion, of length 1."""
    ends: tuple[str, str]
    """What ends it at the first and at the last point, as in `Walk.end`."""

    @cached_property
    def lengths(self) -> Array:
        """(K,) arc lengths from the first point."""
        return arc_lengths(self.q, self.tangents)


def both_ways(curve: SelfMotionCurve, start: CurvePoint, walls: Walls, max_step: float) -> Piece:
    """The piece of the curve through a point; closed, it starts and ends there."""
    ahead = walk(curve, start, walls, max_step)
    if ahead.end == CLOSED:
        return Piece(ahead.q, ahead.tangents, (CLOSED, CLOSED))
    back = walk(curve, start.reversed(), walls, max_step)
    q = np.concatenate([back.q[:0:-1], ahead.q])
    tangents = np.concatenate([-back.tangents[:0:-1], ahead.tangents])
    return Piece(q, tangents, (back.end, ahead.end))


def dense(line: Piece) -> Array:
    """Points (D,k) along a piece, close to each other."""
    lengths = line.lengths
    at = np.interp(np.arange(FINE * (len(line.q) - 1) + 1) / FINE, np.arange(len(line.q)), lengths)
    return interpolate(line.q, line.tangents, lengths, at)


def seeds(curve: SelfMotionCurve, line: Array, closed: bool) -> list[CurvePoint]:
    """A point of the curve within the limits for each piece of a dense polyline that is.

    Pieces begin and end where a joint crosses a limit, so the middle between two crossings that
    follow each other decides. A joint whose range is a whole turn or more does not end a piece; it
    is brought to the middle of its range by whole turns.
    """
    task = curve.task
    past = _past_limits(task, line)
    last = len(line) - 1
    if last == 0:  # a singular posture, from which no step could be made
        return []
    cuts = _crossings(past)
    if not closed:
        cuts = np.concatenate([[0.0], cuts, [last]])
    elif cuts.size:
        cuts = np.append(cuts, cuts[0] + last)
    else:
        cuts = np.array([0.0, last])
    found = []
    for place in np.mod(0.5 * (cuts[1:] + cuts[:-1]), last):
        i, share = int(place), place % 1.0
        if ((1.0 - share) * past[i] + share * past[i + 1] > NEAR).any():
            continue
        chord = line[i + 1] - line[i]
        row = chord / np.linalg.norm(chord)
        guess = line[i] + share * chord
        point = curve.solve(guess, row, float(row @ guess))
        if point is None:
            continue
        q = point.q + np.where(task.revolute, nearest_turn(point.q, task.middle), 0.0)
        if (q >= task.lower).all() and (q <= task.upper).all():
            found.append(replace(point, q=q))
    return found


def _past_limits(task: SpareTask, line: Array) -> Array:
    """How far the points (D,k) of a polyline are past each limit that can end a piece (D,L).

    A joint half a turn from the middle of its range jumps from past its upper to past its lower
    limit: places that are seen there are outside, and do no harm.
    """
    half = 0.5 * (task.upper - task.lower)
    narrow = task.revolute & (half < np.pi)
    away = wrap(line - task.middle)
    above = np.where(narrow, away - half, line - task.upper)
    below = np.where(narrow, -away - half, task.lower - line)
    ends = narrow | ~task.revolute
    return np.concatenate(
        [above[:, ends & np.isfinite(task.upper)], below[:, ends & np.isfinite(task.lower)]], axis=1
    )


def _crossings(past: Array) -> Array:
    """Places along a polyline, in ascending order, where a joint crosses a limit."""
    where, joint = np.nonzero((past[:-1] > 0.0) != (past[1:] > 0.0))
    low, high = past[where, joint], past[where + 1, joint]
    return np.sort(where + low / (low - high))
