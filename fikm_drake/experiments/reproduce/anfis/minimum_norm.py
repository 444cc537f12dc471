"""The minimum-norm solution both ways: by the point alone, and integrated along a path."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array, Bools
from fikm_drake.experiments.reproduce.anfis.region import ARM, A, B, plot_region, region, stretches
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.minimum_norm_path import minimum_norm_path

LAPS = 5
SAMPLES = 401
ENTRY = 17.4
"""From here to 96.65 % B is feasible [%]."""


def minimum_norm() -> Section:
    """Laps of A, and B: where the integrated state is outside its limits, feasible or not."""
    arm = load_arm(ARM)
    geometry = Planar3R(arm)
    percent = np.linspace(0.0, 100.0, SAMPLES)
    square, points = A.at(percent), B.at(percent)
    laps = np.concatenate([square, *[square[1:]] * (LAPS - 1)])
    walked = minimum_norm_path(arm, laps, geometry.middle)[:: SAMPLES - 1, 0]

    feasible = feasible_interval_table(arm, points).feasible
    static = closest_to_mid_range(arm, points)
    reached = arm.forward_kinematics(static[feasible])[:, :2, 3]
    error = float(np.abs(reached - points[feasible]).max())
    within = bool(geometry.is_inside(static[feasible]).all())
    entry = int(np.argmax(percent > ENTRY))
    from_p0 = minimum_norm_path(arm, points, geometry.middle)
    from_inside = np.full_like(from_p0, np.nan)
    from_inside[entry:] = minimum_norm_path(arm, points[entry:], static[entry])
    outside = ~geometry.is_inside(from_p0)
    left = ~geometry.is_inside(from_inside) & (percent >= percent[entry])
    start = f"B, integrated from a feasible posture at {percent[entry]:.2f} %"
    cells = [
        Cell("A, integrated: θ1 at P0 at first [rad]", None, float(walked[0])),
        Cell(
            f"A, integrated: θ1 at P0 after {LAPS} laps of {SAMPLES} points [rad]",
            None,
            float(walked[-1]),
        ),
        Cell("B: infeasible points [%]", None, _percent(~feasible)),
        Cell("B, integrated from P0: outside its limits [%]", None, _percent(outside)),
        Cell(
            "B, integrated from P0: outside, where feasible postures exist [%]",
            None,
            _percent(outside & feasible),
            bool((outside & feasible).any()),
        ),
        Cell(f"{start}: outside [%]", "22-35, 75-100", stretches(percent, left)),
        Cell(
            f"{start}: outside, where feasible postures exist [%]",
            None,
            _percent(left & feasible),
            bool((left & feasible).any()),
        ),
        Cell("B, closest to mid-range: tool off its point [m]", None, error, error <= 1e-12),
        Cell("B, closest to mid-range: within its limits", None, "yes" if within else "no", within),
    ]
    notes = [
        "Integrated steps of minimum norm know no limits, and their state depends on the path: laps of",
        "A do not close. The posture closest to the middle of the limits depends on the point alone.",
        "The thesis does not tell its start on B. From a feasible posture, θ1 leaves its limits on about",
        "the stretches that the thesis calls not possible, though feasible postures exist on them.",
    ]
    paths = {"integrated from P0": from_p0, "integrated from a feasible posture": from_inside}
    picture = _plot(percent, paths, static)
    title = "the minimum-norm solution, static and integrated"
    return Section("minimum norm", title, cells, notes, {"minimum_norm": picture})


def _percent(mask: Bools) -> float:
    return 100.0 * float(mask.mean())


def _plot(percent: Array, paths: dict[str, Array], static: Array) -> Figure:
    """θ1 along B: bold where all joints are within their limits, broken where one is not."""
    arm = load_arm(ARM)
    geometry = Planar3R(arm)
    figure = Figure(figsize=(9, 4), layout="constrained")
    axes = figure.subplots()
    plot_region(axes, region(B), 1, arm)
    for (label, q), colour in zip(paths.items(), ("tab:purple", "tab:orange")):
        axes.plot(percent, q[:, 0], "--", color=colour, lw=1.2, label=f"{label}, outside limits")
        within = np.where(geometry.is_inside(q), q[:, 0], np.nan)
        axes.plot(percent, within, color=colour, lw=2.5, label=f"{label}, within")
    axes.plot(percent, static[:, 0], "k:", label="closest to mid-range")
    axes.set_xlabel("share of trajectory B [%]")
    axes.legend(loc="upper center", fontsize=8)
    return figure
