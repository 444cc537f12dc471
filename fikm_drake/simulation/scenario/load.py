"""Scenarios from files: today's, and those of the first version."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.yaml import yaml_load

from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.resources import find_model, load_yaml
from fikm_drake.simulation.scenario.controllers import Fuzzy
from fikm_drake.simulation.scenario.environment import TorqueDriven
from fikm_drake.simulation.scenario.robots import MODEL_SUFFIXES, Model
from fikm_drake.simulation.scenario.samples import Csv
from fikm_drake.simulation.scenario.schema import Scenario
from fikm_drake.simulation.scenario.targets import Path

NameOrTable = TypeVar("NameOrTable", str, DhTable, str | DhTable)


def load_scenario(name_or_path: str | FilePath) -> Scenario:
    """Load a scenario by the name of one of ours or from a YAML file of your own.

    Files of the first version, with `arm` and `waypoints`, are read too.

    Args:
        name_or_path: such as `table6_10s`, or a path that ends in .yaml. Files that it names are looked
            for beside it.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file does not describe a scenario; the message says what is wrong.
    """
    path = find_model(name_or_path, folder="scenarios", kind="scenario")
    try:
        if _is_old(path):
            first = load_yaml(_First, path, kind="scenario")
            first.arm = _beside(first.arm, path.parent)
            return first.today()
        scenario = load_yaml(Scenario, path, kind="scenario")
        _look_beside(scenario, path.parent)
        scenario.__post_init__()
        scenario.validate()
    except ValueError as error:
        text = str(error)
        raise ValueError(text if str(path) in text else f"{path}: {text}") from error
    return scenario


def TrackingScenario(  # noqa: N802 (it stands for a Scenario, as Drake's Make… stand for systems)
    arm: str | DhTable | DhArm,
    waypoints: ArrayLike,
    duration: float = 0.0,
    *,
    hold: float = 0.4,
    control_rate: float = 50.0,
    initial_position: ArrayLike | None = None,
    profile: str = "constant",
    config: FuzzyIkConfig | None = None,
    servo_bandwidth: float | None = None,
) -> Scenario:
    """A `Scenario` of the commonest kind in one call: the fuzzy controller takes a tool along a polyline.

    Args:
        arm: name of one of our arms, path of a YAML file, the table itself, or the arm.
        waypoints: corners of the path in the base frame [m]; pairs are (x, y), and only these rows count.
        duration: time from the first to the last waypoint [s]; 0: a step to the last one.
        hold: time at the last waypoint afterwards [s].
        control_rate: cycles a second [Hz].
        initial_position: joint positions at the start [rad or m]; None: the nearest to zero.
        profile: `constant` speed, or `cubic`.
        config: of the controller.
        servo_bandwidth: of the inner loop of a torque-driven arm [rad/s]; None: a kinematic run.

    Raises:
        ValueError: naming the bad value and the valid ones.
        FileNotFoundError: there is no such arm; the message lists ours.
    """
    return Scenario(
        robot=arm.table if isinstance(arm, DhArm) else arm,
        controller=Fuzzy(config),
        target=Path(positions=_rows(waypoints), duration=duration, hold=hold, profile=profile),
        plant="kinematic" if servo_bandwidth is None else TorqueDriven(servo_bandwidth),
        initial_position=[] if initial_position is None else initial_position,  # type: ignore[arg-type]
        control_rate=control_rate,
    )


@dataclass
class _First:
    """A scenario file of the first version."""

    arm: str | DhTable = ""
    waypoints: list[list[float]] = field(default_factory=list)
    duration: float = 0.0
    hold: float = 0.4
    control_rate: float = 50.0
    initial_position: list[float] | None = None
    profile: str = "constant"
    config: FuzzyIkConfig = field(default_factory=FuzzyIkConfig)
    servo_bandwidth: float | None = None

    def today(self) -> Scenario:
        """The same as a `Scenario`."""
        scenario = TrackingScenario(**vars(self))
        scenario.validate()
        return scenario


def _is_old(path: FilePath) -> bool:
    try:
        keys = yaml_load(filename=str(path))
    except Exception:  # PyYAML's kinds; the loader says what is wrong
        return False
    if not isinstance(keys, dict):
        return False
    return "robot" not in keys and ("arm" in keys or "waypoints" in keys)


def _look_beside(scenario: Scenario, folder: FilePath) -> None:
    """Relative files are beside the scenario's own, if there are such."""
    if isinstance(scenario.target, Csv):
        scenario.target.file = _beside(scenario.target.file, folder)
    if isinstance(scenario.robot, Model):
        scenario.robot.file = _beside(scenario.robot.file, folder)
    else:
        scenario.robot = _beside(scenario.robot, folder)


def _beside(name: NameOrTable, folder: FilePath) -> NameOrTable:
    """A file's name as a path, if there is such a file in the folder."""
    if not isinstance(name, str) or not name.endswith((*MODEL_SUFFIXES, ".yaml", ".yml", ".csv")):
        return name
    return str(folder / name) if (folder / name).is_file() else name  # type: ignore[return-value]


def _rows(values: ArrayLike) -> list[list[float]]:
    try:
        return np.asarray(values, dtype=float).tolist()
    except (TypeError, ValueError) as error:
        raise ValueError(f"waypoints must be rows of numbers [m], got {values!r}") from error
