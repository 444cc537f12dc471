"""Paper 5, section 4.1: figures 7-12, paths of the tool on the workplane."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.integer.errors import workplane_errors
from fikm_drake.experiments.reproduce.integer.table_1 import TABLE_1
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.simulation.scenario import Integer, Scenario, load_scenario
from fikm_drake.simulation.simulate import simulate
from fikm_drake.solvers.workplane.integer_fuzzy_ik import tojo_inverse
from fikm_drake.solvers.workplane.workplane_inverse import WorkplaneInverse
from fikm_drake.systems.integer_fuzzy_ik_system import IntegerFuzzyIkStatus

RULES = {
    "paper's rules": Integer(),
    "9 x 9, product": Integer(labels=[9, 9], conjunction="product"),
}
"""What drives the arm: Table 1's shape of rules, and finer ones."""
LARGEST_STEP = 3.0
"""Claimed of a joint between neighbouring points, so that the motion is continuous [°]."""
LARGEST_LAG = 10.0
"""Claimed of the plant's tool behind the command [mm]: 5 mm each 20 ms with a lag of 20 ms make 5."""


def figure_7() -> Section:
    """Figures 7 and 8."""
    return _traced("figure 7", "rectangle every 5 mm, figures 7, 8", "integer_rectangle")


def figure_9() -> Section:
    """Figures 9 and 10."""
    return _traced("figure 9", "circle every 1°, figures 9, 10", "integer_circle")


def figure_11() -> Section:
    """Figures 11 and 12."""
    return _traced("figure 11", "inclined line, figures 11, 12", "integer_line")


@dataclass(frozen=True)
class Trace:
    """One run along a path: a row a point."""

    seconds: Array
    """When each was wanted (k,) [s]."""
    desired: Array
    """Points of the workplane (k,2) [mm]."""
    position: Array
    """Joints of the plant a period later (k,n) [rad]."""


def _traced(key: str, title: str, file: str) -> Section:
    inverse, scenario = tojo_inverse(), load_scenario(file)
    points = path(scenario)
    cells = [Cell("points", None, len(points))]
    traces = {}
    for name, controller in RULES.items():
        log = simulate(scenario.but(controller=controller))
        after = slice(1, len(points) + 1)  # what the cycle of each point led to
        run = traces[name] = Trace(log.time[: len(points)], points, log.q[after])
        command, status = log.command[after], log.status[after]
        distance, height = workplane_errors(inverse, points, command)
        lag = np.linalg.norm(inverse.reached(run.position) - inverse.reached(command), axis=-1)
        step = float(np.rad2deg(np.abs(np.diff(command, axis=0)).max()))
        inside = int((status == IntegerFuzzyIkStatus.INSIDE).sum())
        cells += [
            Cell(f"{name}: points with status INSIDE", None, inside, inside == len(points)),
            Cell(f"{name}: error of the command, max [mm]", None, float(distance.max())),
            Cell(f"{name}: error of the command, mean [mm]", None, float(distance.mean())),
            Cell(f"{name}: height over the workplane, max [mm]", None, float(np.abs(height).max())),
            Cell(
                f"{name}: largest step of a joint [°], at most {LARGEST_STEP:g}",
                None,
                step,
                step <= LARGEST_STEP,
            ),
            Cell(
                f"{name}: servos behind the command, max [mm], at most {LARGEST_LAG:g}",
                None,
                float(lag.max()),
                float(lag.max()) <= LARGEST_LAG,
            ),
        ]
    notes = [
        "The paper shows photographs and joint angles and gives no error. A point every "
        f"{1000 / scenario.control_rate:g} ms, the plant",
        f"of the arm with a PD servo a joint in the Diagram: `fikm-drake run {file}`.",
    ]
    pictures = {f"integer_{key}".replace(" ", "_"): _figure(traces, inverse)}
    return Section(key, title, cells, notes, pictures)


def _figure(traces: dict[str, Trace], inverse: WorkplaneInverse) -> Figure:
    figure = Figure(figsize=(11, 8), layout="constrained")
    for row, (name, run) in zip(figure.subplots(2, 2), traces.items()):
        _plot_from_above(row[0], run, inverse)
        row[0].set_title(f"{name}: from above", fontsize=10)
        for angles, joint in zip(np.rad2deg(run.position).T, TABLE_1):
            row[1].plot(run.seconds, angles, linewidth=1.2, label=joint)
        row[1].set_title(f"{name}: joints of the plant", fontsize=10)
        row[1].set_xlabel("time [s]")
        row[1].set_ylabel("joint position [°]")
        row[1].grid(alpha=0.3)
    row[1].legend(fontsize=8, ncols=2)
    return figure


def _plot_from_above(axes: Axes, run: Trace, inverse: WorkplaneInverse) -> None:
    """Wanted and reached path on the workplane, and the arm at eight moments [mm]."""
    for q in run.position[:: max(1, len(run.position) // 8)]:
        joints = inverse.chain.link_poses(q)[:, :3, 3]
        tool = inverse.chain.forward_kinematics(q)[:3, 3]
        x, y, _ = inverse.workplane.from_world(np.vstack([joints, tool])).T
        axes.plot(x, y, "o-", color="0.75", linewidth=1, markersize=3)
    axes.plot(*run.desired.T, "k--", linewidth=1, label="wanted")
    axes.plot(*inverse.reached(run.position)[:, :2].T, color="tab:blue", label="reached")
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.legend(fontsize=8, loc="lower right")


def path(scenario: Scenario) -> Array:
    """The points of the workplane (k,2) that a scenario's cycles are for [mm], without its hold."""
    count = round(scenario.target.duration * scenario.control_rate) + 1
    return tojo_inverse().workplane.from_world(scenario.targets()[:count])[:, :2]
