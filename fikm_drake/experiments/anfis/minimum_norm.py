"""The minimum-norm solution both ways: by the point alone, and integrated along a path."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.experiments.anfis.region import ARM, plot_region, region
from fikm_drake.experiments.anfis.trajectories import A, B
from fikm_drake.experiments.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.regions.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.regions.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.regions.minimum_norm_path import minimum_norm_path

LAPS = 5
SAMPLES = 401


def minimum_norm() -> Section:
    """Laps of A, and B: where the integrated state is outside its limits, feasible or not."""
    arm = load_arm(ARM)
    geometry = Planar3R(arm)
    percent = np.linspace(0.0, 100.0, SAMPLES)
    square, rectangle = A.at(percent), B.at(percent)
    laps = np.concatenate([square, *[square[1:]] * (LAPS - 1)])
    walked = minimum_norm_path(arm, laps, geometry.middle)[:: SAMPLES - 1, 0]
    static = closest_to_mid_range(arm, square)
    closed = float(np.abs(static[-1] - static[0]).max())
    integrated = minimum_norm_path(arm, rectangle, geometry.middle)
    feasible = feasible_interval_table(arm, rectangle).feasible
    outside = ~geometry.is_inside(integrated)
    best = closest_to_mid_range(arm, rectangle)
    error = np.abs(arm.forward_kinematics(best[feasible])[:, :2, 3] - rectangle[feasible]).max()
    within = bool(geometry.is_inside(best[feasible]).all())
    cells = [
        Cell("A, integrated: θ1 at P0 at first [rad]", None, float(walked[0])),
        Cell(f"A, integrated: θ1 at P0 after {LAPS} laps [rad]", None, float(walked[-1])),
        Cell(
            "A, closest to mid-range: change of a posture in a lap [rad]",
            None,
            closed,
            closed == 0.0,
        ),
        Cell("B: infeasible points [%]", None, 100.0 * float((~feasible).mean())),
        Cell("B, integrated: outside its limits [%]", None, 100.0 * float(outside.mean())),
        Cell(
            "B, integrated: outside where feasible postures exist [%]",
            None,
            100.0 * float((outside & feasible).mean()),
            bool((outside & feasible).any()),
        ),
        Cell(
            "B, closest to mid-range: within where feasible",
            None,
            "yes" if within else "no",
            within,
        ),
        Cell("B, closest to mid-range: tool off its point [m]", None, float(error), error <= 1e-12),
    ]
    notes = [
        "Integrated steps of minimum norm know no limits, and their state depends on the path: laps of",
        "A do not close. The posture closest to the middle of the limits depends on the point alone.",
        "The thesis does not tell where it started on B; here it is the middle of the limits.",
    ]
    figure = Figure(figsize=(9, 4), layout="constrained")
    axes = figure.subplots()
    plot_region(axes, region(B), 1, arm)
    axes.plot(
        percent, integrated[:, 0], "k-", label="integrated, with joints 1 to 3 in their limits"
    )
    axes.lines[-1].set_ydata(np.where(outside, np.nan, integrated[:, 0]))
    axes.plot(
        percent,
        np.where(outside, integrated[:, 0], np.nan),
        color="tab:purple",
        label="integrated, a joint outside its limits",
    )
    axes.plot(percent, best[:, 0], "k:", label="closest to mid-range")
    axes.set_xlabel("share of trajectory B [%]")
    axes.legend(loc="upper center", fontsize=9)
    return Section(
        "minimum norm",
        "the minimum-norm solution, static and integrated",
        cells,
        notes,
        {"minimum_norm": figure},
    )
