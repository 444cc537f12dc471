"""Paper 4: what it leaves open, and what comes out."""

import dataclasses

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.labvolt.runs import (
    MANY,
    random_start_errors,
    sqp_errors,
    targets,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.mamdani import load_mamdani
from fikm_drake.solvers.labvolt.feasible_postures import widest_arc
from fikm_drake.solvers.labvolt.fuzzy_starts import POSTURE, THETA_3, FuzzyStarts, default_starts
from fikm_drake.solvers.labvolt.geometry import (
    forward_kinematics,
    from_servo_counts,
    labvolt,
    to_absolute,
    to_servo_counts,
)
from fikm_drake.solvers.labvolt.plane_targets import random_targets
from fikm_drake.solvers.labvolt.program import LabVoltProgram
from fikm_drake.solvers.labvolt.solution import LabVoltStatus
from fikm_drake.solvers.labvolt.solve import TOLERANCE, solve

REACHABLE, ANYWHERE, CHECKED = 20_000, 20_000, 300
"""Targets: of postures, uniform in a square, and of those out of reach that are checked by SQP."""
GRID, STARTS = 15, 8
"""Postures of the grid that SQP starts from, a joint; how many of the nearest."""
SQUARE = 0.9
"""Half the side of the square [m]."""
DISTANCE = 1e-6
"""To which the distance of a target that is out of reach is claimed [m]."""
FEWER = 10.0
"""Times fewer guesses of θ_3 that the rules are claimed to need, holes filled."""


def rules() -> Section:
    """Tables 1 and 2: the rules, and what they are worth for algorithm 1."""
    points = targets(MANY)
    faithful = FuzzyStarts(fill_holes=False)
    fired = faithful.theta_3(points.T)[1]
    plain = solve(points, method="analytic").tries.mean()
    holes = solve(points, method="hybrid_analytic", fuzzy=faithful).tries.mean()
    filled = solve(points, method="hybrid_analytic").tries.mean()
    cells = [
        Cell(
            "targets for which no rule of table 1 fires [%]", None, 100.0 * float((~fired).mean())
        ),
        Cell("guesses of θ_3, from −90°, mean", None, float(plain)),
        Cell("guesses of θ_3, rules, −90° in the holes, mean", None, float(holes)),
        Cell("guesses of θ_3, rules, bearing in the holes, mean", None, float(filled)),
        Cell("times fewer than without rules", None, plain / filled, plain >= FEWER * filled),
    ]
    notes = [
        "Table 1 has no rule for (X1, Y3) and (X4, Y1). Entry `h` of table 2 is read as `m`. The figures",
        "give no numbers: memberships are in models/fuzzy/, peaks by `fikm-drake calibrate labvolt`.",
        *load_mamdani(THETA_3).grid().splitlines(),
    ]
    for angle in ("theta_1", "theta_2", "theta_3"):
        notes += [f"{angle}:", *load_mamdani(POSTURE).grid(angle).splitlines()]
    return Section("rules", "tables 1 and 2: rules, and guesses of θ_3", cells, notes)


def starts() -> Section:
    """Where the SQP starts, and in which angles."""
    points, geometry = targets(MANY), labvolt()
    fuzzy = default_starts().posture(points.T).T
    middle = np.repeat(geometry.middle[None], MANY, axis=0)
    cells = []
    for name, absolute in (("relative", False), ("absolute", True)):
        program = LabVoltProgram(geometry, absolute=absolute)
        errors = {
            "random": random_start_errors(points, absolute=absolute),
            "middle of the limits": sqp_errors(program, points, middle),
            "fuzzy": sqp_errors(program, points, fuzzy),
        }
        for start, error in errors.items():
            share = 100.0 * float((error <= TOLERANCE).mean())
            cells.append(Cell(f"{name} angles, start {start}: solved [%]", None, share))
    lines = np.deg2rad(np.arange(-20.0, 120.0, 2.0))
    inward = 0.6 * geometry.reach * np.array([np.cos(lines), np.sin(lines)])
    straight = np.array([lines, np.zeros_like(lines), np.zeros_like(lines)]).T
    reached = sqp_errors(LabVoltProgram(geometry), inward.T, straight) <= TOLERANCE
    cells.append(
        Cell(
            "stretched arm, target straight inward: solved [%]", None, 100.0 * float(reached.mean())
        )
    )
    notes = [
        "Equation 5 is in absolute angles, where two limits are linear constraints. In relative angles all",
        "limits are bounds, and the middle of the limits is as good a start as the rules.",
        "A stretched arm is a saddle for a target on its line: no step is downhill. So it is bent first.",
    ]
    return Section("starts", f"where the SQP starts, {MANY} targets", cells, notes)


def reach() -> Section:
    """What can be reached, and how far it is to what cannot."""
    points = random_targets(REACHABLE, seed=1)
    cascade = solve(points, method="cascade")
    worst = 1e3 * float(cascade.error.max())
    square = np.random.default_rng(2).uniform(-SQUARE, SQUARE, (ANYWHERE, 2))
    everywhere = solve(square)
    far = np.flatnonzero(everywhere.status == LabVoltStatus.UNREACHABLE)
    off = np.hypot(*(forward_kinematics(everywhere.angles[far]) - everywhere.nearest[far]).T)
    by_sqp = _nearest_by_sqp(square[far[:CHECKED]])
    apart = float(np.abs(by_sqp - everywhere.distance[far[:CHECKED]]).max())
    inside = square[everywhere.success]
    thin = int((~solve(inside, method="analytic").success).sum())
    told = bool((everywhere.success | (everywhere.status == LabVoltStatus.UNREACHABLE)).all())
    fell_back = int((cascade.status == LabVoltStatus.FELL_BACK).sum())
    cells = [
        Cell(
            f"cascade: of {REACHABLE} reachable targets solved",
            None,
            int(cascade.success.sum()),
            bool(cascade.success.all()),
        ),
        Cell("cascade: worst error [mm]", None, worst, worst <= 1e-6),
        Cell("cascade: solved only by a second or third start", None, fell_back),
        Cell(f"of {ANYWHERE} targets in a square: out of reach", None, len(far)),
        Cell("all others solved, exactly", None, "yes" if told else "no", told),
        Cell("algorithm 1 in steps of 1°: of these missed, between two steps", None, thin),
        Cell("tool from the nearest point that is told, at most [m]", None, float(off.max())),
        Cell("nearest distance, from the best of SQP [m]", None, apart, apart <= DISTANCE),
    ]
    notes = [
        f"The last: {CHECKED} targets, SQP from {STARTS} postures of a grid each; it minimises the distance",
        "from a target, out of reach or not, so its best must be the distance of the closed form.",
    ]
    return Section("reach", "what can be reached, in closed form", cells, notes)


def rounding() -> Section:
    """Where micrometres may come from."""
    points, geometry = targets(MANY), labvolt()
    cells = []
    for name, paper in (("analytic", (5.79, 24.80)), ("hybrid_analytic", (3.86, 22.2))):
        angles = solve(points, method=name).angles
        counted = from_servo_counts(to_servo_counts(angles))
        error = 1e6 * np.hypot(*(forward_kinematics(counted) - points).T)
        cells.append(
            Cell(
                f"{name}, rounded to servo counts: error [µm]",
                f"{paper[0]:.3g} ± {paper[1]:.3g}",
                f"{error.mean():.3g} ± {error.std():.3g}",
                1.0 <= error.mean() <= 10.0,
            )
        )
    library = dataclasses.replace(geometry, lengths=(0.36, 0.228, 0.1654))
    error = 1e6 * np.hypot(
        *(forward_kinematics(to_absolute(widest_arc(library, points.T).T)) - points).T
    )
    error = error[np.isfinite(error)]
    cells.append(Cell("closed form with 360 and 228 mm: error [µm]", None, float(error.mean())))
    notes = [
        "A hypothesis: angles rounded to the counts of the arm's servos err by the paper's order of",
        "magnitude, without its spread. The first author's MATLAB library inverts an arm of 360 and 228 mm",
        "(132² and 588² in its roots), its forward kinematics have 360.4 and 228.5: that errs by more.",
    ]
    return Section("rounding", "why the paper's closed form errs by micrometres", cells, notes)


def _nearest_by_sqp(points: Array) -> Array:
    """The least distance (N,) [m] that the SQP finds from the nearest postures of a grid."""
    geometry = labvolt()
    program = LabVoltProgram(geometry)
    sides = [np.linspace(low, high, GRID) for low, high in zip(geometry.lower, geometry.upper)]
    grid = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 3)
    tools = geometry.tool(grid.T)
    distance = np.full(len(points), np.inf)
    for i, point in enumerate(points):
        near = np.hypot(*(tools - point[:, None])).argsort()[:STARTS]
        same = np.repeat(point[None], STARTS, axis=0)
        distance[i] = sqp_errors(program, same, grid[near]).min()
    return distance
