"""How the robot moves, how it is measured, and what stands about it."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field

import numpy as np
from pydrake.geometry import Box, Cylinder, Shape, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, default_model_instance

from fikm_drake.checks import (
    check_bandwidth,
    check_finites,
    check_not_negative,
    check_positive_finite,
)

COLOUR = np.array([0.55, 0.60, 0.68, 0.8])
TIME_STEP = 1e-3


@dataclass
class Kinematic:
    """The robot is where its command is."""

    def validate(self) -> None:
        """Nothing can be wrong."""


@dataclass
class TorqueDriven:
    """An arm of mass and gravity under Drake's InverseDynamicsController; see `FuzzyIkTorqueController`.

    Attributes:
        bandwidth: of the inner loop [rad/s]; more is stiffer.
        acceleration_limit: of the joints' reference [rad/s² or m/s²].
        time_step: of the plant [s].
    """

    bandwidth: float = 100.0
    acceleration_limit: float = 20.0
    time_step: float = TIME_STEP

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        check_bandwidth(self.bandwidth)
        check_positive_finite("acceleration_limit", self.acceleration_limit, "rad/s² or m/s²")
        check_positive_finite("time_step", self.time_step, "s")


@dataclass
class Servos:
    """An arm of mass and gravity with a PD servo in each joint, such as a hobby servo.

    Attributes:
        stiffness: [N m/rad or N/m].
        damping: [N m s/rad or N s/m]; it is late behind a moving command by damping / stiffness [s].
        time_step: of the plant [s].
    """

    stiffness: float = 1000.0
    damping: float = 20.0
    time_step: float = TIME_STEP

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        check_positive_finite("stiffness", self.stiffness, "N m/rad")
        check_not_negative("damping", self.damping)
        check_positive_finite("time_step", self.time_step, "s")


@dataclass
class SimIiwa:
    """An arm of mass and gravity under Drake's `SimIiwaDriver`, in its mode position_only.

    Attributes:
        time_step: of the plant [s].
    """

    time_step: float = TIME_STEP

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        check_positive_finite("time_step", self.time_step, "s")


Plant = Kinematic | TorqueDriven | Servos | SimIiwa | str
PLANTS = {
    "kinematic": Kinematic,
    "torque_driven": TorqueDriven,
    "servos": Servos,
    "sim_iiwa": SimIiwa,
}
"""Plants by name, with their defaults; in YAML also by a tag, `plant: !TorqueDriven {bandwidth: 80}`."""


DELAY_MARGIN = 0.647
"""Delay times bandwidth at which the critically damped inner loop becomes unstable: with L(s) =
ω (2 s + ω) / s² its phase margin is 1.332 rad at the frequency 2.058 ω [-]."""


@dataclass
class Sensor:
    """How the joints are measured, for a controller that takes what is measured.

    With the plant `torque_driven` it measures position and speed of all joints, for the inverse dynamics and
    the IK before it; a sample then acts one step of the plant after it was taken, at the earliest.

    Attributes:
        noise: standard deviation of each sample of each joint [rad or m].
        delay: age of a sample when it arrives [s], in whole samples.
        rate: samples a second [Hz]; 0: as often as the controller's cycles, with torques as often as the
            plant's steps.
        speed_noise: of each sample of each joint's speed, with torques [rad/s or m/s].
    """

    noise: float = 0.0
    delay: float = 0.0
    rate: float = 0.0
    speed_noise: float = 0.0

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        for name in ("noise", "delay", "rate", "speed_noise"):
            check_not_negative(name, getattr(self, name))

    def check_use(self, plant: object, *, measures: bool) -> None:
        """ValueError where it is not used with a plant and a controller, or makes the loop unstable."""
        if self == Sensor():
            return
        if not isinstance(plant, TorqueDriven):
            if not measures:
                raise ValueError(
                    "sensor is not used: it needs the controller's config.measured_position, or the plant "
                    "torque_driven"
                )
            if self.speed_noise:
                raise ValueError("sensor.speed_noise is not used: the plant is not torque_driven")
            return
        held = 0.5 / self.rate if self.rate else 0.5 * plant.time_step
        late = self.delay + plant.time_step + held
        if late * plant.bandwidth >= DELAY_MARGIN:
            raise ValueError(
                f"sensor is late by {1000 * late:g} ms, delay, half a sample and a step of the plant: the "
                f"inner loop of bandwidth {plant.bandwidth:g} rad/s is unstable from "
                f"{1000 * DELAY_MARGIN / plant.bandwidth:.3g} ms; lower plant.bandwidth or measure sooner"
            )


@dataclass
class Obstacle:
    """A body that stands still; one of box, radius, or radius with length.

    Attributes:
        xyz: its middle in the world [m].
        rpy: roll, pitch and yaw [rad].
        box: edges of a box [m].
        radius: of a ball, or of a cylinder along its own z [m].
        length: of the cylinder [m].
        name: by which logs call it; empty: `obstacle1` and so on, by its place in the list.
    """

    xyz: list[float] = field(default_factory=list)
    rpy: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    box: list[float] = field(default_factory=list)
    radius: float = 0.0
    length: float = 0.0
    name: str = ""

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        check_finites("obstacle: xyz", self.xyz, 3, "m")
        check_finites("obstacle: rpy", self.rpy, 3, "rad")
        if bool(self.box) == bool(self.radius) or (self.box and self.length):
            raise ValueError(f"an obstacle needs either box or radius, got {self!r}")
        sizes = self.box if self.box else [self.radius]
        for size in check_finites("obstacle: box", sizes, 3 if self.box else 1, "m"):
            check_positive_finite("obstacle: size", size, "m")
        check_not_negative("obstacle: length", self.length)

    def add(self, plant: MultibodyPlant, name: str) -> None:
        """Add it to a plant as a body that is welded to the world, to see and to collide with."""
        shape: Shape = (
            Box(*self.box)
            if self.box
            else Cylinder(self.radius, self.length)
            if self.length
            else Sphere(self.radius)
        )
        pose = RigidTransform(RollPitchYaw(self.rpy), np.array(self.xyz))
        body = plant.AddRigidBody(name, default_model_instance(), SpatialInertia.Zero())
        plant.WeldFrames(plant.world_frame(), body.body_frame(), pose)
        middle = RigidTransform()
        plant.RegisterVisualGeometry(body, middle, shape, name, COLOUR)
        plant.RegisterCollisionGeometry(body, middle, shape, name, CoulombFriction(0.5, 0.5))
