"""Arms that others have published as URDF or xacro, from installed packages; none is downloaded."""

import os
import re
import sys
import tempfile
import warnings
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.kinematics.robot_file import MakeRobotPlant
from fikm_drake.kinematics.serial_chain import SerialChain

DATA = "cmeel.prefix/share/example-robot-data/robots"
"""Data of the package example-robot-data, in a folder of `sys.path`."""
UNLIMITED = (2.0 * np.pi, 2.0)
"""Taken where a model has no limit of position, each way, or speed [rad or m, rad/s or m/s]."""


@dataclass(frozen=True)
class PublicArm:
    """Where a model is, and its tool's frame."""

    path: str
    frame: str
    base: str | None = None
    """Joints from here on move; None: from the world."""

    @property
    def name(self) -> str:
        """The file's name, with the frame where several arms are of one file."""
        stem = Path(self.path).name.split(".")[0]
        return stem if self.base is None else f"{stem} {self.frame}"


def _trossen(name: str) -> PublicArm:
    return PublicArm(f"xacro/trossen_descriptions/urdf/{name}.urdf.xacro", "/ee_arm_link")


def _kuka(folder: str, name: str) -> PublicArm:
    return PublicArm(f"xacro/kuka_description/{folder}/urdf/{name}", "tool0")


def _ur(name: str) -> PublicArm:
    return PublicArm(f"ur_description/urdf/{name}_robot.urdf", "tool0")


ARMS = (
    PublicArm("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    *(_ur(name) for name in ("ur3", "ur5", "ur10")),
    *(_ur(f"{name}_joint_limited") for name in ("ur3", "ur5", "ur10")),
    PublicArm("kinova_description/robots/kinova.urdf", "j2s6s200_link_6"),
    PublicArm("xarm_description/urdf/xarm7.urdf", "link_eef"),
    PublicArm("z1_description/urdf/z1.urdf", "gripperStator"),
    PublicArm("baxter_description/urdf/baxter.urdf", "left_gripper", "torso"),
    PublicArm("baxter_description/urdf/baxter.urdf", "right_gripper", "torso"),
    PublicArm("tiago_description/robots/tiago_no_hand.urdf", "wrist_ft_tool_link"),
    PublicArm("talos_data/robots/talos_full_v2.urdf", "arm_left_7_link", "torso_2_link"),
    PublicArm("talos_data/robots/talos_full_v2.urdf", "arm_right_7_link", "torso_2_link"),
    PublicArm("pr2_description/urdf/pr2.urdf", "l_gripper_tool_frame", "torso_lift_link"),
    PublicArm("tiago_pro_description/robots/tiago_pro.urdf", "gripper_right_base_link"),
    PublicArm("romeo_description/urdf/romeo.urdf", "RWristYawLink"),
    PublicArm("g1_description/urdf/g1_29dof_rev_1_0.urdf", "right_wrist_yaw_link", "torso_link"),
    PublicArm("centauro_description/urdf/centauro.urdf", "arm2_8"),
    PublicArm("xacro/abb_irb140_description/urdf/irb140.urdf", "tool0"),
    _kuka("kuka_kr120", "kr120r2500pro.urdf"),
    _kuka("kuka_kr16", "kr16_2.urdf"),
    _kuka("kuka_kr210", "kr210l150.urdf"),
    _kuka("kuka_lbr_iiwa", "lbr_iiwa_14_r820.urdf"),
    _kuka("kuka_kr3", "kr3r540.xacro"),
    _kuka("kuka_kr5", "kr5_arc.xacro"),
    _kuka("kuka_kr6", "kr6r700sixx.xacro"),
    _kuka("kuka_kr6", "kr6r900sixx.xacro"),
    _kuka("kuka_kr10", "kr10r1100sixx.xacro"),
    _kuka("kuka_kr150", "kr150_2.xacro"),
    PublicArm("xacro/unimation_puma560_description/urdf/puma560_robot.urdf", "link7"),
    PublicArm("xacro/qut_frankie_description/robots/panda_arm_hand.urdf.xacro", "panda_hand"),
    PublicArm("armer_xarm/data/xacro/robots/xarm6/xarm6.xacro", "link_eef"),
    *(_trossen(name) for name in ("vx300s", "wx250s")),
)
"""With at least six joints, so that a pose is a fair target."""


def public_plant(arm: PublicArm) -> MultibodyPlant | None:
    """The whole model in a plant; None where its package is not installed.

    Raises:
        ValueError: Drake does not read it; the message says why.
    """
    path = next((root / arm.path for root in _roots() if (root / arm.path).is_file()), None)
    if path is None or (path.suffix == ".xacro" and not find_spec("xacro")):
        return None
    text = _expanded(path) if path.suffix == ".xacro" else path.read_text("utf-8")
    robot = ET.fromstring(re.sub(r"<\?xml[^>]*\?>", "", text))
    for link in robot.iter("link"):  # shapes need meshes, and kinematics need no shapes
        for tag in ("visual", "collision", "inertial"):
            for element in link.findall(tag):
                link.remove(element)
    for material in robot.findall("material"):
        robot.remove(material)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        file.write_text(ET.tostring(robot, encoding="unicode"), encoding="utf-8")
        return MakeRobotPlant(file)


def public_chain(arm: PublicArm, plant: MultibodyPlant) -> SerialChain:
    """The arm's chain, with a limit where the model has none, so that all solvers have the same job."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of speeds of zero
        chain = SerialChain.from_plant(plant, arm.frame, base=arm.base)
    lower = np.where(np.isfinite(chain.lower), chain.lower, -UNLIMITED[0])
    upper = np.where(np.isfinite(chain.upper), chain.upper, UNLIMITED[0])
    speed = np.where(np.isfinite(chain.velocity_limits), chain.velocity_limits, UNLIMITED[1])
    default = np.clip(chain.default_position, lower, upper)
    return replace(chain, lower=lower, upper=upper, velocity_limits=speed, default_position=default)


def _roots() -> list[Path]:
    found = [Path(folder) / DATA for folder in sys.path if (Path(folder) / DATA).is_dir()]
    spec = find_spec("rtbdata")
    if spec is not None and spec.submodule_search_locations:
        found += [Path(folder) for folder in spec.submodule_search_locations]
    return found


def _expanded(path: Path) -> str:
    xacro = import_module("xacro")
    arguments = import_module("xacro.substitution_args")
    root = next(parent for parent in path.parents if parent.name == "xacro")

    def find(package: str) -> str:
        for name in (package, package.removesuffix("_support")):
            for folder, names, _ in os.walk(root):
                if name in names:
                    return str(Path(folder) / name)
        raise ValueError(f"{path}: no package {package!r} below {root}")

    vars(arguments)["_eval_find"] = find  # how xacro finds $(find package)
    return str(xacro.process_file(str(path)).toxml())
