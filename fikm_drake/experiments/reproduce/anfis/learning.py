"""Figures 4.8-4.11: the thesis's three ANFIS of x and y, trained by the hybrid rule."""

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.anfis.samples import (
    FRESH_POINTS,
    QUANTITIES,
    SEED,
    exact,
    fresh_points,
    fresh_values,
    rms_and_max,
    training_points,
    validation_points,
)
from fikm_drake.experiments.reproduce.anfis.tables import NUMBERS, bilinear_table
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.anfis.anfis import Anfis

EPOCHS = 150
RMS = {"upper": 0.0088, "lower": 0.0040, "static": 0.0030}
"""Claimed root mean square errors over fresh points [rad]; the thesis gives none."""


@cache
def hybrid_anfis() -> dict[str, Anfis]:
    """The ANFIS of Table 4.1, trained on the exact bounds."""
    points, held = training_points(), validation_points()
    values, wanted = exact(points), exact(held)
    return {
        name: Anfis((8, 8), names=("x", "y", f"theta_1_{name}")).fit(
            points, values[name], epochs=EPOCHS, validation=(held, wanted[name])
        )
        for name in QUANTITIES
    }


def figure_4_8() -> Section:
    """Table 4.1 and figures 4.8-4.11: memberships, training errors, errors over fresh points."""
    learned, values = hybrid_anfis(), exact(training_points())
    cells = [
        Cell("training points", 3356, len(training_points())),
        Cell("rules of each ANFIS", 64, learned["upper"].num_rules),
    ]
    for name in QUANTITIES:
        rms, largest = rms_and_max(learned[name].predict(fresh_points()) - fresh_values()[name])
        trained = float(learned[name].training_error.min())
        cells += [
            Cell(f"{name}: rms error, training [rad]", None, trained),
            Cell(f"{name}: rms error, fresh points [rad]", None, rms, rms <= RMS[name]),
            Cell(f"{name}: largest error, fresh points [rad]", None, largest),
        ]
        bilinear = bilinear_table(training_points(), values[name], round(np.sqrt(NUMBERS)))
        rms, _ = rms_and_max(bilinear(*fresh_points().T) - fresh_values()[name])
        cells.append(Cell(f"{name}: bilinear table of its size, rms error [rad]", None, rms))
    notes = [
        f"Fresh points: {FRESH_POINTS}, uniform over the workspace, seed {SEED}. Claimed: rms at most "
        + ", ".join(f"{RMS[name]:g} ({name})" for name in QUANTITIES)
        + " rad.",
        "static: the posture closest to mid-range, which depends on the point alone; the thesis integrates.",
        "A rule of the upper bound: " + learned["upper"].rules()[27],
    ]
    return Section(
        "figure 4.8",
        "three ANFIS, 8 x 8 Gaussian memberships, hybrid rule, 150 epochs, figures 4.8-4.11",
        cells,
        notes,
        {"figure_4_8": _memberships(learned), "figures_4_9_11": _training(learned)},
    )


def plot_memberships(axes: Axes, anfis: Anfis, k: int, unit: str) -> None:
    """Draw the memberships of input k (from 0) over the range of the training data."""
    low, high = (float(end[k]) for end in anfis.input_range)
    values = np.linspace(low, high, 500)
    axes.plot(values, anfis.grades(k, values).T, linewidth=1.2)
    axes.set_xlabel(f"{anfis.names[k]} [{unit}]")
    axes.set_ylim(0, 1.05)


def _memberships(learned: dict[str, Anfis]) -> Figure:
    figure = Figure(figsize=(10, 7), layout="constrained")
    grid = figure.subplots(3, 2)
    for row, (name, anfis) in zip(grid, learned.items()):
        for k, axes in enumerate(row):
            plot_memberships(axes, anfis, k, "m")
        row[0].set_ylabel(f"{name}: grade [-]")
    return figure


def _training(learned: dict[str, Anfis]) -> Figure:
    figure = Figure(figsize=(10, 3.4), layout="constrained")
    for axes, (name, anfis) in zip(figure.subplots(1, 3), learned.items()):
        axes.plot(range(1, EPOCHS + 1), 1000 * anfis.training_error, label="training")
        axes.plot(range(1, EPOCHS + 1), 1000 * anfis.validation_error, label="validation")
        axes.set_title(name)
        axes.set_xlabel("epoch")
        axes.set_ylim(bottom=0)
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("rms error [mrad]")
    figure.axes[0].legend()
    return figure
