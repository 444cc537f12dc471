"""A target after a target: each solution starts from the last."""

from math import atan2, hypot, isfinite, pi

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts, default_starts
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.methods import program
from fikm_drake.solvers.labvolt.solution import LabVoltStatus
from fikm_drake.solvers.labvolt.solve import TOLERANCE, solve

AXIS = 1e-6
"""Nearer than this to the base's axis a target has no bearing [m]: the base stands still."""


def follow_target(
    target: Array,
    last: Array,
    *,
    warm: bool,
    tolerance: float = TOLERANCE,
    solver: str = "slsqp",
    fuzzy: FuzzyStarts | None = None,
    approach: float | None = None,
) -> tuple[Array, LabVoltStatus]:
    """Joint positions for a target, near those for the last one.

    The SQP starts from the last joint positions, at first from the fuzzy rules. Where that fails `solve`
    does it by its cascade, and takes the posture nearest to the last.

    Args:
        target: in the base frame (3,) [m].
        last: joint positions (4,), yaw and relative angles [rad].
        warm: whether `last` is the solution for a neighbouring target.
        tolerance: within this a target is reached [m].
        solver: of the SQP: `slsqp`, or `snopt`.
        fuzzy: the rules; None: ours.
        approach: angle of the hand from the horizontal [rad]: in closed form then, the nearest angle
            where it cannot be; None: any.

    Returns:
        Joint positions (4,) [rad]; `last` unless the target is reached. The status.
    """
    x, y, z = target.tolist()
    if not isfinite(x + y + z) or not isfinite(approach or 0.0):
        return last, LabVoltStatus.INVALID_INPUT
    geometry, radius = labvolt(), hypot(x, y)
    point = np.array([radius - geometry.offset, z - geometry.height])
    if hypot(*point.tolist()) > geometry.reach + tolerance:
        return last, LabVoltStatus.UNREACHABLE
    if approach is not None:
        near = np.cumsum(last[1:]) if warm else None
        solution = solve(point, tolerance=tolerance, posture=near, approach=approach)
        status = LabVoltStatus(int(solution.status[0]))
        return (
            _turned(last, target, solution.joints[0, 1:]) if solution.success[0] else last
        ), status
    starts = fuzzy or default_starts()
    start = last[1:] if warm else starts.posture(point[:, None])[:, 0]
    relative = program(solver).reach(point, start)
    status = LabVoltStatus.SOLVED
    if not geometry.error(relative, point) <= tolerance:
        solution = solve(
            point,
            method="cascade",
            tolerance=tolerance,
            solver=solver,
            posture=np.cumsum(last[1:]) if warm else None,
            fuzzy=starts,
        )
        if not solution.success[0]:
            return last, LabVoltStatus(int(solution.status[0]))
        relative, status = solution.joints[0, 1:], LabVoltStatus.FELL_BACK
    return _turned(last, target, relative), status


def _turned(last: Array, target: Array, relative: Array) -> Array:
    """Joint positions (4,): the base faces the target, by the nearest of the equal angles to the last."""
    x, y, _ = target.tolist()
    yaw = float(last[0])
    if hypot(x, y) > AXIS:  # the base has no limits
        yaw += (atan2(y, x) - yaw + pi) % (2.0 * pi) - pi
    return np.array([yaw, *relative])
