"""The robot of a run: one of ours, a DH table, or whatever Drake's Parser reads."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from pathlib import Path

from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.load_robot import last_frame
from fikm_drake.kinematics.robot_file import AddRobot
from fikm_drake.kinematics.serial_chain import SerialChain

MODEL_SUFFIXES = (".urdf", ".sdf", ".xml", ".dmd.yaml")


@dataclass
class Model:
    """A robot from a URDF, SDF, MJCF or model directives file.

    Attributes:
        file: its path, relative to the scenario's own.
        frame: name of the tool's frame; `instance::name` where several models have one; empty: that of the
            body that most joints carry.
        joints: names of the joints that the controller moves; empty: all between the world and the frame.
    """

    file: str = ""
    frame: str = ""
    joints: list[str] = field(default_factory=list)


RobotLike = Model | DhTable | str


@dataclass(frozen=True)
class Robot:
    """A robot that can be added to plants."""

    model: Model | DhArm

    @classmethod
    def of(cls, like: RobotLike) -> "Robot":
        """The robot that a scenario names.

        Raises:
            FileNotFoundError: there is no such arm or file.
            ValueError: it is no robot.
        """
        if isinstance(like, str) and like.endswith(MODEL_SUFFIXES):
            like = Model(like)
        if isinstance(like, Model):
            if not Path(like.file).is_file():
                raise FileNotFoundError(f"no robot file {like.file!r}")
            return cls(like)
        return cls(DhArm(like) if isinstance(like, DhTable) else load_arm(like))

    @property
    def arm(self) -> DhArm:
        """The arm of a DH table.

        Raises:
            ValueError: the robot is from a model file.
        """
        if isinstance(self.model, Model):
            raise ValueError(
                f"{self.name} is from a model file: this needs an arm of a DH table, by name or .yaml file"
            )
        return self.model

    @property
    def name(self) -> str:
        """The arm's or the file's name."""
        if isinstance(self.model, DhArm):
            return self.model.name
        return Path(self.model.file).name.split(".")[0]

    @property
    def frame(self) -> str:
        """Name of the tool's frame; empty: that of the body furthest out."""
        return "tool" if isinstance(self.model, DhArm) else self.model.frame

    @property
    def joints(self) -> list[str] | None:
        """Names of the joints that the controller moves; None: all between the world and the frame."""
        return None if isinstance(self.model, DhArm) else self.model.joints or None

    def chain(self, plant: MultibodyPlant) -> SerialChain:
        """The joints that the controller moves, of a finalized plant that the robot was added to.

        Raises:
            ValueError: there is no such frame or joint.
        """
        return SerialChain.from_plant(plant, self.frame_name(plant), joints=self.joints)

    def frame_name(self, plant: MultibodyPlant) -> str:
        """The tool's frame in a finalized plant, as `instance::name` where the scenario names none."""
        if self.frame:
            return self.frame
        frame = last_frame(plant)
        instance = plant.GetModelInstanceName(frame.model_instance())
        return f"{instance}::{frame.name()}"

    def add(self, plant: MultibodyPlant) -> None:
        """Add the robot to a plant, a base that nothing holds welded to the world.

        Raises:
            ValueError: the file is not valid.
        """
        if isinstance(self.model, DhArm):
            AddDhArm(plant, self.model)
        else:
            AddRobot(plant, self.model.file)
