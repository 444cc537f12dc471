"""Inverse kinematics of the LabVolt 5250: the paper's methods and ours."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array
from fikm_drake.checks import check_positive_finite
from fikm_drake.kinematics.angles import wrap
from fikm_drake.kinematics.planar_border import nearest_on_border
from fikm_drake.solvers.labvolt.approach import at_approach
from fikm_drake.solvers.labvolt.feasible_postures import widest_arc
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts, default_starts
from fikm_drake.solvers.labvolt.geometry import Geometry, labvolt, to_absolute, to_relative
from fikm_drake.solvers.labvolt.methods import METHODS, Goals, Ways, program
from fikm_drake.solvers.labvolt.plane_targets import plane_targets
from fikm_drake.solvers.labvolt.solution import LabVoltSolution, LabVoltStatus

TOLERANCE = 1e-9
"""Within this a target is reached [m]."""
CHUNK = 4096
"""Targets whose closed form is computed together."""
MIDDLE = "middle"
REACHED = (LabVoltStatus.SOLVED, LabVoltStatus.FELL_BACK, LabVoltStatus.TURNED)
"""Statuses of success."""


def solve(
    targets: ArrayLike,
    *,
    method: str = "exact",
    tolerance: float = TOLERANCE,
    solver: str = "slsqp",
    posture: str | ArrayLike | None = None,
    approach: ArrayLike | None = None,
    fuzzy: FuzzyStarts | None = None,
) -> LabVoltSolution:
    """Angles of the LabVolt 5250 that put its tool on targets.

    Which targets can be reached is decided in closed form, and for those that cannot the nearest point
    is found; only the others come to the method. Whatever a method says, forward kinematics checks it.

        solution = fd.labvolt.solve([[0.4, 0.1], [0.9, 0.0]])
        solution.angles[solution.success], solution.distance

    - `exact`: the middle of the widest stretch of postures inside the limits, in closed form.
    - `analytic`: algorithm 1, θ_3 guessed from −90° on in steps of 1°.
    - `hybrid_analytic`: the same, first guess by fuzzy rules (section III.A).
    - `sqp`: sequential quadratic programming from the middle of the limits.
    - `hybrid_sqp`: the same from a start by fuzzy rules (section III.B).
    - `ha_after_hs`: `hybrid_analytic` where `hybrid_sqp` fails (section IV.C).
    - `hs_after_ha`: SQP that starts from the result of `hybrid_analytic` (section IV.C).
    - `cascade`: SQP from the fuzzy start, then from the middle, then from the exact solution.

    Args:
        targets: (x, y) in the arm's plane, from the shoulder, y up, or (x, y, z) in the base frame, which
            the base turns to face; (2,), (3,), (N,2) or (N,3) [m].
        method: one of these.
        tolerance: within this a target is reached [m].
        solver: of the SQP: `slsqp` of NLopt, or `snopt`.
        posture: among the postures that reach a target the nearest to this, in relative angles:
            `middle` of the limits, or absolute angles (3,) or (N,3) [rad], such as the last ones. From
            what a method finds, SQP slides there. None: whichever is found. With `approach` it chooses
            between the two postures that there are.
        approach: angle of the hand from the horizontal, θ_3, one or (N,) [rad]: −π/2 picks from above.
            Method `exact` only. Where a target is not reached at it, the nearest angle at which it
            is, see `approach_error`. None: any.
        fuzzy: the rules; None: ours.

    Returns:
        One row a target, see `LabVoltSolution`.

    Raises:
        ValueError: targets that are not numbers or have another shape, or another bad value; the
            message names it and the valid ones.
    """
    if method not in METHODS:
        raise ValueError(f"method must be one of {tuple(METHODS)}, got {method!r}")
    check_tolerance(tolerance)
    geometry = labvolt()
    given = plane_targets(geometry, targets)
    wishes = _wishes(geometry, posture, len(given.given))
    angles = _approach(approach, len(given.given), method)
    off = np.zeros(len(given.valid))
    ways = Ways(geometry, fuzzy or default_starts(), program(solver), tolerance)

    count = len(given.valid)
    q = np.repeat(geometry.middle[:, None], count, axis=1)
    status = np.where(
        given.valid, LabVoltStatus.NOT_SOLVED.value, LabVoltStatus.INVALID_INPUT.value
    )
    error = np.full(count, np.nan)
    tries = np.zeros(count, dtype=int)
    near, distance = given.plane.copy(), np.where(given.valid, 0.0, np.nan)
    exact = np.full((3, count), np.nan)
    for chunk in _chunks(np.flatnonzero(given.valid)):
        exact[:, chunk] = widest_arc(geometry, given.plane[:, chunk])
    far = np.flatnonzero(given.valid & np.isnan(exact[0]))
    if far.size:
        q[:, far], distance[far] = nearest_on_border(geometry, given.plane[:, far])
        exact[:, far], near[:, far], error[far] = q[:, far], geometry.tool(q[:, far]), distance[far]
        status[far[distance[far] > tolerance]] = LabVoltStatus.UNREACHABLE
    goals = Goals(given.plane, exact, wishes)
    for k, way in enumerate(METHODS[method]):
        left = np.flatnonzero(status == LabVoltStatus.NOT_SOLVED)
        if not left.size:
            break
        some = goals if len(left) == count else goals.take(left)
        if angles is None:
            found, runs = ways.settled(some, *way(ways, some))
        else:
            wished = some.exact if some.wishes is None else some.wishes
            found, off[left] = at_approach(geometry, some.points, angles[left], wished)
            found, runs = (
                np.where(np.isnan(found), some.exact, found),
                np.zeros(len(left), dtype=int),
            )
        tries[left] += runs
        lost = np.isnan(found[0])
        if lost.any():
            found = np.where(lost, q[:, left], found)
        q[:, left], error[left] = found, geometry.error(found, some.points)
        done = left[error[left] <= tolerance]
        status[done] = LabVoltStatus.FELL_BACK if k else LabVoltStatus.SOLVED
    if angles is not None:
        off[~np.isin(status, REACHED)] = np.nan
        off = np.where(np.isnan(off) & np.isin(status, REACHED), wrap(q.sum(axis=0) - angles), off)
        status[np.isin(status, REACHED) & (off != 0.0)] = LabVoltStatus.TURNED
    success = np.isin(status, REACHED)
    return LabVoltSolution(
        to_absolute(q.T),
        given.yaw,
        success,
        status,
        error,
        tries,
        given.to_space(geometry, near),
        distance,
        off,
    )


def check_tolerance(tolerance: float) -> float:
    """The tolerance [m]; ValueError unless it is positive and finite."""
    return check_positive_finite("tolerance", tolerance, "m")


def _chunks(lanes: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    """Parts of some lanes whose arrays stay in the processor's cache."""
    for start in range(0, len(lanes), CHUNK):
        yield lanes[start : start + CHUNK]


def _approach(approach: ArrayLike | None, count: int, method: str) -> Array | None:
    """Approach angles (N,)."""
    if approach is None:
        return None
    if method != "exact":
        raise ValueError(f"approach needs the method 'exact', got {method!r}")
    angles = np.asarray(approach, dtype=float)
    if angles.shape not in ((), (count,)) or not np.isfinite(angles).all():
        raise ValueError(f"approach must be one finite angle or ({count},), got {approach!r}")
    return np.broadcast_to(angles, (count,))


def _wishes(geometry: Geometry, posture: str | ArrayLike | None, count: int) -> Array | None:
    """Relative angles (3,N) that are wished for."""
    if posture is None:
        return None
    if isinstance(posture, str):
        if posture != MIDDLE:
            raise ValueError(f"posture must be {MIDDLE!r} or angles, got {posture!r}")
        return np.repeat(geometry.middle[:, None], count, axis=1)
    angles = np.asarray(posture, dtype=float)
    if angles.shape not in ((3,), (count, 3)) or not np.isfinite(angles).all():
        raise ValueError(
            f"posture must be (3,) or ({count}, 3) finite angles, got shape {angles.shape}"
        )
    return np.array(np.broadcast_to(to_relative(angles), (count, 3)).T)
