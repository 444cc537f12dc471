"""Collision shapes of an arm that has a Denavit-Hartenberg table only: capsules along its links."""

import numpy as np
from pydrake.geometry import (
    Capsule,
    CollisionFilterDeclaration,
    GeometrySet,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from fikm_drake.checks import check_positive_finite
from fikm_drake.kinematics.dh_arm import DhArm

SLENDERNESS = 0.04
"""Radius of the capsules over the sum of the arm's lengths by default [-]."""
APART = 1.5
"""Links with less than this many diameters of the arm between them always touch: no pair [-]."""


def AddArmCapsules(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    arm: DhArm,
    instance: ModelInstanceIndex,
    *,
    radius: float | None = None,
    tool_radius: float | None = None,
) -> None:
    """Give an arm of `AddDhArm` shapes that can collide: a capsule along each link.

    A link without length has none, but for the last, which has a ball at the tool. Neighbours, and links with
    next to nothing between them, are no pairs: they touch in every posture.

    Args:
        plant: the plant, not yet finalized, such as `RobotDiagramBuilder().plant()`.
        scene_graph: the one that it is registered with.
        arm: the arm.
        instance: what `AddDhArm(…, capsules=False)` returned.
        radius: of the capsules [m]; None: `SLENDERNESS` times the sum of the arm's lengths.
        tool_radius: of the last link's capsule or ball [m]; None: half the radius.

    Raises:
        ValueError: the plant is finalized or has no SceneGraph, or a radius is not positive.
    """
    if plant.is_finalized() or not plant.geometry_source_is_registered():
        raise ValueError(
            "AddArmCapsules needs a plant that is not finalized and that has a SceneGraph, such as "
            "RobotDiagramBuilder().plant()"
        )
    n = arm.num_joints
    ends = [*(arm.joint_origin(i)[:3, 3] for i in range(n)), arm.tool_pose[:3, 3]]
    lengths = [float(np.linalg.norm(end)) for end in ends]
    if radius is None:
        radius = SLENDERNESS * (sum(lengths) or 1.0)
    radius = check_positive_finite("radius", radius, "m")
    tool_radius = check_positive_finite("tool_radius", tool_radius or 0.5 * radius, "m")
    friction = CoulombFriction(0.8, 0.6)
    shaped = []
    for i, (end, length) in enumerate(zip(ends, lengths)):
        body = plant.GetBodyByName("base" if i == 0 else f"link{i}", instance)
        thick = tool_radius if i == n else radius
        shape: Shape = Sphere(thick)
        X = RigidTransform(end)
        if length > 0.0:
            shape = Capsule(thick, length)
            X = RigidTransform(RotationMatrix.MakeFromOneVector(end / length, 2), end / 2)
        elif i < n:
            continue
        geometry = plant.RegisterCollisionGeometry(
            body, X, shape, f"{body.name()}_capsule", friction
        )
        shaped.append((i, GeometrySet(geometry)))
    for a, (i, one) in enumerate(shaped):
        for b, (j, two) in enumerate(shaped[a + 1 :], start=a + 1):
            between = sum(lengths[i + 1 : j])
            if b == a + 1 or between < APART * 2.0 * radius:
                apart = CollisionFilterDeclaration().ExcludeBetween(one, two)
                scene_graph.collision_filter_manager().Apply(apart)
