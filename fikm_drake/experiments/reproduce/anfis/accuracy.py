"""How well the bounds can be learned, and what a table of the same size does."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.region import ARM
from fikm_drake.experiments.reproduce.anfis.samples import (
    QUANTITIES,
    edged_training_points,
    exact,
    fresh_points,
    fresh_values,
    load_static,
    rms_and_max,
)
from fikm_drake.experiments.reproduce.anfis.tables import NUMBERS, bilinear_table, radial_table
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds

RMS = {"upper": 0.0025, "lower": 0.0027, "static": 0.0028}
LARGEST = 0.06
"""Claimed errors over fresh points [rad]."""


def polar_anfis() -> dict[str, Anfis]:
    """The ANFIS that come with the library."""
    bounds = LearnedBounds.load(ARM)
    return {"upper": bounds.upper, "lower": bounds.lower, "static": load_static()}


def accuracy() -> Section:
    """Polar inputs and variable projection, beside the exact form and tables."""
    arm, points = load_arm(ARM), edged_training_points()
    polar, fresh = (BoundsInputs(arm, "xy", "polar")(p) for p in (points, fresh_points()))
    values, wanted, learned = exact(points), fresh_values(), polar_anfis()
    cells = []
    errors: dict[str, Array] = {}
    for name in QUANTITIES:
        errors[name] = learned[name].predict(fresh) - wanted[name]
        rms, largest = rms_and_max(errors[name])
        cells += [
            Cell(f"{name}: ANFIS, rms error [rad]", None, rms, rms <= RMS[name]),
            Cell(f"{name}: ANFIS, largest error [rad]", None, largest, largest <= LARGEST),
        ]
        table = bilinear_table(polar, values[name], round(np.sqrt(NUMBERS)))
        rms, largest = rms_and_max(table(*fresh.T) - wanted[name])
        cells.append(Cell(f"{name}: bilinear table of its size, rms error [rad]", None, rms))
        cells.append(Cell(f"{name}: the same, largest error [rad]", None, largest))
        if name != "static":
            rms, largest = rms_and_max(radial_table(arm, name, NUMBERS)(fresh) - wanted[name])
            cells.append(Cell(f"{name}: table over distance alone, rms error [rad]", None, rms))
            cells.append(Cell(f"{name}: the same, largest error [rad]", None, largest))
    notes = [
        "8 x 8 Gaussian memberships of distance and angle, variable projection, 150 epochs, as they come",
        f"with the library (`fikm-drake train bounds {ARM}`, `fikm-drake train static`). Claimed: rms",
        f"at most {', '.join(f'{RMS[name]:g} ({name})' for name in QUANTITIES)} rad, none above {LARGEST:g}.",
        "The closed form has no such error at all. A turn about the base turns the bounds, so a table over",
        "the distance alone beats every ANFIS. What ANFIS has over the exact form here is speed.",
    ]
    return Section(
        "accuracy",
        "bounds learned from polar inputs, beside tables",
        cells,
        notes,
        {"anfis_errors": _map(errors)},
    )


def _map(errors: dict[str, Array]) -> Figure:
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    x, y = fresh_points().T
    for axes, (name, error) in zip(figure.subplots(1, 3), errors.items()):
        dots = axes.scatter(x, y, c=1000 * error, s=1, cmap="coolwarm", vmin=-15, vmax=15)
        axes.set_title(name)
        axes.set_xlabel("x [m]")
        axes.set_aspect("equal")
    figure.axes[0].set_ylabel("y [m]")
    figure.colorbar(dots, ax=figure.axes, label="error of θ1 [mrad]", extend="both")
    return figure
