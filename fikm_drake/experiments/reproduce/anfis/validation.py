"""Section 4.4 and 4.5: predictions along trajectory A, and joints along trajectory C."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.anfis.learning import hybrid_anfis
from fikm_drake.experiments.reproduce.anfis.region import ARM, A
from fikm_drake.experiments.reproduce.anfis.samples import exact, fresh_points, rms_and_max
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import load_scenario
from fikm_drake.simulation.simulate import simulate
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.redundancy.resolution import ResolutionStatus

TESTED = 200
"""Points of trajectory A; the thesis tests as many."""
EXACT = 1e-12
"""What the tool may be off [m]."""
RAW = 99.4
"""Postures from learned bounds that must respect all limits before any repair [%]."""


def figure_4_12() -> Section:
    """Figures 4.12 and 4.13: the three ANFIS along trajectory A."""
    percent = np.linspace(0.0, 100.0, TESTED)
    points = A.at(percent)
    wanted, learned = exact(points), hybrid_anfis()
    figure = Figure(figsize=(11, 4), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    cells = []
    for name, axes in (("upper", left), ("lower", left), ("static", right)):
        predicted = learned[name].predict(points)
        rms, largest = rms_and_max(predicted - wanted[name])
        cells.append(Cell(f"{name}: rms error [rad]", None, rms))
        cells.append(Cell(f"{name}: largest error [rad]", None, largest))
        axes.plot(percent, wanted[name], linewidth=3, alpha=0.35, label=f"{name}, exact")
        axes.plot(percent, predicted, "k-", linewidth=1, label=f"{name}, ANFIS")
    for axes in (left, right):
        axes.set_xlabel("share of trajectory A [%]")
        axes.grid(alpha=0.3)
        axes.legend()
    left.set_ylabel("θ1 [rad]")
    return Section(
        "figure 4.12",
        f"predictions at {TESTED} points of trajectory A, figures 4.12, 4.13",
        cells,
        pictures={"figures_4_12_13": figure},
    )


def figure_4_16() -> Section:
    """Figures 4.15-4.18: trajectory C in a Diagram, in the middle of the learned bounds."""
    arm = load_arm(ARM)
    log = simulate(load_scenario("anfis_c"))
    run = log.cycles
    error = log.metrics().e_max
    inside = bool(((run.q >= arm.lower) & (run.q <= arm.upper)).all())
    learned = 100.0 * float(np.mean(log.status[1:] == ResolutionStatus.SOLVED))
    steps = np.abs(np.diff(run.q, axis=0)).max(axis=0)
    cells = [
        Cell("limits of all joints respected", "yes", "yes" if inside else "no", inside),
        Cell("tool off the trajectory, at most [m]", None, error, error <= EXACT),
        Cell("cycles resolved by the learned bounds, without repair [%]", None, learned),
        Cell("largest joint step of a cycle [rad]", None, float(steps.max())),
    ]
    notes = [
        "`fikm-drake run anfis_c`: RedundancyIk and the plant's scene in one Diagram, 10 s at 50 Hz."
    ]
    return Section(
        "figure 4.16",
        "trajectory C through RedundancyIk, figures 4.15-4.18",
        cells,
        notes,
        {"figures_4_15_18": _joints(log)},
    )


def resolution() -> Section:
    """Redundancy resolution of fresh random points: raw, repaired, and points out of the workspace."""
    arm, points = load_arm(ARM), fresh_points()
    found = RedundancyResolver(arm).resolve(points)
    raw = 100.0 * float(np.mean(found.status == ResolutionStatus.SOLVED))
    inside = 100.0 * float(np.mean(((found.q >= arm.lower) & (found.q <= arm.upper)).all(axis=1)))
    largest = float(np.nanmax(found.position_error))
    widths = found.upper - found.lower
    repaired = widths[found.status == ResolutionStatus.REPAIRED]
    beyond = RedundancyResolver(arm).resolve(fresh_points()[:1000] * [1.0, -1.0])
    flagged = bool((beyond.success == (beyond.position_error <= EXACT)).all())
    cells = [
        Cell("limits respected, learned bounds alone [%]", None, raw, raw >= RAW),
        Cell("limits respected after repair [%]", 100, inside, inside == 100.0),
        Cell("tool off the point, at most [m]", None, largest, largest <= EXACT),
        Cell("width of the region where repair was needed, median [rad]", None, _median(repaired)),
        Cell("width of all regions, median [rad]", None, _median(widths)),
        Cell(
            "1000 points mirrored below the arm: reached, or flagged",
            None,
            f"{np.count_nonzero(beyond.success)}, {np.count_nonzero(~beyond.success)}",
            flagged,
        ),
    ]
    return Section(
        "resolution",
        f"redundancy resolution of {len(points)} random points of the workspace",
        cells,
    )


def _median(values: np.ndarray) -> float | None:
    return float(np.median(values)) if values.size else None


def _joints(log: RunLog) -> Figure:
    run = log.cycles
    figure = Figure(figsize=(11, 6), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.3))
    path = figure.add_subplot(grid[:, 0])
    path.plot(*run.desired.T, "k--", linewidth=1, label="desired")
    path.plot(*run.actual.T, color="tab:blue", label="tool")
    path.set_xlabel("x [m]")
    path.set_ylabel("y [m]")
    path.set_aspect("equal")
    path.legend()
    percent = np.linspace(0.0, 100.0, len(run.q))
    limits = load_arm(ARM)
    for j in range(3):
        axes = figure.add_subplot(grid[j, 1])
        if j == 0:
            axes.fill_between(percent, *log["bounds"][1:].T, color="0.9", label="learned region")
        axes.plot(percent, run.q[:, j], color="tab:blue", label="commanded")
        for limit in (limits.lower[j], limits.upper[j]):
            axes.axhline(limit, color="black", ls="--", lw=0.8)
        axes.set_ylabel(f"θ{j + 1} [rad]")
        axes.tick_params(labelbottom=j == 2)
        axes.grid(alpha=0.3)
    figure.axes[1].legend(fontsize=8, loc="upper right")
    figure.axes[-1].set_xlabel("share of trajectory C [%]")
    return figure
