"""Drake's differential IK for one of our arms, as its users set it up."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import DifferentialInverseKinematicsSystem
from pydrake.multibody.math import SpatialVelocity
from pydrake.planning import (
    CollisionCheckerParams,
    DofMask,
    JointLimits,
    RobotDiagramBuilder,
    SceneGraphCollisionChecker,
)
from pydrake.systems.framework import BusValue

from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.dh_arm import DhArm

COST_WEIGHT = 100.0
"""Weight of the least-squares cost."""
INFLUENCE = 0.1
"""Distance from a joint limit at which its velocity limit starts to shrink [rad]."""
TOOL_LIMITS = (1.0, 1.0)
"""Largest angular and linear velocity that is asked of the tool, each axis [rad/s, m/s]."""
ACCELERATION = 1e9
"""Acceleration of the joints [rad/s²]; Drake wants a number and uses none."""


def drake_differential_ik(arm: DhArm, *, period: float) -> DifferentialInverseKinematicsSystem:
    """Drake's `DifferentialInverseKinematicsSystem` for the tool of `arm`.

    Least squares of the tool's velocity inside the joints' position and velocity limits; the
    collision checker, which it must have, has nothing to check.

    Args:
        arm: an arm with limits of all positions and speeds.
        period: of the control cycle [s].
    """
    robot = RobotDiagramBuilder(time_step=0.0)
    instance = AddDhArm(robot.plant(), arm, capsules=False)
    robot.plant().Finalize()
    checker = SceneGraphCollisionChecker(
        CollisionCheckerParams(
            model=robot.Build(), robot_model_instances=[instance], edge_step_size=0.05
        )
    )
    n = arm.num_joints
    System = DifferentialInverseKinematicsSystem
    recipe = System.Recipe()
    cost = System.LeastSquaresCost.Config(cartesian_qp_weight=COST_WEIGHT)
    recipe.AddIngredient(System.LeastSquaresCost(cost))
    acceleration = np.full(n, ACCELERATION)
    limits = JointLimits(
        arm.lower, arm.upper, -arm.velocity_limits, arm.velocity_limits, -acceleration, acceleration
    )
    margins = System.JointVelocityLimitConstraint.Config(min_margin=0.0, influence_margin=INFLUENCE)
    recipe.AddIngredient(System.JointVelocityLimitConstraint(margins, limits))
    return System(
        recipe=recipe,
        task_frame="world",
        collision_checker=checker,
        active_dof=DofMask(n, True),
        time_step=period,
        K_VX=1.0,
        Vd_TG_limit=SpatialVelocity(np.repeat(TOOL_LIMITS, 3)),
    )


def desired_pose(arm: DhArm, X_WE: RigidTransform) -> Value:
    """What the system's port for poses takes: the tool's name and where it shall be."""
    bus = BusValue()
    bus.Set(f"{arm.name}::tool", Value(X_WE))
    return Value(bus)
