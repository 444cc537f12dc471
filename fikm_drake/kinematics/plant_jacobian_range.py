"""Bounds of a tool's Jacobian for any arm in a MultibodyPlant."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint

from fikm_drake.arrays import Array


def plant_jacobian_range(plant: MultibodyPlant, frame: str | Frame = "tool") -> Array:
    """Bounds of |J_ij| of a frame's origin over all joint positions, in the world frame.

    A joint turns the tool about its axis at most as fast as the lengths from joint to joint add up
    to. `DhArm.jacobian_range` is tighter: it knows the twists. This one needs only the plant.

    Args:
        plant: a finalized plant; joints on the way from the frame to the world have at most one
            degree of freedom.
        frame: the frame, or its name.

    Returns:
        (6,n), rows [ω; v]; zero in the columns of joints that do not move the frame, infinite
        below a prismatic joint without limits.

    Raises:
        ValueError: a joint on the way has more than one degree of freedom.
    """
    inboard = {int(joint.child_body().index()): joint for joint in _joints(plant)}
    tool = plant.GetFrameByName(frame) if isinstance(frame, str) else frame
    body, point = tool.body(), tool.GetFixedPoseInBodyFrame().translation()
    bound = np.zeros((6, plant.num_velocities()))
    reach = 0.0  # largest distance from `point`, fixed in `body`, to the tool
    while int(body.index()) in inboard:
        joint = inboard[int(body.index())]
        origin = joint.frame_on_child().GetFixedPoseInBodyFrame().translation()
        reach += float(np.linalg.norm(point - origin))
        if joint.num_velocities() > 1:
            raise ValueError(f"joint {joint.name()!r} must have at most one degree of freedom")
        if joint.num_velocities() == 1:
            column = joint.velocity_start()
            turns = joint.type_name() == "revolute"
            bound[:3, column] = 1.0 if turns else 0.0
            bound[3:, column] = reach if turns else 1.0
            if not turns:
                limits = [joint.position_lower_limits()[0], joint.position_upper_limits()[0]]
                reach += float(np.max(np.abs(limits)))
        body = joint.parent_body()
        point = joint.frame_on_parent().GetFixedPoseInBodyFrame().translation()
    return bound


def _joints(plant: MultibodyPlant) -> list[Joint]:
    return [plant.get_joint(index) for index in plant.GetJointIndices()]
