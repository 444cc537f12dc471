"""Joints of an arm in the plant of a collision checker, and how far each moves the arm's points."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import CalcObb, Obb
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, JointIndex
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array


def scoped_joint_name(joint: Joint, plant: MultibodyPlant) -> str:
    """`instance::joint`."""
    return f"{plant.GetModelInstanceName(joint.model_instance())}::{joint.name()}"


def arm_joint_names(plant: MultibodyPlant, positions: Iterable[int] | None = None) -> list[str]:
    """Scoped names of the joints of a plant's positions, by default of all (n,).

    Raises:
        ValueError: a position is not that of a joint with one.
    """
    joints = [plant.get_joint(JointIndex(i)) for i in plant.GetJointIndices()]
    names = {
        j.position_start(): scoped_joint_name(j, plant) for j in joints if j.num_positions() == 1
    }
    wanted = list(range(plant.num_positions()) if positions is None else positions)
    missing = [int(i) for i in wanted if int(i) not in names]
    if missing:
        raise ValueError(
            f"positions {missing} of the plant are not those of joints with one position"
        )
    return [names[int(i)] for i in wanted]


def checker_indices(checker: CollisionChecker, joints: Sequence[str] | None) -> NDArray[np.int64]:
    """Where the arm's joints stand in the positions of the checker's plant (n,).

    Args:
        checker: the checker.
        joints: names, `instance::joint` or, where only one is so called, `joint`; None: all joints of one
            position of the checker's robot.

    Raises:
        ValueError: the checker is none, or its plant lacks a joint; the message lists those it has.
    """
    if not isinstance(checker, CollisionChecker):
        raise ValueError(
            f"collision_checker must be one of Drake's, such as of MakeCollisionChecker, got {checker!r}"
        )
    plant = checker.plant()
    robots = set(checker.robot_model_instances())
    found: dict[str, Joint] = {}
    short: dict[str, list[str]] = {}
    for i in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(i))
        if joint.num_positions() == 1 and joint.model_instance() in robots:
            name = scoped_joint_name(joint, plant)
            found[name] = joint
            short.setdefault(joint.name(), []).append(name)
    if joints is None:
        joints = list(found)
    indices = []
    for name in joints:
        known = short.get(name, []) if "::" not in name else [name]
        full = known[0] if len(known) == 1 else name
        if full not in found:
            raise ValueError(
                f"the collision checker's robot has no joint {name!r}: it is of another plant; "
                f"it has: {', '.join(found) or 'none'}"
            )
        indices.append(found[full].position_start())
    if not indices or len(set(indices)) != len(indices):
        raise ValueError(f"the collision checker needs one robot joint for each of {list(joints)}")
    return np.array(indices, dtype=np.int64)


def joint_reach(checker: CollisionChecker, indices: NDArray[np.int64]) -> Array:
    """Bounds (n,) of how far a joint's motion moves points of the robot's shapes [m/rad or 1].

    For a joint that turns, the length of the longest way out from its axis along the links, with the
    sizes of the shapes there and of those that have been added to the checker; 1 for one that slides.
    """
    plant = checker.plant()
    inspector = checker.model().scene_graph().model_inspector()
    radius = np.zeros(plant.num_bodies())
    for geometry in inspector.GetAllGeometryIds():
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        box = inspector.GetObbInGeometryFrame(geometry)
        if body is None or box is None or inspector.GetProximityProperties(geometry) is None:
            continue
        size = _farthest(inspector.GetPoseInFrame(geometry) @ box.pose(), box)
        radius[int(body.index())] = max(radius[int(body.index())], size)
    for shapes in checker.GetAllAddedCollisionShapes().values():
        for added in shapes:
            instance = plant.GetModelInstanceByName(added.model_instance_name())
            body = plant.GetBodyByName(added.body_name(), instance)
            box = CalcObb(added.shape())
            size = _farthest(added.pose_in_body() @ box.pose(), box)
            radius[int(body.index())] = max(radius[int(body.index())], size)
    children: dict[int, list[Joint]] = {}
    by_position: dict[int, Joint] = {}
    for i in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(i))
        children.setdefault(int(joint.parent_body().index()), []).append(joint)
        if joint.num_positions() == 1:
            by_position[joint.position_start()] = joint

    def beyond(body: int) -> float:
        """From the origin of a body to the furthest point beyond."""
        ways = [_ways(joint) for joint in children.get(body, [])]
        ends = [
            inside + outside + beyond(int(joint.child_body().index()))
            for joint, (inside, outside) in zip(children.get(body, []), ways)
        ]
        return max([radius[body], *ends])

    reach = []
    for index in indices.tolist():
        joint = by_position[index]
        turns = joint.type_name() != "prismatic"
        reach.append(_ways(joint)[1] + beyond(int(joint.child_body().index())) if turns else 1.0)
    return np.array(reach)


def _farthest(X: RigidTransform, box: Obb) -> float:
    """At most so far from the origin are the points of a box [m]."""
    return float(np.linalg.norm(X.translation()) + np.linalg.norm(box.half_width()))


def _ways(joint: Joint) -> tuple[float, float]:
    """From the parent's origin to the joint, slid as far as it can, and from there to the child's."""
    inside = float(np.linalg.norm(joint.frame_on_parent().GetFixedPoseInBodyFrame().translation()))
    outside = float(np.linalg.norm(joint.frame_on_child().GetFixedPoseInBodyFrame().translation()))
    if joint.type_name() == "prismatic":
        limits = np.abs([joint.position_lower_limits(), joint.position_upper_limits()])
        inside += float(np.where(np.isfinite(limits), limits, 0.0).max())
    return inside, outside
