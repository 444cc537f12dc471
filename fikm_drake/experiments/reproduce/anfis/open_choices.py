"""Paper 2: what it leaves open, each read in more than one way, and what each reading gives."""

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.minimum_norm import ENTRY
from fikm_drake.experiments.reproduce.anfis.region import (
    ARM,
    A,
    B,
    C,
    Trajectory,
    stretches,
)
from fikm_drake.experiments.reproduce.anfis.samples import (
    TRAINING_POINTS,
    edged_training_points,
    exact,
    fresh_points,
    fresh_values,
    rms_and_max,
    training_points,
)
from fikm_drake.experiments.reproduce.anfis.three_ways import BEST, corrected_algorithm_1
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.redundancy.workspace_points import random_workspace_points
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.minimum_norm_path import minimum_norm_path
from fikm_drake.solvers.self_motion.spare_task import SpareTask

WALKS = {
    "u along θ1, step .01": ((1.0, 0.0, 0.0), 0.01),
    "u along θ2, step .01": ((0.0, 1.0, 0.0), 0.01),
    "u along θ3, step .01": ((0.0, 0.0, 1.0), 0.01),
    "u = (1 1 1), step .01": ((1.0, 1.0, 1.0), 0.01),
    "u = (1 0 −1), step .01": (BEST, 0.01),
    "u = (1 0 −1), step .02": (BEST, 0.02),
    "u = (1 0 −1), step .05": (BEST, 0.05),
    "u = (1 0 −1), step .1": (BEST, 0.1),
    "u = (1 0 −1), step 1": (BEST, 1.0),
}
"""Algorithm 1's arbitrary vector and the factor that its last line lacks [rad]; 50 steps, as printed."""
WALK_STEPS, WALK_POINTS = 50, 8
SAMPLES = 401
"""Points of B."""
PAPERS_STRETCHES = "0-17, 22-35, 75-100"
"""Of B, called not possible [%]."""
EPOCHS = 40
"""Of the hybrid rule, so that the readings cost little; the thesis's 150 are in figure 4.8."""
SEED = 7
C_SHIFTS = ((0.0, 0.0), (0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1))
"""By which trajectory C, of which the thesis only has a drawing, may be elsewhere [m]."""


@cache
def training_sets() -> dict[str, Array]:
    """Training points (N,2) [m], about as many as the thesis's."""
    return {
        "a grid (ours)": training_points(),
        "a grid and points on the edge": edged_training_points(),
        "random": random_workspace_points(load_arm(ARM), TRAINING_POINTS, SEED),
    }


def by_length(trajectory: Trajectory, percent: Array) -> Array:
    """Points (…,2) [m] of a trajectory whose percentage is of its length, not of its sides."""
    corners = np.array(trajectory.corners)
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    shares = np.concatenate([[0.0], 100.0 * length.cumsum() / length.sum()])
    return np.stack([np.interp(percent, shares, column) for column in corners.T], axis=-1)


def walk_errors() -> dict[str, float]:
    """Largest error of the bounds of θ1 on A by algorithm 1, corrected, for each reading [rad]."""
    arm = load_arm(ARM)
    points = A.at(np.linspace(0.0, 100.0, WALK_POINTS, endpoint=False))
    bounds = np.transpose(feasible_interval_table(arm, points).widest())
    starts, task = closest_to_mid_range(arm, points), SpareTask(arm, "xy")
    found = {}
    for name, (u, step) in WALKS.items():
        ends = [corrected_algorithm_1(task, q, u, step, WALK_STEPS)[:, 0] for q in starts]
        found[name] = float(np.abs(np.sort(ends) - bounds).max())
    return found


def stretches_of_b() -> dict[str, str]:
    """Where B is not possible [%], as each reading has it."""
    arm, geometry = load_arm(ARM), Planar3R(load_arm(ARM))
    percent = np.linspace(0.0, 100.0, SAMPLES)
    found = {}
    for share, points in (
        ("of its sides", B.at(percent)),
        ("of its length", by_length(B, percent)),
    ):
        table = feasible_interval_table(arm, points)
        name = f"per cent {share}"
        found[f"{name}; no posture at all"] = stretches(percent, ~table.feasible)
        entry = int(np.argmax(table.feasible & (percent > ENTRY)))
        starts = {"the middle at P0": (0, geometry.middle)}
        for start in ("closest to mid-range", "lowest θ1", "highest θ1"):
            starts[f"{start} at {percent[entry]:.1f} %"] = entry, _posture(start, points[entry])
        for start, (first, q) in starts.items():
            path = minimum_norm_path(arm, points[first:], q)
            outside = np.concatenate([np.zeros(first, dtype=bool), ~geometry.is_inside(path)])
            found[f"{name}; minimum norm outside, from {start}"] = stretches(percent, outside)
    return found


