"""Paper 4's solver in a run: `LabVoltIk` takes the arm along a square."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import load_scenario
from fikm_drake.simulation.simulate import simulate
from fikm_drake.solvers.labvolt.solution import LabVoltStatus
from fikm_drake.solvers.labvolt.solve import TOLERANCE

SCENARIO = "labvolt_square"
STARTS = {"from the last solution": True, "from the rules in each cycle, as in the paper": False}
"""Where each cycle's SQP starts from, and `warm_start` of it."""
SMOOTH = 0.01
"""Largest step of a joint from cycle to cycle that counts as continuous; the path is 2 mm a cycle [rad]."""


def square() -> Section:
    """A square of 0.1 m that the arm follows, from the last solution or from the rules in each cycle."""
    scenario = load_scenario(SCENARIO)
    cells, logs = [], {}
    for name, warm in STARTS.items():
        log = logs[name] = simulate(scenario.but(controller__warm_start=warm))
        off, solved = log.metrics().e_max, log.status == LabVoltStatus.SOLVED
        step = float(
            np.abs(np.diff(log.q[1:], axis=0)).max()
        )  # the first goes there from the start
        cells += [
            Cell(
                f"{name}: cycles solved [%]", None, 100.0 * float(solved.mean()), bool(solved.all())
            ),
            Cell(f"{name}: tool off, at most [mm]", None, 1e3 * off, off <= TOLERANCE),
            Cell(f"{name}: largest joint step [rad]", None, step, step <= SMOOTH if warm else None),
        ]
    notes = [
        f"`fikm-drake run {SCENARIO}`. The paper solves single targets; that its rules jump from one elbow",
        "to the other on a path is no fault there.",
    ]
    title = "LabVoltIk along a square, in a Diagram"
    return Section("square", title, cells, notes, {"labvolt_square": _joints(logs)})


def _joints(logs: dict[str, RunLog]) -> Figure:
    figure = Figure(figsize=(10, 4.5), layout="constrained")
    for axes, (name, log) in zip(figure.subplots(1, 2, sharey=True), logs.items()):
        for i, joint in enumerate(log.q[1:].T, start=1):
            axes.plot(log.time[1:], joint, linewidth=1.2, label=f"joint {i}")
        axes.set_title(name, fontsize=10)
        axes.set_xlabel("time [s]")
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("joint position [rad]")
    figure.axes[0].legend(fontsize=8)
    return figure
