"""Paper 4, figures 5 to 9."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.labvolt.runs import (
    FEW,
    MANY,
    RANDOM_START,
    few,
    many,
    targets,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.solvers.labvolt.feasible_postures import widest_arc
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.solve import TOLERANCE, solve

BASIC = ("analytic", "hybrid_analytic", RANDOM_START, "hybrid_sqp")
"""Figures 6 and 7, in this order."""
UNIFIED = ("hybrid_sqp", "ha_after_hs", "hs_after_ha")
"""Figure 8."""
LEAST = 1e-14
"""Errors below this are drawn as this [mm]."""


def figure_5() -> Section:
    """Figure 5: the targets."""
    points = targets(FEW)
    distance = np.hypot(*points.T)
    figure = Figure(figsize=(6, 6), layout="constrained")
    axes = figure.subplots()
    _draw_region(axes)
    axes.plot(*(1e3 * points.T), ".", markersize=4, label=f"{FEW} targets")
    axes.plot(0, 0, "k+", markersize=12, label="shoulder")
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left")
    solution = solve(points)
    cells = [
        Cell("targets", 500, len(points)),
        Cell("of these reachable", 500, int(solution.success.sum()), bool(solution.success.all())),
        Cell("nearest to the shoulder [mm]", None, float(1e3 * distance.min())),
        Cell("farthest [mm]", None, float(1e3 * distance.max())),
    ]
    notes = ["The shaded region is all that the arm reaches, by the closed form."]
    return Section("figure 5", "random targets", cells, notes, {"figure_5": figure})


def figure_6() -> Section:
    """Figures 6 to 8: time and error of each execution."""
    runs = few()
    figure = Figure(figsize=(11, 9), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1)
    _draw_executions(top, {name: runs[name].milliseconds for name in BASIC})
    top.set_ylabel("time [ms]")
    top.set_title("figure 6")
    _draw_executions(middle, {name: _millimetres(runs[name].error) for name in BASIC})
    middle.set_ylabel("error [mm]")
    middle.set_title("figure 7")
    _draw_executions(bottom, {name: _millimetres(runs[name].error) for name in UNIFIED})
    bottom.set_ylabel("error [mm]")
    bottom.set_xlabel("execution")
    bottom.set_title("figure 8")
    cells = [
        Cell(f"{name}: spikes above 1 mm", None, int((runs[name].error > 1e-3).sum()))
        for name in dict.fromkeys((*BASIC, *UNIFIED))
    ]
    notes = [f"{FEW} targets a method, one after the other; errors on a logarithmic scale."]
    pictures = {"figures_6_7_8": figure}
    return Section("figure 6", "each execution, figures 6-8", cells, notes, pictures)


def figure_9() -> Section:
    """Figure 9: distribution of the error."""
    runs = many()
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.subplots()
    for name, run in runs.items():
        share = np.arange(1, MANY + 1) / MANY
        axes.step(np.sort(_millimetres(run.error)), share, where="post", label=name)
    axes.set_xscale("log")
    axes.set_ylim(0.85, 1.005)
    axes.set_xlabel("error [mm]")
    axes.set_ylabel("share of targets [-]")
    axes.grid(alpha=0.3)
    axes.legend()
    cells = [
        Cell(f"{name}: within {TOLERANCE * 1e9:g} nm [%]", None, 100.0 * run.solved / MANY)
        for name, run in runs.items()
    ]
    return Section(
        "figure 9", f"distribution of the error, {MANY} targets", cells, [], {"figure_9": figure}
    )


def _draw_region(axes: Axes) -> None:
    """What the arm reaches, by the closed form on a grid."""
    side = np.linspace(-800.0, 800.0, 321)
    x, y = np.meshgrid(side, side)
    reached = ~np.isnan(widest_arc(labvolt(), 1e-3 * np.array([x.ravel(), y.ravel()]))[0])
    axes.contourf(
        x, y, reached.reshape(x.shape), levels=[0.5, 1.5], colors=["tab:orange"], alpha=0.2
    )


def _draw_executions(axes: Axes, values: dict[str, np.ndarray]) -> None:
    for k, (name, value) in enumerate(values.items()):
        x = k * FEW + np.arange(1, FEW + 1)
        axes.semilogy(x, value, ".", markersize=2, label=name)
    axes.grid(alpha=0.3)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), markerscale=4)


def _millimetres(error: np.ndarray) -> np.ndarray:
    return np.maximum(1e3 * error, LEAST)
