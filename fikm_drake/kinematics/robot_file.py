"""Robots as files of URDF, SDF or MJCF: what Drake would end the process for, and what is odd."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, nan
from pathlib import Path
from xml.etree import ElementTree as ET

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from fikm_drake.checks import check_not_negative
from fikm_drake.kinematics.dh_table import DEGREES
from fikm_drake.resources import ConfigureParser

SUFFIXES = (".urdf", ".sdf", ".xml", ".yaml", ".yml")
"""Endings of files that Drake's Parser reads: URDF, SDF, MJCF, model directives."""
MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class RobotFinding:
    """Something odd about a joint of a file, and what to do."""

    joint: str
    text: str

    def __str__(self) -> str:
        return f"joint {self.joint!r}: {self.text}"


def check_robot_file(path: str | Path) -> list[RobotFinding]:
    """What is odd in a URDF; an error for what Drake's Parser would end the process for.

        for finding in fd.check_robot_file("robot.urdf"):
            print(finding)

    Args:
        path: of a URDF; files of other kinds are not looked into, and have no findings.

    Returns:
        One a joint and oddity, in the order of the file.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: naming file, joint and value, and what to write instead.
    """
    path = Path(path)
    if path.suffix not in SUFFIXES:
        raise ValueError(f"robot must be a file that ends in one of {SUFFIXES}, got {str(path)!r}")
    if not path.is_file():
        raise FileNotFoundError(f"no robot file {path}")
    if path.suffix != ".urdf":
        return []
    try:
        robot = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path} is not XML: {error}") from error
    return [finding for joint in robot.iter("joint") for finding in _findings(path, joint)]


def AddRobot(plant: MultibodyPlant, path: str | Path) -> ModelInstanceIndex:
    """Add a robot from a file to `plant`, its root welded to the world unless the file says where.

    As Drake's Parser, but after `check_robot_file`, and a ValueError where the Parser ends the process.

    Args:
        plant: not finalized.
        path: of a URDF, SDF or MJCF file, or of model directives; packages are looked for in the
            folders above it, and `package://fikm_drake/` has our arms.

    Returns:
        The first model instance of the file.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the plant is finalized, or the file is no robot; the message names file and reason.
    """
    path = Path(path)
    check_robot_file(path)
    if plant.is_finalized():
        raise ValueError(f"AddRobot({path.name!r}): the plant is finalized already")
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    ConfigureParser(parser)
    for folder in (path.resolve().parent, *list(path.resolve().parents)[1:4]):
        if (folder / "package.xml").is_file() and not parser.package_map().Contains(folder.name):
            parser.package_map().Add(folder.name, str(folder))
    try:
        instances = parser.AddModels(str(path))
    except (RuntimeError, SystemExit) as error:  # SystemExit: a condition that Drake insists on
        raise ValueError(f"{path} is no robot that Drake reads: {error}") from error
    if not instances:
        raise ValueError(f"{path} holds no model")
    for instance in instances:
        _weld_roots(plant, instance)
    return instances[0]


def MakeRobotPlant(path: str | Path, *, time_step: float = 0.0) -> MultibodyPlant:
    """A finalized plant with nothing but the robot of a file; continuous by default.

    Args:
        path: as of `AddRobot`.
        time_step: of a discrete plant [s]; 0: a continuous one.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: see `AddRobot`; or the time step is negative or not finite.
    """
    plant = MultibodyPlant(time_step=check_not_negative("time_step", time_step))
    AddRobot(plant, path)
    plant.Finalize()
    return plant


def _weld_roots(plant: MultibodyPlant, instance: ModelInstanceIndex) -> None:
    """Weld bodies that no joint carries but that carry others: a brick beside them stays free."""
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    carried = {int(joint.child_body().index()) for joint in joints}
    carrying = {int(joint.parent_body().index()) for joint in joints}
    for index in plant.GetBodyIndices(instance):
        if int(index) in carrying - carried:
            plant.WeldFrames(plant.world_frame(), plant.get_body(index).body_frame())


def _findings(path: Path, joint: ET.Element) -> Iterator[RobotFinding]:
    name, kind = joint.get("name", "?"), joint.get("type", "?")
    if kind not in MOVING:
        return
    where = f"{path}: joint {name!r}"
    limit = joint.find("limit")
    given = {} if limit is None else limit.attrib
    lower, upper, speed = (_number(where, given, key) for key in ("lower", "upper", "velocity"))
    if lower is not None and upper is not None and lower > upper:
        raise ValueError(f"{where}: lower {lower} exceeds upper {upper}: swap them")
    if speed is not None and speed < 0.0:
        raise ValueError(f"{where}: velocity must not be negative, got {speed}: write {-speed}")
    if not speed:
        was = "is missing" if speed is None else "is 0, as exporters of CAD programs write it,"
        yield RobotFinding(
            name, f"velocity {was} and taken as no limit: write the joint's largest speed"
        )
    if kind != "continuous" and (lower is None or upper is None):
        yield RobotFinding(name, "has no lower or no upper limit, and is taken to move without end")
    elif lower == upper and kind != "continuous":
        yield RobotFinding(name, f"equal limits {lower}: taken as fixed there")
    if kind == "revolute" and max(abs(lower or 0.0), abs(upper or 0.0)) > DEGREES[1]:
        yield RobotFinding(name, f"limits {lower} and {upper} look like degrees: write radians")
    mimic = joint.find("mimic")
    if mimic is not None:
        yield RobotFinding(
            name,
            f"follows joint {mimic.get('joint')!r} (mimic): a controller must not move it, leave it out "
            "of joints=",
        )


def _number(where: str, given: dict[str, str], key: str) -> float | None:
    """The attribute as a finite number, None if it is missing."""
    text = given.get(key)
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        remedy = "leave it out for none" if abs(value) == inf else "write a number"
        raise ValueError(f"{where}: {key} must be a finite number, got {text!r}: {remedy}")
    return value
