"""Where joint 1 of a planar 3R arm may be while the tool is at a point, in closed form."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.angles import TURN, wrap
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R, triangle_angle
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.solvers.self_motion.interval_table import (
    END_NAMES,
    FULL_TURN,
    TURNING_POINT,
    FeasibleInterval,
    IntervalTable,
)

Codes = NDArray[np.int_]
CHUNK = 4096
"""Points side by side: their arrays stay in the processor's cache."""
SLIVER = 1e-13
"""Gaps between candidates under this are rounding [rad]."""
EDGE = 1e-7
"""A posture this near to the limits [rad] counts where a point has no other: on the region's edge."""


def feasible_intervals(arm: DhArm | SerialChain, point: ArrayLike) -> list[FeasibleInterval]:
    """Intervals of θ1 of a planar 3R arm for which some posture reaches a point within all limits.

    The bounds are exact: each is a limit of joint 1, or a posture where joint 2 or 3 is at a limit,
    or where links 2 and 3 are in line and joint 1 turns back. Between two such positions nothing
    changes, so one posture in the middle decides.

        for interval in fd.feasible_intervals(fd.load_arm("hassantabar3r"), [1.0, 2.0]):
            print(interval.lower, interval.upper, interval.upper_end)

    Args:
        arm: a planar arm with three revolute joints about z, of any lengths and limits.
        point: (2,) position of the tool in the base frame [m].

    Returns:
        The intervals [rad] in ascending order: none where the point is infeasible, one of no width
        on the edge of the region. Without limits of joint 1 an interval starts in [−π, π].

    Raises:
        ValueError: the arm is of another kind, or the point is not two finite numbers.
    """
    array = np.asarray(point, dtype=float)
    if array.shape != (2,) or not np.isfinite(array).all():
        raise ValueError(f"point must be two finite numbers x, y [m], got {point!r}")
    return feasible_interval_table(arm, array[None])[0]


def feasible_interval_table(arm: DhArm | SerialChain, points: ArrayLike) -> IntervalTable:
    """As `feasible_intervals`, for many points at once.

    Args:
        arm: a planar arm with three revolute joints about z.
        points: (N,2) [m]; a point that is not finite is infeasible.

    Raises:
        ValueError: the arm is of another kind, or `points` has another shape.
    """
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {array.shape}")
    geometry = Planar3R(arm)
    chunks = [array[start : start + CHUNK] for start in range(0, len(array), CHUNK)] or [array]
    tables = [_table(len(chunk), *interval_columns(geometry, chunk)) for chunk in chunks]
    return IntervalTable.concatenated(tables)


Columns = tuple[Codes, Array, Array, Codes, Codes]
"""Row, bounds and ends of intervals, one after the other, rows ascending."""


def interval_columns(
    geometry: Planar3R, points: Array, elbows: tuple[int, ...] = (0, 1)
) -> Columns:
    """The intervals of points (N,2), one after the other.

    Args:
        geometry: the arm.
        points: (N,2) [m].
        elbows: which of `Planar3R.postures` may be taken.

    Returns:
        Row, lower and upper bound [rad], code of the lower and of the upper end, (K,) each; rows
        ascend, and the intervals of a row.
    """
    theta, code = _candidates(geometry, points)
    between = 0.5 * (theta[:, 1:] + theta[:, :-1])
    postures = geometry.postures(points[:, None], between)[..., elbows, :]
    inside = np.any(geometry.is_inside(postures), axis=-1)
    sliver = np.diff(theta, axis=1) <= SLIVER
    inside[:, 1:-1] |= sliver[:, 1:-1] & inside[:, :-2] & inside[:, 2:]
    closed = np.pad(inside, ((0, 0), (1, 1)))
    # nonzero goes row by row, so the k-th start belongs to the k-th end.
    rows, starts = np.nonzero(closed[:, 1:] & ~closed[:, :-1])
    _, ends = np.nonzero(closed[:, :-1] & ~closed[:, 1:])
    found = (rows, theta[rows, starts], theta[rows, ends], code[rows, starts], code[rows, ends])
    if not np.isfinite([geometry.lower[0], geometry.upper[0]]).any():
        found = _joined_over_the_turn(found)
    return _with_edges(geometry, points, theta, code, found, elbows)


