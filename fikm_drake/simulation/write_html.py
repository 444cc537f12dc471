"""A page on which a run can be watched."""

from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, Rgba
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.files import write_whole
from fikm_drake.simulation.run_log import RunLog

FRAMES_PER_SECOND = 50.0


def write_html(log: RunLog, path: str | Path, *, meshcat: Meshcat | None = None) -> None:
    """Write a self-contained Meshcat page that plays a run: the arm, the target path and its own.

    Args:
        log: the run.
        path: the .html file to write.
        meshcat: draw with this one, which stays open; None: with one of our own for the moment.

    Raises:
        OSError: the file cannot be written.
        RuntimeError: Meshcat finds no free port.
    """
    meshcat = meshcat or Meshcat()
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    robot = log.scenario.load_robot()
    robot.add(plant)
    for i, obstacle in enumerate(log.scenario.obstacles, start=1):
        obstacle.add(plant, f"obstacle{i}")
    plant.Finalize()
    chain = robot.chain(plant)
    visualizer = MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)

    desired, actual = (_in_space(series) for series in (log.desired, log.actual))
    meshcat.SetLine("path/desired", desired.T, 3.0, Rgba(0.1, 0.1, 0.1))
    meshcat.SetLine("path/actual", actual.T, 3.0, Rgba(0.12, 0.47, 0.71))
    _look_at(meshcat, np.concatenate([desired, actual, np.zeros((1, 3))]))

    visualizer.StartRecording(False)
    stride = max(1, round(log.scenario.control_rate / FRAMES_PER_SECOND))
    for k in [*range(0, len(log.time) - 1, stride), len(log.time) - 1]:
        context.SetTime(log.time[k])
        q = chain.to_full(log.q[k], plant.GetPositions(plant_context))
        plant.SetPositions(plant_context, q)
        visualizer.ForcedPublish(visualizer.GetMyContextFromRoot(context))
    visualizer.PublishRecording()
    write_whole(path, meshcat.StaticHtml())


def _in_space(points: np.ndarray) -> np.ndarray:
    """Positions (N,3) of targets: pairs lie in the plane z = 0, poses have theirs last."""
    if points.shape[1] > 2:
        return points[:, -3:]
    return np.pad(points, ((0, 0), (0, 1)))


def _look_at(meshcat: Meshcat, points: np.ndarray) -> None:
    """Put the camera where it sees all the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    centre, size = (low + high) / 2, max(float(np.linalg.norm(high - low)), 0.5)
    meshcat.SetCameraPose(centre + size * np.array([0.6, -0.7, 0.5]), centre)
