"""A chain from a model's file: the arm's base welded to the world, the tool the end of the chain."""

from pathlib import Path

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, JointIndex

from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_frames import frame_by_name
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.resources import ConfigureParser

MODELS = (".urdf", ".sdf", ".xml")


def load_chain(robot: str | Path, frame: str | None = None) -> SerialChain:
    """The chain of an arm by the name of one of ours, or of a file.

    Args:
        robot: a name such as `panda`, a DH table (.yaml), or a model (.urdf, .sdf, .xml), whose base is
            welded to the world if it floats.
        frame: of a model, the tool's frame by name; None: that of the body furthest out.

    Raises:
        FileNotFoundError: there is no such file or arm.
        ValueError: Drake cannot read the file, or there is no such frame; the message lists the frames.
    """
    if Path(robot).suffix not in MODELS:
        return load_arm(robot).chain
    plant = MultibodyPlant(0.0)
    end = parse_robot(plant, robot)
    return SerialChain.from_plant(plant, end if frame is None else frame_by_name(plant, frame))


def parse_robot(plant: MultibodyPlant, robot: str | Path) -> Frame:
    """Add a model to an empty plant, weld its base, finalize; returns the frame of its last body.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: Drake cannot read it.
    """
    path = Path(robot)
    if not path.is_file():
        raise FileNotFoundError(f"no model file {path}")
    parser = Parser(plant)
    ConfigureParser(parser)
    try:
        parser.AddModels(str(path))
    except RuntimeError as error:
        raise ValueError(f"{path} is not a model that Drake can read: {error}") from error
    parents: dict[int, int] = {}
    for i in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(i))
        parents[int(joint.child_body().index())] = int(joint.parent_body().index())
    depths = {i: _depth(i, parents) for i in range(1, plant.num_bodies())}
    if not depths:
        raise ValueError(f"{path} has no bodies")
    last = max(depths, key=lambda i: (depths[i], -i))
    root = last
    while root in parents and parents[root] != 0:
        root = parents[root]
    if root not in parents:
        plant.WeldFrames(plant.world_frame(), plant.get_body(BodyIndex(root)).body_frame())
    plant.Finalize()
    return plant.get_body(BodyIndex(last)).body_frame()


def _depth(body: int, parents: dict[int, int]) -> int:
    depth = 0
    while body in parents and depth <= len(parents):
        body, depth = parents[body], depth + 1
    return depth
