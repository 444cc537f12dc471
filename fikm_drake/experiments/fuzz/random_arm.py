"""Random serial arms in a MultibodyPlant."""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, SpatialInertia

from fikm_drake.arrays import Array, Bools

MOST_JOINTS = 60
SCALES = (-3.0, 3.0)
"""Scales of the arms' lengths: decimal exponents, in metres."""


@dataclass(frozen=True)
class RandomArm:
    """A finalized plant with one arm, whose tool is the frame `tool`."""

    plant: MultibodyPlant
    """The plant."""
    scale: float
    """A typical length of a link [m]."""
    lower: Array
    """Lower limits (n,) [rad or m], −inf where there is none."""
    upper: Array
    """Upper limits (n,) [rad or m], inf where there is none."""

    def posture(self, rng: np.random.Generator) -> Array:
        """Random joint positions (n,) inside the limits, some joints at a limit [rad or m]."""
        low = np.where(np.isfinite(self.lower), self.lower, -np.pi)
        high = np.where(np.isfinite(self.upper), self.upper, np.maximum(low, np.pi))
        low = np.minimum(low, high)
        at = np.round(rng.random(len(low)) * 1.1, 1) if rng.random() < 0.2 else rng.random(len(low))
        return np.clip(low + np.minimum(at, 1.0) * (high - low), self.lower, self.upper)


def random_arm(rng: np.random.Generator) -> RandomArm:
    """An arm of 1 to 60 joints: revolute, prismatic, mixed, with and without limits of each kind."""
    n = int(rng.integers(1, 9)) if rng.random() < 0.85 else int(rng.integers(9, MOST_JOINTS + 1))
    scale = 10.0 ** rng.uniform(*SCALES)
    plant = MultibodyPlant(0.0)
    share = rng.choice([0.0, 0.3, 1.0], p=[0.6, 0.3, 0.1])  # of prismatic joints
    planar = rng.random() < 0.15
    limits: Bools = rng.random(4) < (
        0.7,
        0.6,
        0.3,
        0.1,
    )  # of position, speed, acceleration; a joint locked
    frame = plant.world_frame()
    for i in range(n):
        body = plant.AddRigidBody(f"link_{i}", SpatialInertia.SolidSphereWithMass(1.0, 0.1 * scale))
        before = frame if frame is plant.world_frame() else frame.body_frame()
        X = RigidTransform(
            RotationMatrix() if planar else _rotation(rng),
            scale * np.array([1.0, 0.0, 0.0] if planar else rng.normal(size=3)),
        )
        name = f"joint_{i}"
        parent = plant.AddFrame(FixedOffsetFrame(f"before_{i}", before, X))
        axis = np.array([0.0, 0.0, 1.0])
        if rng.random() < share:
            axis = np.array([1.0, 0.0, 0.0]) if planar else axis
            joint = plant.AddJoint(PrismaticJoint(name, parent, body.body_frame(), axis))
            unit = scale
        else:
            joint = plant.AddJoint(RevoluteJoint(name, parent, body.body_frame(), axis))
            unit = 1.0
        _set_limits(rng, joint, unit, limits)
        frame = body
    tip = scale * np.array([1.0, 0.0, 0.0] if planar else rng.normal(size=3))
    plant.AddFrame(FixedOffsetFrame("tool", frame.body_frame(), RigidTransform(tip)))
    plant.Finalize()
    lower, upper = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    return RandomArm(plant, scale, np.array(lower), np.array(upper))


def _set_limits(rng: np.random.Generator, joint: object, unit: float, limits: Bools) -> None:
    """Give a joint some limits [times unit]; `joint` is a Drake joint that is not finalized."""
    position, speed, acceleration, locked = limits & (rng.random(4) < (0.9, 0.9, 0.9, 0.3))
    if position:
        lower = -unit * rng.uniform(0.0, 3.0)
        upper = lower if locked else unit * rng.uniform(0.0, 3.0)
        joint.set_position_limits([lower], [upper])  # type: ignore[attr-defined]
        joint.set_default_positions([0.5 * (lower + upper)])  # type: ignore[attr-defined]
    if speed:
        fast = unit * 10.0 ** rng.uniform(-3.0, 1.5)
        joint.set_velocity_limits([-fast], [fast])  # type: ignore[attr-defined]
    if acceleration:
        hard = unit * 10.0 ** rng.uniform(-2.0, 2.5)
        joint.set_acceleration_limits([-hard], [hard])  # type: ignore[attr-defined]


def _rotation(rng: np.random.Generator) -> RotationMatrix:
    quarter = rng.random() < 0.5
    angles = rng.integers(0, 4, 3) * (0.5 * np.pi) if quarter else rng.uniform(-np.pi, np.pi, 3)
    return RotationMatrix(
        RotationMatrix.MakeZRotation(angles[0])
        .multiply(RotationMatrix.MakeXRotation(angles[1]))
        .multiply(RotationMatrix.MakeZRotation(angles[2]))
    )
