"""A page on which a run can be watched."""

from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, Rgba
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.files import write_whole
from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.task import Task
from fikm_drake.simulation.tracking_log import TrackingLog

FRAMES_PER_SECOND = 50.0


def write_html(log: TrackingLog, path: str | Path, *, meshcat: Meshcat | None = None) -> None:
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
    AddDhArm(plant, log.scenario.load_arm())
    plant.Finalize()
    visualizer = MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)

    desired, actual = (_in_space(log, series) for series in (log.desired, log.actual))
    meshcat.SetLine("path/desired", desired.T, 3.0, Rgba(0.1, 0.1, 0.1))
    meshcat.SetLine("path/actual", actual.T, 3.0, Rgba(0.12, 0.47, 0.71))
    _look_at(meshcat, np.concatenate([desired, actual, np.zeros((1, 3))]))

    visualizer.StartRecording(False)
    stride = max(1, round(log.scenario.control_rate / FRAMES_PER_SECOND))
    for k in [*range(0, len(log.time) - 1, stride), len(log.time) - 1]:
        context.SetTime(log.time[k])
        plant.SetPositions(plant_context, log.q[k])
        visualizer.ForcedPublish(visualizer.GetMyContextFromRoot(context))
    visualizer.PublishRecording()
    write_whole(path, meshcat.StaticHtml())


def _in_space(log: TrackingLog, points: np.ndarray) -> np.ndarray:
    """Points (N,3) of task coordinates (N,m), those that do not count zero."""
    space = np.zeros((len(points), 3))
    space[:, Task(log.scenario.controller_config().task).coordinates] = points
    return space


def _look_at(meshcat: Meshcat, points: np.ndarray) -> None:
    """Put the camera where it sees all the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    centre, size = (low + high) / 2, max(float(np.linalg.norm(high - low)), 0.5)
    meshcat.SetCameraPose(centre + size * np.array([0.6, -0.7, 0.5]), centre)