def _posture(which: str, point: Array) -> Array:
    """A posture at a point: closest to mid-range, or with θ1 near one of its bounds."""
    arm = load_arm(ARM)
    if which == "closest to mid-range":
        return closest_to_mid_range(arm, point[None])[0]
    lower, upper = (float(end[0]) for end in feasible_interval_table(arm, point[None]).widest())
    share = 0.05 if which == "lowest θ1" else 0.95
    task, target = SpareTask(arm, "xy"), closest_to_mid_range(arm, point[None])[0]
    pose, goal, q = task.pose(target), lower + share * (upper - lower), target
    for _ in range(200):  # along the self-motion to that θ1
        error, J = task.error_and_jacobian(pose, q)
        full = np.vstack([J, [1.0, 0.0, 0.0]])
        wanted = np.append(error, np.clip(goal - q[0], -0.02, 0.02))
        q = q + np.linalg.lstsq(full, wanted, rcond=1e-9)[0]
    return q


def readings() -> Section:
    """Algorithm 1's vector and step, B's percentage and start, the training data, trajectory C."""
    cells, walks = [], walk_errors()
    for name, error in walks.items():
        label = f"algorithm 1, {WALK_STEPS} steps, {name}: bounds of θ1 on A are off by [rad]"
        cells.append(Cell(label, None, error))
    for name, text in stretches_of_b().items():
        cells.append(Cell(f"B, {name} [%]", PAPERS_STRETCHES, text))
    learned: dict[str, tuple[float, float]] = {}
    for name, points in training_sets().items():
        anfis = Anfis((8, 8)).fit(points, exact(points)["upper"], epochs=EPOCHS)
        off = anfis.predict(fresh_points()) - fresh_values()["upper"]
        learned[name] = rms_and_max(off)
        text = " / ".join(f"{1e3 * value:.1f}" for value in learned[name])
        cells.append(Cell(f"training data, {name}: upper bound, rms / max [mrad]", None, text))
    for shift in C_SHIFTS:
        table = feasible_interval_table(load_arm(ARM), _c(shift))
        lower, upper = table.widest()
        text = f"{np.min(upper - lower):.3f}" if table.feasible.all() else "leaves the workspace"
        label = f"C moved by ({shift[0]:g}, {shift[1]:g}) m: narrowest region of θ1 [rad]"
        cells.append(Cell(label, None, text))
    notes = [
        "Lost: the vector u of algorithm 1 and the factor of its steps, whether the per cents of B are of",
        "its sides or of its length, where the state begins on B, the points of the training data, the",
        "corners of C. Given, and not varied: the arm, A and B, 50 steps, 8 x 8 Gaussian memberships,",
        f"order 1, the hybrid rule (here {EPOCHS} epochs; 150 in figure 4.8). With 50 steps a short step",
        "ends before the limit, whatever u, a long one a step before it. B's stretches come out, roughly,",
        "with per cents of its sides and a state of minimum norm that starts inside the limits; postures",
        "inside them exist there. Which points are learned from, and where exactly C lies, changes little.",
    ]
    picture = {"anfis_readings": _figure(walks, learned)}
    return Section(
        "readings", "what the thesis leaves open, read in other ways", cells, notes, picture
    )


def _c(shift: tuple[float, float]) -> Array:
    """Points (101,2) of trajectory C, moved [m]."""
    corners = tuple((x + shift[0], y + shift[1]) for x, y in C.corners)
    return Trajectory("C", corners).at(np.linspace(0.0, 100.0, 101))


def _figure(walks: dict[str, float], learned: dict[str, tuple[float, float]]) -> Figure:
    figure = Figure(figsize=(12, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    rows = np.arange(len(walks))[::-1]
    left.barh(rows, list(walks.values()))
    left.set_yticks(rows, list(walks))
    left.set_xlabel("algorithm 1: largest error of the bounds on A [rad]")
    rows = np.arange(len(learned))[::-1]
    for k, name in enumerate(("rms", "largest")):
        values = [1e3 * errors[k] for errors in learned.values()]
        right.plot(values, rows, "os"[k], label=name)
    right.set_yticks(rows, list(learned))
    right.set_ylim(-0.5, len(learned) - 0.5)
    right.set_xscale("log")
    right.set_xlabel("upper bound learned: error over fresh points [mrad]")
    right.legend()
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure
