"""A plant's joints and collision shapes, copied into another plant."""

from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet, SceneGraph
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    FixedOffsetFrame,
    Frame,
    Joint,
    JointIndex,
    ModelInstanceIndex,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    WeldJoint,
)

FREE = "quaternion_floating"
"""The joint that a plant gives to bodies without one."""


def copy_plant(
    plant: MultibodyPlant, scene_graph: SceneGraph, into: MultibodyPlant, scene: SceneGraph
) -> None:
    """Copy model instances, bodies, joints, collision shapes and filters; `into` is finalized then.

    Args:
        plant: a finalized plant that is registered with `scene_graph`.
        scene_graph: its SceneGraph.
        into: an empty plant, registered with `scene`.
        scene: its SceneGraph.

    Raises:
        ValueError: the plant is not finalized, has no SceneGraph, or has a joint of a kind that cannot be
            copied; the message names it.
    """
    if not plant.is_finalized() or not plant.geometry_source_is_registered():
        raise ValueError(
            "the plant must be finalized and registered with the SceneGraph that is given"
        )
    for i in range(2, plant.num_model_instances()):
        into.AddModelInstance(plant.GetModelInstanceName(ModelInstanceIndex(i)))
    bodies: dict[int, RigidBody] = {0: into.world_body()}
    for i in range(1, plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        inertia = body.default_spatial_inertia()
        bodies[i] = into.AddRigidBody(body.name(), body.model_instance(), inertia)
    for index in plant.GetJointIndices():
        _copy_joint(plant.get_joint(JointIndex(index)), bodies, into)
    copies = _copy_shapes(plant, scene_graph, bodies, into)
    inspector, manager = scene_graph.model_inspector(), scene.collision_filter_manager()
    into.Finalize()
    for a, (one, own) in enumerate(copies):
        for two, other in copies[a + 1 :]:
            if inspector.CollisionFiltered(one, two):
                apart = CollisionFilterDeclaration()
                apart.ExcludeBetween(GeometrySet(own), GeometrySet(other))
                manager.Apply(apart)
    if plant.GetPositionNames() != into.GetPositionNames():
        raise ValueError(
            f"the copy of the plant has other positions: {into.GetPositionNames()}, "
            f"not {plant.GetPositionNames()}"
        )


def _copy_joint(joint: Joint, bodies: dict[int, RigidBody], into: MultibodyPlant) -> None:
    kind = joint.type_name()
    if kind == FREE:
        return
    if kind not in ("weld", "revolute", "prismatic"):
        raise ValueError(
            f"joint {joint.name()!r} is of a kind that cannot be copied: {kind}; there are weld, revolute, "
            f"prismatic and {FREE}. Make the checker from the model's files or directives"
        )
    frames = [
        _frame(into, bodies[int(body.index())], frame, f"{joint.name()}_{end}", joint)
        for end, body, frame in (
            ("parent", joint.parent_body(), joint.frame_on_parent()),
            ("child", joint.child_body(), joint.frame_on_child()),
        )
    ]
    if kind == "weld":
        into.AddJoint(WeldJoint(joint.name(), *frames, joint.X_FM()))
        return
    limits = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    if kind == "revolute":
        copy = into.AddJoint(RevoluteJoint(joint.name(), *frames, joint.revolute_axis(), *limits))
    else:
        copy = into.AddJoint(
            PrismaticJoint(joint.name(), *frames, joint.translation_axis(), *limits)
        )
    copy.set_default_positions(joint.default_positions())


def _frame(into: MultibodyPlant, body: RigidBody, frame: Frame, name: str, joint: Joint) -> Frame:
    """The frame's copy on the copied body."""
    X = frame.GetFixedPoseInBodyFrame()
    if X.IsExactlyIdentity():
        return body.body_frame()
    return into.AddFrame(FixedOffsetFrame(name, body.body_frame(), X, joint.model_instance()))


def _copy_shapes(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    bodies: dict[int, RigidBody],
    into: MultibodyPlant,
) -> list[tuple[GeometryId, GeometryId]]:
    """The collision shapes' ids and those of their copies."""
    inspector = scene_graph.model_inspector()
    friction = CoulombFriction(1.0, 1.0)
    copies = []
    for i in range(plant.num_bodies()):
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(BodyIndex(i))):
            pose, shape = inspector.GetPoseInFrame(geometry), inspector.GetShape(geometry)
            name = inspector.GetName(geometry).split("::")[-1]
            copy = into.RegisterCollisionGeometry(bodies[i], pose, shape, name, friction)
            copies.append((geometry, copy))
    return copies
