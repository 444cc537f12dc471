"""A page on which a run can be watched, with its curves beside the robot."""

import html
import json
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, Rgba
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.arrays import Array
from fikm_drake.files import write_whole
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario.surroundings import add_world

FRAMES_PER_SECOND = 50.0
MOST_ROWS = 2000
"""Most rows of a curve on the page; a longer log is thinned out."""
PANEL = Path(__file__).with_name("run_page.html")
"""What stands beside the robot: style, controls, curves."""


def write_html(log: RunLog, path: str | Path, *, meshcat: Meshcat | None = None) -> None:
    """Write a self-contained page that plays a run.

    At the left the robot with its obstacles, the target's path and the tool's own; at the right error,
    gain, joints and status over time. One slider moves both; a click into a curve goes there.

    Args:
        log: a scenario's run.
        path: the .html file to write.
        meshcat: draw with this one, which stays open; None: with one of our own for the moment.

    Raises:
        OSError: the file cannot be written.
        RuntimeError: Meshcat finds no free port.
        ValueError: the log has no scenario, or no row with finite joints.
    """
    scenario = log.scenario
    meshcat = meshcat or Meshcat()
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    robot = scenario.load_robot()
    add_world(plant, robot, scenario.obstacles)
    plant.Finalize()
    chain = robot.chain(plant)
    visualizer = MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)

    shown = np.flatnonzero(np.isfinite(log.q).all(axis=1))
    if not shown.size:
        raise ValueError("the log has no row with finite joints to show")
    series = (log.desired, log.actual)
    desired, actual = (_in_space(s[np.isfinite(s).all(axis=1)]) for s in series)
    corners = _in_space(scenario.corners)
    meshcat.SetLine("path/desired", corners.T, 3.0, Rgba(0.1, 0.1, 0.1))
    if len(actual):
        meshcat.SetLine("path/actual", actual.T, 3.0, Rgba(0.12, 0.47, 0.71))
    _look_at(meshcat, np.concatenate([desired, actual, np.zeros((1, 3))]))

    visualizer.StartRecording(False)
    stride = max(1, round(scenario.control_rate / FRAMES_PER_SECOND))
    for k in [*shown[:-1:stride], shown[-1]]:  # rows of a robot that is nowhere are passed over
        context.SetTime(log.time[k])
        q = chain.to_full(log.q[k], plant.GetPositions(plant_context))
        plant.SetPositions(plant_context, q)
        visualizer.ForcedPublish(visualizer.GetMyContextFromRoot(context))
    visualizer.PublishRecording()
    write_whole(path, _with_panel(meshcat.StaticHtml(), log))


def _with_panel(page: str, log: RunLog) -> str:
    """Drake's page with our panel and the log's numbers in it."""
    scenario = log.scenario
    name = f"{scenario.load_robot().name}, {type(scenario.controller_options()).__name__}"
    title = f"{name}, {scenario.control_rate:g} Hz"
    data = {
        "title": title,
        "figures": str(log.metrics()),
        "time": _thin(log.time),
        "status": _stretches(log),
        "plots": _plots(log),
    }
    text = json.dumps(data, allow_nan=False).replace("</", "<\\/")
    panel = PANEL.read_text("utf-8").replace("/*RUN*/null", text)
    head = f"<title>{html.escape(title)}</title>"
    page = page.replace("<title>Drake MeshCat</title>", head, 1)
    before, body, after = page.rpartition("</body>")
    return before + panel + body + after


def _plots(log: RunLog) -> list[dict]:
    """The curves: label, a list of numbers each, and whether the axis begins at zero."""
    error = log.error_after
    length = 1000 * np.linalg.norm(error[:, -3:], axis=1)
    plots = [_plot("error [mm]", length[:, None], zero=True)]
    if error.shape[1] == 6:
        turn = np.rad2deg(np.linalg.norm(error[:, :3], axis=1))
        plots.append(_plot("turned off [°]", turn[:, None], zero=True))
    turns = all(label.endswith("_rad") for label in log.info.columns["q"])
    if "gain" in log:
        plots.append(_plot("gain K [-]", log["gain"], zero=True))
    if "clearance" in log:
        plots.append(_plot("clearance [mm]", 1000 * log["clearance"], zero=True))
    if "torque" in log:
        plots.append(_plot(f"torques [{'N m' if turns else 'N m or N'}]", log.torque))
    names = [f"q{i}" for i in range(1, log.q.shape[1] + 1)]
    plots.append(_plot(f"joints [{'rad' if turns else 'rad or m'}]", log.q, names=names))
    return plots


def _plot(label: str, series: Array, *, zero: bool = False, names: list[str] | None = None) -> dict:
    return {
        "label": label,
        "series": [_thin(column) for column in series.T],
        "zero": zero,
        "names": names,
    }


def _thin(values: Array) -> list[float | None]:
    """At most `MOST_ROWS` of the values, the last among them; what is not finite is None."""
    stride = -(-len(values) // MOST_ROWS)
    rows = values[: len(values) - 1 : stride].tolist() + [float(values[-1])]
    return [float(f"{v:.6g}") if np.isfinite(v) else None for v in rows]


def _stretches(log: RunLog) -> list[tuple[str, float, float]]:
    """Each stretch of one status: its name, from and to [s]."""
    if "status" not in log:
        return []
    names = log.status_names
    starts = [k for k in range(len(names)) if k == 0 or names[k] != names[k - 1]]
    ends = [*starts[1:], len(names) - 1]
    return [(names[a], float(log.time[a]), float(log.time[b])) for a, b in zip(starts, ends)]


def _in_space(points: Array) -> Array:
    """Positions (N,3) of targets: pairs lie in the plane z = 0, poses have theirs last."""
    if points.shape[1] > 2:
        return points[:, -3:]
    return np.pad(points, ((0, 0), (0, 1)))


def _look_at(meshcat: Meshcat, points: Array) -> None:
    """Put the camera where it sees all the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    centre, size = (low + high) / 2, max(float(np.linalg.norm(high - low)), 0.5)
    meshcat.SetCameraPose(centre + size * np.array([0.6, -0.7, 0.5]), centre)
