"""Other differential IK for poses, in the loop as its users set it up."""

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsController,
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
)
from pydrake.systems.analysis import Simulator

from fikm_drake.arrays import Array
from fikm_drake.diagrams.drake_differential_ik import (
    desired_pose,
    drake_differential_ik,
)
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.dh_arm import DhArm

Run = Callable[[RigidTransform, float], Array]
"""A desired pose and seconds to the joint positions (N,n) after each cycle, from the start."""


def pose_peers(arm: DhArm, start: Array, rate: float) -> dict[str, Run]:
    """Drake's two systems and, where it is installed, Pink; all inside position and speed limits.

    Args:
        arm: an arm with limits of all positions and speeds.
        start: joint positions (n,) [rad or m].
        rate: cycles a second [Hz].
    """
    peers = {
        "Drake DifferentialInverseKinematicsController": _drake_controller(arm, start, rate),
        "Drake DifferentialInverseKinematicsIntegrator": _drake_integrator(arm, start, rate),
    }
    return peers | ({"Pink": _pink(arm, start, rate)} if find_spec("pink") else {})


def _drake_controller(arm: DhArm, start: Array, rate: float) -> Run:
    system = DifferentialInverseKinematicsController(
        drake_differential_ik(arm, period=1.0 / rate), []
    )

    def run(desired: RigidTransform, seconds: float) -> Array:
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        system.set_initial_position(context, start)
        system.GetInputPort("estimated_state").FixValue(context, np.zeros(2 * arm.num_joints))
        system.GetInputPort("nominal_posture").FixValue(context, start)
        system.GetInputPort("desired_poses").FixValue(context, desired_pose(arm, desired))
        return advance(simulator, "commanded_position", seconds, rate)

    return run


def _drake_integrator(arm: DhArm, start: Array, rate: float) -> Run:
    plant = MakeDhArmPlant(arm)
    n = arm.num_joints
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(1.0 / rate)
    parameters.set_nominal_joint_position(start)
    parameters.set_joint_position_limits((arm.lower, arm.upper))
    parameters.set_joint_velocity_limits((-arm.velocity_limits, arm.velocity_limits))
    system = DifferentialInverseKinematicsIntegrator(
        plant, plant.GetFrameByName("tool"), 1.0 / rate, parameters
    )

    def run(desired: RigidTransform, seconds: float) -> Array:
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        system.SetPositions(context, start)
        system.GetInputPort("X_AE_desired").FixValue(context, Value(desired))
        return advance(simulator, "joint_positions", seconds, rate)

    return run


def _pink(arm: DhArm, start: Array, rate: float) -> Run:
    """Pink's usual set-up: a frame task and a weak posture task."""
    pink, pinocchio = import_module("pink"), import_module("pinocchio")
    tasks = import_module("pink.tasks")
    model = pinocchio.buildModelFromXML(arm.to_urdf())
    data = model.createData()

    def run(desired: RigidTransform, seconds: float) -> Array:
        configuration = pink.Configuration(model, data, np.array(start))
        frame = tasks.FrameTask("tool", position_cost=1.0, orientation_cost=1.0, lm_damping=1.0)
        frame.set_target(
            pinocchio.SE3(desired.rotation().matrix(), np.array(desired.translation()))
        )
        posture = tasks.PostureTask(cost=1e-3)
        posture.set_target_from_configuration(configuration)
        positions = []
        for _ in range(round(seconds * rate)):
            velocity = pink.solve_ik(
                configuration, [frame, posture], 1.0 / rate, solver="quadprog", safety_break=False
            )
            configuration.integrate_inplace(velocity, 1.0 / rate)
            positions.append(configuration.q.copy())
        return np.array(positions)

    return run


def advance(simulator: Simulator, port: str, seconds: float, rate: float) -> Array:
    """Values (N,n) of an output after each cycle."""
    output = simulator.get_system().GetOutputPort(port)
    context = simulator.get_mutable_context()
    values = []
    for k in range(round(seconds * rate)):
        simulator.AdvanceTo((k + 0.5) / rate)
        values.append(output.Eval(context))
    return np.array(values)
