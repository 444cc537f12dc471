"""How bounds are found and how exact they are: algorithm 1 of the thesis, the tracer, the closed form."""

import time

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.region import ARM, A
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.spare_task import SpareTask
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer

POINTS = 16
ALONG_1, BEST = (1.0, 0.0, 0.0), (1.0, 0.0, -1.0)
"""The thesis's arbitrary vector u: along θ1, whose bounds are sought, and the best of the 13 whose
elements are −1, 0 and 1."""
RUNS = ((BEST, 0.05, 50), (BEST, 0.01, 50), (BEST, 0.01, 500), (ALONG_1, 0.01, 500))
"""u, length of a step [rad], steps in each direction; the thesis prints 50 and no length."""


def corrected_algorithm_1(
    task: SpareTask, start: Array, u: tuple[float, ...], step: float, count: int
) -> Array:
    """Postures (2,3) at which a walk along the self-motion from `start` ends, against u and along.

    Each step is the projection of a fixed vector u on the null space, as in the thesis's algorithm
    1. Corrected are what it prints wrong: the limits are checked after every step, the second
    walk begins where the first began, and each step is followed by one of Newton's back to the point.
    What cannot be mended is kept: a walk ends within a step of the limit, and stalls where u is at
    right angles to the self-motion.
    """
    target, fixed = task.pose(start), np.array(u)
    ends = []
    for sign in (-1.0, 1.0):
        q = start
        for _ in range(count):
            _, J = task.error_and_jacobian(target, q)
            inverse = np.linalg.pinv(J)
            moved = q + sign * step * (fixed - inverse @ (J @ fixed))
            error, J = task.error_and_jacobian(target, moved)
            moved = moved + np.linalg.pinv(J) @ error
            if (moved < task.lower).any() or (moved > task.upper).any():
                break
            q = moved
        ends.append(q)
    return np.array(ends)


def algorithm_1() -> Section:
    """Bounds of θ1 along trajectory A by algorithm 1, corrected, by tracing and in closed form."""
    arm = load_arm(ARM)
    points = A.at(np.linspace(0.0, 100.0, POINTS, endpoint=False))
    exact = np.transpose(feasible_interval_table(arm, points).widest())
    starts = closest_to_mid_range(arm, points)
    task, tracer = SpareTask(arm, "xy"), SelfMotionTracer(arm, "xy")
    cells = []
    for u, step, count in RUNS:
        began = time.process_time()
        walked = [corrected_algorithm_1(task, q, u, step, count)[:, 0] for q in starts]
        direction = " ".join(f"{x:g}" for x in u)
        label = f"algorithm 1, corrected, u = ({direction}), {count} x {step:g}"
        cells += _cells(label, np.sort(walked), exact, time.process_time() - began)
    began = time.process_time()
    traced = [tracer.trace(point).intervals(0) for point in points]
    spent = time.process_time() - began
    bounds = np.array([(parts[0].lower, parts[-1].upper) for parts in traced])
    cells += _cells("traced", bounds, exact, spent, claim=1e-9)
    began = time.process_time()
    feasible_interval_table(arm, np.tile(points, (1000, 1)))
    spent = (time.process_time() - began) / 1000
    cells.append(Cell("closed form: CPU time a point [µs]", None, 1e6 * spent / POINTS))
    notes = [
        "As printed the algorithm does not run: dP is not computed anew in the correction, s is not in",
        "the walks, the error has no first value, and the second walk starts where the first ended.",
    ]
    return Section("algorithm 1", "bounds of θ1 on trajectory A, three ways", cells, notes)


def _cells(
    label: str, found: Array, exact: Array, seconds: float, claim: float | None = None
) -> list[Cell]:
    worst = float(np.abs(found - exact).max())
    reached = None if claim is None else worst <= claim
    return [
        Cell(f"{label}: error, at most [rad]", None, worst, reached),
        Cell(f"{label}: CPU time a point [ms]", None, 1e3 * seconds / len(exact)),
    ]


EXACT_POINTS = 20_000
TRACED = 300
POSES = 4


def exactness() -> Section:
    """Closed form against a scan, tracer against the closed form, residuals of 7-joint arms."""
    from fikm_drake.experiments.benchmarks.self_motion_benchmark import (  # it imports this package
        closed_form_against_scan,
        planar_against_closed_form,
        seven_joints,
    )

    scanned = closed_form_against_scan(EXACT_POINTS)
    traced = planar_against_closed_form(TRACED)
    cells = [
        Cell(
            f"closed form against scan and bisection, {EXACT_POINTS} points [rad]",
            None,
            scanned.error,
            scanned.same and scanned.error <= 1e-12,
        ),
        Cell("closed form: CPU time a point [µs]", None, 1e6 * scanned.seconds),
        Cell(
            f"traced against closed form, {TRACED} points [rad]",
            None,
            traced.error,
            traced.same and traced.error <= 1e-9,
        ),
        Cell("traced: CPU time a point [ms]", None, 1e3 * traced.seconds),
    ]
    for name in ("iiwa14", "panda"):
        cost = seven_joints(name, POSES)
        cells += [
            Cell(
                f"{name}, {POSES} poses: residual on the curves [m]",
                None,
                cost.error,
                cost.same and cost.error <= 1e-11,
            ),
            Cell(f"{name}: CPU time a pose [ms]", None, 1e3 * cost.seconds),
        ]
    return Section("exactness", "closed form and tracer, a sample", cells)
