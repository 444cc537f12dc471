"""What others reach with a chain from the same start: Drake's integrator, Pink, SNOPT."""

import dataclasses
from collections.abc import Callable
from importlib import import_module

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
    InverseKinematics,
)
from pydrake.solvers import SnoptSolver
from pydrake.systems.analysis import Simulator

from fikm_drake.arrays import Array
from fikm_drake.experiments.reach_targets import MET
from fikm_drake.kinematics.add_dh_arm import MakeChainPlant
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.urdf import urdf

Run = Callable[[RigidTransform], Array]
"""A desired pose to the joint positions (n,) at the end, from the start."""


def drakes_integrator(chain: SerialChain, start: Array, *, rate: float, seconds: float) -> Run:
    """Drake's integrator of differential IK, for poses."""
    plant, n = MakeChainPlant(chain), chain.num_joints
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(1.0 / rate)
    parameters.set_nominal_joint_position(start)
    parameters.set_joint_position_limits((chain.lower, chain.upper))
    parameters.set_joint_velocity_limits((-chain.velocity_limits, chain.velocity_limits))
    tool = plant.GetFrameByName("tool")
    system = DifferentialInverseKinematicsIntegrator(plant, tool, 1.0 / rate, parameters)

    def run(target: RigidTransform) -> Array:
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        system.SetPositions(context, start)
        system.GetInputPort("X_AE_desired").FixValue(context, Value(target))
        simulator.AdvanceTo(seconds)
        return np.array(system.GetOutputPort("joint_positions").Eval(context))

    return run


def pinks(chain: SerialChain, start: Array, *, rate: float, seconds: float, pose: bool) -> Run:
    """Pink's usual set-up: a frame task, of position alone or of the pose, and a weak posture task."""
    pink, pinocchio = import_module("pink"), import_module("pinocchio")
    tasks = import_module("pink.tasks")
    names = tuple(f"joint{i}" for i in range(1, chain.num_joints + 1))
    plain = dataclasses.replace(chain, name="chain", joint_names=names)
    model = pinocchio.buildModelFromXML(urdf(plain, capsules=False))
    data = model.createData()
    turns = 1.0 if pose else 0.0

    def run(target: RigidTransform) -> Array:
        configuration = pink.Configuration(model, data, np.array(start))
        frame = tasks.FrameTask("tool", position_cost=1.0, orientation_cost=turns, lm_damping=1.0)
        point = np.array(target.translation())
        frame.set_target(pinocchio.SE3(target.rotation().matrix(), point))
        posture = tasks.PostureTask(cost=1e-3)
        posture.set_target_from_configuration(configuration)
        for _ in range(round(rate * seconds)):
            velocity = pink.solve_ik(
                configuration, [frame, posture], 1.0 / rate, solver="quadprog", safety_break=False
            )
            configuration.integrate_inplace(velocity, 1.0 / rate)
        return np.array(configuration.q)

    return run


def snopts(chain: SerialChain, start: Array, *, pose: bool) -> Run:
    """Drake's `InverseKinematics` by SNOPT, from the start as its guess: a local optimiser of positions.

    It is bound to no speed and no time and may go through anything, so what it reaches tells how
    much a method can that looks around itself only.
    """
    plant = MakeChainPlant(chain)
    tool, world = plant.GetFrameByName("tool"), plant.world_frame()

    def run(target: RigidTransform) -> Array:
        ik = InverseKinematics(plant)
        p, slack = target.translation(), 0.5 * MET[0]
        ik.AddPositionConstraint(tool, np.zeros(3), world, p - slack, p + slack)
        if pose:
            ik.AddOrientationConstraint(
                world, target.rotation(), tool, RotationMatrix(), 0.5 * MET[1]
            )
        result = SnoptSolver().Solve(ik.prog(), start, None)
        q = np.array(result.GetSolution(ik.q()))
        return np.clip(q, chain.lower, chain.upper)

    return run
