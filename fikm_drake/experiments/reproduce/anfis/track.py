"""A Diagram that takes the thesis's arm along a trajectory by `RedundancyIk`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.systems.rendering import MultibodyPositionToGeometryPose
from pydrake.trajectories import PiecewisePolynomial

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.region import Trajectory
from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.systems.redundancy_ik import RedundancyIk

DURATION, PERIOD = 10.0, 0.02
"""Duration of a run, and of its control cycle [s]."""


@dataclass(frozen=True)
class Track:
    """A run's log, a row a control cycle."""

    desired: Array
    """(N,2) [m]."""
    actual: Array
    """(N,2) position of the tool by the plant [m]."""
    q: Array
    """(N,3) commanded [rad]."""
    bounds: Array
    """(N,2) of joint 1 [rad]."""
    status: NDArray[np.int_]
    """(N,): `ResolutionStatus`."""


def track(resolver: RedundancyResolver, trajectory: Trajectory) -> Track:
    """Run a Diagram: trajectory, `RedundancyIk`, the arm's plant in a scene, a log of every port."""
    builder = DiagramBuilder()
    times = np.linspace(0.0, DURATION, len(trajectory.corners))
    path = PiecewisePolynomial.FirstOrderHold(times, np.transpose(trajectory.corners))
    desired = builder.AddNamedSystem("desired", TrajectorySource(path))
    ik = builder.AddNamedSystem("ik", RedundancyIk(resolver, period=PERIOD))
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant = MultibodyPlant(time_step=0.0)
    source = plant.RegisterAsSourceForSceneGraph(scene_graph)
    assert isinstance(resolver.arm, DhArm)
    AddDhArm(plant, resolver.arm)
    plant.Finalize()
    poses = builder.AddNamedSystem("poses", MultibodyPositionToGeometryPose(plant))
    position = ik.GetOutputPort("commanded_position")
    builder.Connect(desired.get_output_port(), ik.GetInputPort("desired_position"))
    builder.Connect(position, poses.get_input_port())
    builder.Connect(poses.get_output_port(), scene_graph.get_source_pose_port(source))
    ports = [desired.get_output_port(), position, *map(ik.GetOutputPort, ("bounds", "status"))]
    sinks = [LogVectorOutput(port, builder, PERIOD) for port in ports]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(DURATION + 0.5 * PERIOD)

    targets, q, bounds, status = (
        sink.FindLog(simulator.get_context()).data().T.copy() for sink in sinks
    )
    # A sample is of the time before its update: what a target led to is in the next one.
    q = q[1:]
    actual = _tool_positions(plant, q)
    return Track(targets[:-1], actual, q, bounds[1:], status[1:, 0].astype(int))


def _tool_positions(plant: MultibodyPlant, q: Array) -> Array:
    """Positions (N,2) of the tool [m] by Drake's kinematics."""
    context, tool = plant.CreateDefaultContext(), plant.GetFrameByName("tool")
    positions = np.empty((len(q), 2))
    for i, row in enumerate(q):
        plant.SetPositions(context, row)
        positions[i] = tool.CalcPoseInWorld(context).translation()[:2]
    return positions
