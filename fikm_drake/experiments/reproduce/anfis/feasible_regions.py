"""Figures 3.6, 3.9, 3.10 (trajectory A) and 3.13-3.15 (trajectory B): feasible regions."""

import numpy as np

from fikm_drake.experiments.reproduce.anfis.region import (
    ARM,
    A,
    B,
    Region,
    Trajectory,
    plot_regions,
    region,
    stretches,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.interval_table import END_NAMES, IntervalTable

TRACED = 1e-9
"""The difference between traced and exact bounds that we claim [rad]."""
FINE = 80_001
"""Points of a trajectory for the shares of it: one each 0.00125 %."""


def figure_3_6() -> Section:
    """Trajectory A, with figures 3.9 and 3.10."""
    found, table = region(A), _fine(A)
    cells = [
        Cell(
            "feasible share of the trajectory [%]",
            100,
            _feasible(table),
            bool(table.feasible.all()),
        ),
        _traced(found),
        Cell("intervals of θ1 at a point, at most", 1, found.components(), found.components() == 1),
        *_ends(table),
    ]
    return Section(
        "figure 3.6",
        "feasible regions along trajectory A, figures 3.6, 3.9, 3.10",
        cells,
        pictures={"figures_3_6_9_10": plot_regions(found)},
    )


def figure_3_13() -> Section:
    """Trajectory B, with figures 3.14 and 3.15: where it is infeasible."""
    found, table = region(B), _fine(B)
    percent = np.linspace(0.0, 100.0, FINE)
    text = stretches(percent, ~table.feasible)
    inside = (percent > 17.4) & (percent < 96.6)
    paper = "0-17, 22-35, 75-100"
    inside_feasible = bool(table.feasible[inside].all())
    cells = [
        Cell("infeasible [%]", paper, text),
        Cell("feasible throughout 17.4-96.6 %", "no", _yes(inside_feasible), inside_feasible),
        Cell("feasible share of the trajectory [%]", None, _feasible(table)),
        _traced(found),
        *_ends(table),
    ]
    notes = [
        "Another answer than the thesis's, so the first cell is not called ok.",
        "Feasible are 17.33 to 96.65 % and one posture by itself: all joints at a corner of their",
        "limits put the tool at (-1.5, 1). The thesis saw more because it begins its self-motions at a",
        "state integrated by steps of minimum norm, and makes none where that state is outside its",
        "limits. Such a state leaves them on 18-39 and 75-100 %: see `minimum norm`.",
    ]
    return Section(
        "figure 3.13",
        "feasible regions along trajectory B, figures 3.13-3.15",
        cells,
        notes,
        {"figures_3_13_14_15": plot_regions(found)},
    )


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _fine(trajectory: Trajectory) -> IntervalTable:
    return feasible_interval_table(load_arm(ARM), trajectory.at(np.linspace(0.0, 100.0, FINE)))


def _feasible(table: IntervalTable) -> float:
    return 100.0 * float(table.feasible.mean())


def _traced(found: Region) -> Cell:
    """The largest difference between traced and exact bounds of θ1."""
    table = feasible_interval_table(load_arm(ARM), found.trajectory.at(found.percent))
    differences = np.abs(np.subtract(found.bounds(0), table.widest()))
    same = np.array_equal(np.isnan(differences[0]), ~table.feasible)
    largest = float(np.nanmax(differences))
    return Cell(
        "traced θ1 against closed form, at most [rad]", None, largest, same and largest <= TRACED
    )


def _ends(table: IntervalTable) -> list[Cell]:
    """What ends θ1's region, stretch by stretch."""
    percent = np.linspace(0.0, 100.0, FINE)
    cells = []
    for side, codes in (("below", table.lower_end[:, 0]), ("above", table.upper_end[:, 0])):
        changes = np.flatnonzero(np.diff(codes)) + 1
        starts = [0, *(int(i) for i in changes)]
        ends = [*starts[1:], FINE]
        for low, high in zip(starts, ends):
            if codes[low] >= 0 and high - low > 20:  # touches of a corner are left out
                label = f"θ1 ends {side}, {percent[low]:.1f}-{percent[high - 1]:.1f} %"
                cells.append(Cell(label, None, END_NAMES[codes[low]]))
    return cells
