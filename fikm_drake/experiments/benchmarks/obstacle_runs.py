"""A scene run by ours and by Drake's differential IK, with one checker and the same distances."""

import time
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsController,
    DifferentialInverseKinematicsSystem,
)
from pydrake.multibody.math import SpatialVelocity
from pydrake.planning import CollisionChecker, DofMask, JointLimits
from pydrake.systems.framework import BusValue, Context, System

from fikm_drake.arrays import Array
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.add_fuzzy_ik_controller import MakeFuzzyIkController
from fikm_drake.experiments.benchmarks.obstacle_scenes import ObstacleScene
from fikm_drake.experiments.benchmarks.obstacle_settings import DrakeSettings
from fikm_drake.experiments.benchmarks.pose_checks import as_pose
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping


def run_ours(
    scene: ObstacleScene,
    checker: CollisionChecker | None,
    *,
    rate: float,
    seconds: float,
    clearance: ClearanceConfig,
    restart_search: bool,
) -> tuple[Array, Array]:
    """Commands (N,n) of the fused controller and the CPU time of each cycle (N,) [s].

    Without a checker it does not see obstacles.
    """
    rows = 3 if scene.task == "position" else 6
    law = FuzzyMapping(iterations=3)
    if rows == 6:
        law = FuzzyMapping.iterated()
    config = FuzzyIkConfig(
        law=law,
        task=scene.task,
        control_rate=rate,
        fused=True,
        clearance=clearance,
        restart_search=restart_search,
    )
    plant = MakeDhArmPlant(load_arm(scene.arm))
    controller = MakeFuzzyIkController(plant, config=config, collision_checker=checker)
    context = controller.CreateDefaultContext()
    controller.SetPositions(context, scene.start)
    target = scene.target[:3, 3] if rows == 3 else Value(as_pose(scene.target))
    controller.get_input_port(0).FixValue(context, target)
    return _cycles(
        controller, context, controller.GetOutputPort("commanded_position"), rate, seconds
    )


def run_drake(
    scene: ObstacleScene,
    checker: CollisionChecker,
    *,
    rate: float,
    seconds: float,
    clearance: ClearanceConfig,
    settings: DrakeSettings,
) -> tuple[Array, Array]:
    """The same of Drake's `DifferentialInverseKinematicsController`."""
    arm = load_arm(scene.arm)
    n, tool = arm.num_joints, f"{arm.name}::tool"
    kind: Any = DifferentialInverseKinematicsSystem
    recipe = kind.Recipe()
    mask = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]) if scene.task == "position" else np.ones(6)
    cost = kind.LeastSquaresCost.Config(
        cartesian_qp_weight=settings.weight, cartesian_axis_masks={tool: mask}
    )
    recipe.AddIngredient(kind.LeastSquaresCost(cost))
    if settings.posture_gain:
        centre = kind.JointCenteringCost.Config(
            posture_gain=settings.posture_gain, cartesian_axis_masks={tool: mask}
        )
        recipe.AddIngredient(kind.JointCenteringCost(centre))
    limits = JointLimits(
        arm.lower,
        arm.upper,
        -arm.velocity_limits,
        arm.velocity_limits,
        -np.full(n, 1e9),
        np.full(n, 1e9),
    )
    margins = kind.JointVelocityLimitConstraint.Config(min_margin=0.0, influence_margin=0.1)
    recipe.AddIngredient(kind.JointVelocityLimitConstraint(margins, limits))
    safe = kind.CollisionConstraint.Config(
        safety_distance=clearance.safe_distance, influence_distance=clearance.influence_distance
    )
    recipe.AddIngredient(kind.CollisionConstraint(safe))
    plant = checker.plant()
    active = np.zeros(plant.num_positions(), dtype=bool)
    robot = plant.GetModelInstanceByName(arm.name)
    for joint in plant.GetJointIndices(robot):
        if plant.get_joint(joint).num_positions() == 1:
            active[plant.get_joint(joint).position_start()] = True
    system = DifferentialInverseKinematicsController(
        kind(
            recipe=recipe,
            task_frame="world",
            collision_checker=checker,
            active_dof=DofMask(active.tolist()),
            time_step=1.0 / rate,
            K_VX=settings.gain,
            Vd_TG_limit=SpatialVelocity(np.full(6, settings.speed)),
        ),
        [],
    )
    context = system.CreateDefaultContext()
    everything = plant.GetPositions(plant.CreateDefaultContext())
    everything[active] = scene.start
    system.set_initial_position(context, everything)
    state = np.concatenate([everything, np.zeros(plant.num_velocities())])
    system.GetInputPort("estimated_state").FixValue(context, state)
    posture = system.GetInputPort("nominal_posture")
    posture.FixValue(context, scene.start if posture.size() == n else everything)
    bus = BusValue()
    bus.Set(tool, Value(as_pose(scene.target)))
    system.GetInputPort("desired_poses").FixValue(context, Value(bus))
    return _cycles(system, context, system.GetOutputPort("commanded_position"), rate, seconds)


def _cycles(
    system: System, context: Context, port: Any, rate: float, seconds: float
) -> tuple[Array, Array]:
    positions, times = [], []
    for _ in range(round(rate * seconds)):
        begin = time.process_time()
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
        times.append(time.process_time() - begin)
        positions.append(port.Eval(context).copy())
    return np.array(positions), np.array(times)
