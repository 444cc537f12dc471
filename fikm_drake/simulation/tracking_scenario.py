"""A task for an arm: follow a polyline, then hold."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
import dataclasses
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import ArrayLike
from pydrake.trajectories import PathParameterizedTrajectory, PiecewisePolynomial, Trajectory

from fikm_drake.arrays import Array
from fikm_drake.checks import check_bandwidth, check_not_negative, check_position
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import find_model, load_model

PROFILES = ("constant", "cubic")
TASKS_BY_SIZE = {2: "xy", 3: "position"}


@dataclass
class TrackingScenario:
    """A tool follows a polyline and holds at its end; loaded and saved by Drake's typed YAML.

    One waypoint, or a duration of 0, is a step: the target is the last waypoint from the start.

    Raises:
        ValueError: naming the bad value and the valid ones.
        FileNotFoundError: there is no such arm; the message lists ours.
    """

    arm: str | DhTable = ""
    """Name of one of our arms, path of a YAML file, or the table itself; a `DhArm` is taken too."""
    waypoints: list[list[float]] = field(default_factory=list)
    """Corners of the path in the base frame [m]; pairs are (x, y), and only these rows count."""
    duration: float = 0.0
    """Time from the first to the last waypoint [s]."""
    hold: float = 0.4
    """Time at the last waypoint afterwards [s]."""
    control_rate: float = 50.0
    """Cycles a second [Hz]; takes the place of the config's."""
    initial_position: list[float] | None = None
    """Joint positions at the start [rad or m]; None: the nearest to zero inside the limits."""
    profile: str = "constant"
    """`constant` speed, or `cubic`: the path length is a cubic of time, at rest at both ends."""
    config: FuzzyIkConfig = field(default_factory=FuzzyIkConfig)
    """The controller; its `task` and `control_rate` follow the scenario."""
    servo_bandwidth: float | None = None
    """Of the inner loop of a torque-driven arm with mass and gravity, a MultibodyPlant at 1 kHz
    [rad/s], see `FuzzyIkTorqueController`; None: the arm is where the command is."""

    def __post_init__(self) -> None:
        if isinstance(self.arm, DhArm):
            self.arm = self.arm.table
        self.waypoints = _numbers("waypoints", self.waypoints)
        if self.initial_position is not None:
            self.initial_position = _numbers("initial_position", self.initial_position)
        if self.arm or self.waypoints:  # else a blank that the YAML loader fills in
            self.validate()

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        points = np.array(self.waypoints, dtype=float)
        if points.ndim != 2 or points.shape[1] not in TASKS_BY_SIZE or not len(points):
            raise ValueError(f"waypoints must be pairs or triples [m], got shape {points.shape}")
        if not np.isfinite(points).all():
            raise ValueError(f"waypoints must be finite [m], got {self.waypoints}")
        for name in ("duration", "hold"):
            check_not_negative(name, getattr(self, name))
        if self.profile not in PROFILES:
            raise ValueError(f"profile must be one of {PROFILES}, got {self.profile!r}")
        self.controller_config().validate()
        if self.servo_bandwidth is not None:
            check_bandwidth(self.servo_bandwidth)
        if self.num_cycles < 1:
            raise ValueError(
                f"duration + hold must be at least one cycle of {1 / self.control_rate} s, "
                f"got {self.duration} + {self.hold}"
            )
        self.start()

    @property
    def num_cycles(self) -> int:
        """Control cycles of the whole run."""
        return round((self.duration + self.hold) * self.control_rate)

    def load_arm(self) -> DhArm:
        """The arm."""
        return DhArm(self.arm) if isinstance(self.arm, DhTable) else load_arm(self.arm)

    def controller_config(self) -> FuzzyIkConfig:
        """The config with the scenario's task and rate."""
        task = TASKS_BY_SIZE[len(self.waypoints[0])]
        return dataclasses.replace(self.config, task=task, control_rate=self.control_rate)

    def start(self) -> Array:
        """Joint positions (n,) at the start [rad or m]."""
        arm = self.load_arm()
        if self.initial_position is None:
            return arm.default_position
        return check_position(self.initial_position, arm.lower, arm.upper)

    def trajectory(self) -> Trajectory:
        """The target (m,1) [m] over time [s]."""
        points = np.array(self.waypoints)
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        keep = np.concatenate([[True], lengths > 0])  # a path does not pause at a repeated waypoint
        corners = np.concatenate([[0.0], np.cumsum(lengths[lengths > 0])])
        if len(corners) < 2 or self.duration == 0.0:
            return PiecewisePolynomial(points[-1:].T)
        path = PiecewisePolynomial.FirstOrderHold(corners, points[keep].T)
        times, ends = [0.0, self.duration], np.array([[0.0, corners[-1]]])
        if self.profile == "cubic":
            length = PiecewisePolynomial.CubicHermite(times, ends, np.zeros((1, 2)))
        else:
            length = PiecewisePolynomial.FirstOrderHold(times, ends)
        return PathParameterizedTrajectory(path, length)


def _numbers(name: str, values: ArrayLike) -> list:
    """The values as lists of floats."""
    try:
        return np.asarray(values, dtype=float).tolist()
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be numbers in rows of one length, got {values!r}") from error


def load_scenario(name_or_path: str | Path) -> TrackingScenario:
    """Load a scenario by the name of one of ours or from a YAML file of your own.

    Args:
        name_or_path: such as `table6_10s`, or a path that ends in .yaml; a path in its `arm:` is
            relative to it.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file does not describe a scenario; the message says what is wrong.
    """
    folder = find_model(name_or_path, folder="scenarios", kind="scenario").parent

    def prepare(scenario: yaml.MappingNode) -> None:
        for key, value in scenario.value:
            if key.value == "arm" and str(value.value).endswith((".yaml", ".yml")):
                value.value = str(folder / value.value)

    return load_model(
        TrackingScenario, name_or_path, folder="scenarios", kind="scenario", prepare=prepare
    )
