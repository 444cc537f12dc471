"""A chain from a model's file: the arm's base welded to the world, the tool the end of the chain."""

from pathlib import Path

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, JointIndex

from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_frames import frame_by_name
from fikm_drake.kinematics.robot_file import MakeRobotPlant
from fikm_drake.kinematics.serial_chain import SerialChain

MODELS = (".urdf", ".sdf", ".xml")


def load_chain(robot: str | Path, frame: str | None = None) -> SerialChain:
    """The chain of an arm by the name of one of ours, or of a file.

    Args:
        robot: a name such as `panda`, a DH table (.yaml), or a model (.urdf, .sdf, .xml), as of `AddRobot`.
        frame: of a model, the tool's frame by name; None: that of the body furthest out.

    Raises:
        FileNotFoundError: there is no such file or arm.
        ValueError: the file is no robot, or there is no such frame; the message lists the frames.
    """
    if Path(robot).suffix not in MODELS:
        return load_arm(robot).chain
    plant = MakeRobotPlant(robot)
    end = last_frame(plant) if frame is None else frame_by_name(plant, frame)
    return SerialChain.from_plant(plant, end)


def last_frame(plant: MultibodyPlant) -> Frame:
    """The frame of the body that most joints carry, the first of several.

    Raises:
        ValueError: the plant has no bodies.
    """
    parents: dict[int, int] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(index))
        parents[int(joint.child_body().index())] = int(joint.parent_body().index())
    depths = {}
    for i in range(1, plant.num_bodies()):
        body, depths[i] = i, 0
        while body in parents and depths[i] <= len(parents):
            body, depths[i] = parents[body], depths[i] + 1
    if not depths:
        raise ValueError("the robot has no bodies")
    return plant.get_body(BodyIndex(max(depths, key=lambda i: (depths[i], -i)))).body_frame()
