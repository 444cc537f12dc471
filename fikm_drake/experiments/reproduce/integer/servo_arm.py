"""The arm with servos, driven by `IntegerFuzzyIkSystem` in a Diagram."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    LogVectorOutput,
    Multiplexer,
    TrajectorySource,
)
from pydrake.trajectories import PiecewisePolynomial

from fikm_drake.arrays import Array
from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk
from fikm_drake.solvers.workplane.workplane_inverse import WorkplaneInverse
from fikm_drake.systems.integer_fuzzy_ik_system import IntegerFuzzyIkSystem

PERIOD = 0.02
"""One point of the path each [s]: the frame of a hobby servo."""
TIME_STEP = 0.001
"""Time step of the plant [s]."""
SERVO = PdControllerGains(p=1000.0, d=20.0)
"""Gains of each joint [N m/rad], [N m s/rad]: stiff; behind a moving command by d / p = 20 ms."""


@dataclass(frozen=True)
class Trace:
    """One run along a path: a row a period."""

    desired: Array
    """Points of the workplane (k,2) [mm]."""
    command: Array
    """Joint commands (k,n) [rad]."""
    status: NDArray[np.int64]
    """`IntegerFuzzyIkStatus` (k)."""
    position: Array
    """Joints of the plant at the end of the period (k,n) [rad]."""


def trace(ik: IntegerFuzzyIk, inverse: WorkplaneInverse, points: Array) -> Trace:
    """Drive the arm along points (k,2) [mm] of the workplane, from rest at the first one."""
    count = len(points)
    times = PERIOD * (np.arange(count + 1) - 0.5)  # rounding cannot lose or add a point
    held = inverse.workplane.to_world(np.concatenate([points, points[-1:]]))
    builder = DiagramBuilder()
    desired = builder.AddNamedSystem(
        "desired", TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, held.T))
    )
    block = builder.AddNamedSystem("ik", IntegerFuzzyIkSystem(ik, inverse.workplane, period=PERIOD))
    plant = builder.AddSystem(MultibodyPlant(TIME_STEP))
    instance = AddDhArm(plant, inverse.arm)
    for index in plant.GetJointActuatorIndices():
        plant.get_joint_actuator(index).set_controller_gains(SERVO)
    plant.Finalize()
    start = inverse(points[0])
    n = ik.num_joints
    rest = builder.AddNamedSystem("rest", ConstantVectorSource(np.zeros(n)))
    state = builder.AddNamedSystem("servo_target", Multiplexer([n, n]))
    builder.Connect(desired.get_output_port(), block.GetInputPort("desired_position"))
    builder.Connect(block.GetOutputPort("commanded_position"), state.get_input_port(0))
    builder.Connect(rest.get_output_port(), state.get_input_port(1))
    builder.Connect(state.get_output_port(), plant.get_desired_state_input_port(instance))
    ports = {
        "command": block.GetOutputPort("commanded_position"),
        "status": block.GetOutputPort("status"),
        "state": plant.get_state_output_port(instance),
    }
    sinks = {name: LogVectorOutput(port, builder, PERIOD) for name, port in ports.items()}
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    plant.SetPositions(plant.GetMyMutableContextFromRoot(root), instance, start)
    block.SetPositions(block.GetMyMutableContextFromRoot(root), start)
    simulator.AdvanceTo((count + 0.5) * PERIOD)
    # Drake publishes before it updates: what point k led to is in sample k + 1.
    logs = {name: sink.FindLog(root).data()[:, 1 : count + 1].T for name, sink in sinks.items()}
    return Trace(
        points,
        logs["command"].copy(),
        logs["status"][:, 0].astype(np.int64),
        logs["state"][:, :n].copy(),
    )