def _candidates(geometry: Planar3R, points: Array) -> tuple[Array, Codes]:
    """All θ1 (N,C) at which an interval may end, ascending, NaN last, and their codes."""
    offset = points - geometry.base
    r, phi = np.hypot(offset[:, 0], offset[:, 1]), np.arctan2(offset[:, 1], offset[:, 0])
    angles, codes = [], []
    for bent, code in _elbow_angles(geometry):
        _, second, third = geometry.lengths
        reach = abs(second + third * np.exp(1j * bent))
        turn = triangle_angle(geometry.lengths[0], r, reach)
        angles += [phi - turn, phi + turn]
        codes += [code, code]
    for limit, code in _limits(geometry, 1):
        first, second, third = geometry.lengths
        arm = first + second * np.exp(1j * (limit + geometry.offsets[1]))
        turn = triangle_angle(abs(arm), r, third)
        angles += [phi - np.angle(arm) - turn, phi - np.angle(arm) + turn]
        codes += [code, code]
    theta = wrap(np.stack(angles, axis=1) - geometry.offsets[0])
    lower, upper = geometry.lower[0], geometry.upper[0]
    window = [
        lower if np.isfinite(lower) else upper - TURN if np.isfinite(upper) else -np.pi,
        upper if np.isfinite(upper) else lower + TURN if np.isfinite(lower) else np.pi,
    ]
    turns = np.arange(np.ceil((window[0] - np.pi) / TURN), np.floor((window[1] + np.pi) / TURN) + 1)
    theta = np.concatenate([theta + TURN * k for k in turns], axis=1)
    with np.errstate(invalid="ignore"):
        theta[(theta < window[0]) | (theta > window[1])] = np.nan
    ends = [
        _code(1, "lower") if np.isfinite(lower) else END_NAMES.index(FULL_TURN),
        _code(1, "upper") if np.isfinite(upper) else END_NAMES.index(FULL_TURN),
    ]
    theta = np.concatenate([np.broadcast_to(window, (len(points), 2)), theta], axis=1)
    order = np.argsort(theta, axis=1, kind="stable")
    return np.take_along_axis(theta, order, axis=1), np.array(ends + codes * len(turns))[order]


def _elbow_angles(geometry: Planar3R) -> list[tuple[float, int]]:
    """Bent angles of joint 3 that may end an interval: its limits, links 2 and 3 in line."""
    limits = [(limit + geometry.offsets[2], code) for limit, code in _limits(geometry, 2)]
    in_line = [
        (angle, END_NAMES.index(TURNING_POINT))
        for angle in (0.0, np.pi)
        if all(abs(wrap(angle - limit)) > 1e-12 for limit, _ in limits)
    ]
    return limits + in_line


def _limits(geometry: Planar3R, joint: int) -> list[tuple[float, int]]:
    """The limits of a joint (from 0) that are finite, and their codes."""
    both = [(geometry.lower[joint], "lower"), (geometry.upper[joint], "upper")]
    return [(float(limit), _code(joint + 1, side)) for limit, side in both if np.isfinite(limit)]


def _code(joint: int, side: str) -> int:
    return END_NAMES.index(f"joint {joint} {side}")


def _joined_over_the_turn(found: Columns) -> Columns:
    """Intervals cut at ±π made whole, for a joint 1 that turns freely."""
    rows, lower, upper, lower_end, upper_end = found
    first = np.flatnonzero(np.diff(rows, prepend=-1))
    last = np.flatnonzero(np.diff(rows, append=-1))
    cut = END_NAMES.index(FULL_TURN)
    joined = (last > first) & (lower_end[first] == cut) & (upper_end[last] == cut)
    upper[last[joined]] = upper[first[joined]] + TURN
    upper_end[last[joined]] = upper_end[first[joined]]
    keep = np.ones(rows.size, dtype=bool)
    keep[first[joined]] = False
    return rows[keep], lower[keep], upper[keep], lower_end[keep], upper_end[keep]


def _with_edges(
    geometry: Planar3R,
    points: Array,
    theta: Array,
    code: Codes,
    found: Columns,
    elbows: tuple[int, ...],
) -> Columns:
    """The intervals and, for points on the edge of the region, one of no width."""
    without = np.setdiff1d(np.arange(len(points)), found[0])
    postures = geometry.postures(points[without, None], theta[without])[..., elbows, :]
    near = np.any(geometry.is_inside(postures, EDGE), axis=-1)
    some = np.any(near, axis=1)
    rows, best = without[some], np.argmax(near, axis=1)[some]
    edge = (rows, theta[rows, best], theta[rows, best], code[rows, best], code[rows, best])
    merged = [np.concatenate(pair) for pair in zip(found, edge)]
    order = np.argsort(merged[0], kind="stable")
    row, lower, upper, lower_end, upper_end = (column[order] for column in merged)
    return row, lower, upper, lower_end, upper_end


def _table(
    count: int, rows: Codes, lower: Array, upper: Array, lower_end: Codes, upper_end: Codes
) -> IntervalTable:
    counts = np.bincount(rows, minlength=count)
    place = np.arange(rows.size) - np.repeat(np.cumsum(counts) - counts, counts)
    shape = (count, int(counts.max(initial=0)))
    table = IntervalTable(
        counts,
        np.full(shape, np.nan),
        np.full(shape, np.nan),
        np.full(shape, -1),
        np.full(shape, -1),
    )
    for column, values in zip(
        (table.lower, table.upper, table.lower_end, table.upper_end),
        (lower, upper, lower_end, upper_end),
    ):
        column[rows, place] = values
    return table
