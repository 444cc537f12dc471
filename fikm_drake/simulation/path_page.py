"""A page on which a joint path can be watched."""

from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, Rgba
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.files import write_whole
from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.robot_file import AddRobot
from fikm_drake.solvers.paths.joint_path import JointPath

FRAMES_PER_SECOND = 50.0
SECONDS = 5.0
"""A path without times plays this long [s]."""
DESIRED, ACTUAL = Rgba(0.1, 0.1, 0.1), Rgba(0.12, 0.47, 0.71)


def write_path_html(
    joint_path: JointPath,
    robot: str | Path | DhArm,
    path: str | Path,
    *,
    meshcat: Meshcat | None = None,
) -> None:
    """Write a self-contained Meshcat page that plays a joint path: the arm, its targets and its way.

    A path that was followed throughout plays as fast as the limits allow, another one row by row.

    Args:
        joint_path: what to play.
        robot: what the path's chain was made of: a model's file, or an arm.
        path: the .html file to write.
        meshcat: draw with this one, which stays open; None: with one of our own for the moment.

    Raises:
        OSError: the file cannot be written.
        RuntimeError: Meshcat finds no free port.
    """
    meshcat = meshcat or Meshcat()
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    if isinstance(robot, DhArm):
        AddDhArm(plant, robot)
    else:
        AddRobot(plant, robot)
    plant.Finalize()
    visualizer = MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    chain = joint_path.chain

    targets = joint_path.targets if joint_path.targets.ndim == 2 else joint_path.targets[:, :3, 3]
    targets = targets[np.isfinite(targets).all(axis=1)]
    q, times = _frames(joint_path)
    way = chain.forward_kinematics(q)[:, :3, 3]
    for name, points, colour in (("targets", targets, DESIRED), ("way", way, ACTUAL)):
        if len(points) > 1:
            meshcat.SetLine(f"path/{name}", np.ascontiguousarray(points.T), 3.0, colour)
    seen = np.concatenate([targets, way, np.zeros((1, 3))])
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = max(float(np.linalg.norm(high - low)), 0.5)
    meshcat.SetCameraPose((low + high) / 2 + size * np.array([0.7, -0.8, 0.5]), (low + high) / 2)

    visualizer.StartRecording(False)
    full = plant.GetPositions(plant_context)
    for row, t in zip(q, times):
        context.SetTime(t)
        plant.SetPositions(
            plant_context, row if chain.position_indices is None else chain.to_full(row, full)
        )
        visualizer.ForcedPublish(visualizer.GetMyContextFromRoot(context))
    visualizer.PublishRecording()
    write_whole(path, meshcat.StaticHtml())


def _frames(path: JointPath) -> tuple[np.ndarray, np.ndarray]:
    """Joint positions of the page's frames and their times [s]."""
    if not path.success or np.ptp(path.q, axis=0).max() == 0.0:
        return path.q, np.linspace(0.0, SECONDS, len(path))
    trajectory = path.trajectory()
    end = trajectory.end_time()
    times = np.linspace(0.0, end, max(2, round(end * FRAMES_PER_SECOND)))
    return trajectory.vector_values(times).T, times
