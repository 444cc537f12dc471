"""The one description of a run: robot, controller, target, plant, sensor, obstacles."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
import copy
import dataclasses
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.yaml import yaml_dump_typed
from pydrake.multibody.plant import MultibodyPlant
from pydrake.trajectories import Trajectory

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts, check_finites, check_flag, check_positive_finite
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.kinematics.angles import middle_of_limits
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.simulation.scenario.controllers import CONTROLLERS, Controller, Frmrc, Fuzzy
from fikm_drake.simulation.scenario.environment import (
    PLANTS,
    Obstacle,
    Plant,
    Sensor,
)
from fikm_drake.simulation.scenario.motion import Motion
from fikm_drake.simulation.scenario.robots import Model, Robot, RobotLike
from fikm_drake.simulation.scenario.samples import Csv, Samples
from fikm_drake.simulation.scenario.targets import Path, Target


@dataclass
class Scenario:
    """A run, from its robot to its target; loaded and saved by Drake's typed YAML.

        robot: panda
        target:
          poses:
          - {xyz: [0.4, 0.1, 0.5], rpy: [3.14159, 0.0, 0.0]}
          - {xyz: [0.5, -0.1, 0.4], rpy: [3.0, 0.1, 0.2]}
          duration: 3.0

    An option that would not be used is an error. What has several kinds is named (`controller: frmrc`), or
    tagged and given options (`controller: !Frmrc {sweeps: 3}`).

    Attributes:
        robot: name of one of our arms, path of a DH table (.yaml), URDF, SDF, MJCF or model directives file,
            or a `Model` with its frame and joints (in YAML a mapping), or `!DhTable` itself.
        controller: `fuzzy`, `frmrc`, `supervised_drake`, `labvolt`, `redundancy`, `integer`, or its options;
            without a tag those of `Fuzzy`.
        target: a `Path`, `!Circle`, `!Csv` or `!Samples`; in Python any Trajectory of Drake's too.
        plant: `kinematic`, `torque_driven`, `servos`, `sim_iiwa`, or its options.
        sensor: how the joints are measured; for controllers with `measured_position`, or torques.
        obstacles: bodies that stand about the robot; the log tells the clearance.
        avoid: whether the controller keeps clear of what stands about it; `labvolt`, `redundancy` and
            `integer` cannot.
        clearance: how it does; in a world of obstacles or, given with none, of what the robot's file has.
            Empty: the controller's own.
        initial_position: joint positions at the start [rad or m]; empty: the nearest to zero inside the
            limits, or a model file's own default; for poses the middle of the limits, which leaves the
            arm free to turn.
        control_rate: cycles a second [Hz].
        seed: of the sensor's noise.

    Raises:
        ValueError: naming the bad value and the valid ones.
        FileNotFoundError: there is no such arm or file.
    """

    robot: RobotLike = ""
    controller: Controller = "fuzzy"
    target: Target = field(default_factory=Path)
    plant: Plant = "kinematic"
    sensor: Sensor = field(default_factory=Sensor)
    obstacles: list[Obstacle] = field(default_factory=list)
    avoid: bool = True
    clearance: ClearanceConfig | None = None
    initial_position: list[float] = field(default_factory=list)
    control_rate: float = 50.0
    seed: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.robot, DhArm):
            self.robot = self.robot.table
        if isinstance(self.target, Trajectory):
            rate = check_positive_finite("control_rate", self.control_rate, "Hz")
            self.target = Samples.of_trajectory(self.target, rate=rate)
        try:
            self.initial_position = np.asarray(self.initial_position, dtype=float).tolist()
        except (TypeError, ValueError) as error:
            raise ValueError(
                f"initial_position must be numbers [rad or m], got {self.initial_position!r}"
            ) from error
        if self.robot:  # else a blank that the YAML loader fills in
            self.validate()

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if not self.robot:
            raise ValueError("robot is missing: the name of an arm, or a file")
        check_positive_finite("control_rate", self.control_rate, "Hz")
        check_counts(least=0, seed=self.seed)
        if not isinstance(self.target, Target):
            raise ValueError(f"target must be a Path, Circle, Csv or Samples, got {self.target!r}")
        self.target.validate()
        controller, plant = self.controller_options(), self.plant_options()
        controller.validate()
        plant.validate()
        self.sensor.validate()
        self._validate_obstacles(controller)
        if isinstance(controller, Fuzzy):
            controller.settled(self.target_motion().size, self.control_rate)
        self.sensor.check_use(plant, measures=controller.measures)
        if self.seed and not (self.sensor.noise or self.sensor.speed_noise):
            raise ValueError(f"seed {self.seed} is not used: sensor.noise is 0")
        if self.num_cycles < 1:
            raise ValueError(
                f"duration + hold must be at least one cycle of {1 / self.control_rate} s, "
                f"got {self.target.duration} + {self.target.hold}"
            )
        self.start()

    def _validate_obstacles(self, controller: Any) -> None:  # noqa: ANN401 (as controller_options)
        for obstacle in self.obstacles:
            obstacle.validate()
        names = [o.name or f"obstacle{i}" for i, o in enumerate(self.obstacles, start=1)]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"obstacles must have different names, got {', '.join(twice)} twice")
        check_flag("avoid", self.avoid)
        if not self.avoid and self.clearance is not None:
            raise ValueError("clearance is not used: avoid is false")
        if not self.avoid and not self.obstacles:
            raise ValueError("avoid: false is not used: there are no obstacles")
        if self.clearance is not None:
            self.clearance.validate()
        if self.avoids and not controller.avoids:
            raise ValueError(
                f"controller {type(controller).__name__} cannot keep clear: with avoid: false the obstacles "
                "are there, and the log tells the clearance; fuzzy, frmrc and supervised_drake avoid them"
            )
        own = getattr(getattr(controller, "config", None), "clearance", ClearanceConfig())
        if own != ClearanceConfig() and (self.clearance is not None or not self.avoids):
            why = "the scenario has one" if self.avoids else "there is nothing to avoid"
            raise ValueError(f"controller.config.clearance is not used: {why}")

    @property
    def avoids(self) -> bool:
        """Whether the controller gets to know what stands about the robot."""
        return self.avoid and (bool(self.obstacles) or self.clearance is not None)

    @property
    def num_cycles(self) -> int:
        """Control cycles of the whole run."""
        return round((self.target.duration + self.target.hold) * self.control_rate)

    def controller_options(self) -> Any:  # noqa: ANN401 (one of the classes of CONTROLLERS)
        """The controller with its options.

        Raises:
            ValueError: there is none of that name; the message lists the names.
        """
        return _named("controller", self.controller, CONTROLLERS)

    def plant_options(self) -> Any:  # noqa: ANN401 (one of the classes of PLANTS)
        """The plant with its options.

        Raises:
            ValueError: there is none of that name; the message lists the names.
        """
        return _named("plant", self.plant, PLANTS)

    def load_robot(self) -> Robot:
        """The robot."""
        return Robot.of(self.robot)

    def load_arm(self) -> DhArm:
        """The arm of a robot from a DH table.

        Raises:
            ValueError: the robot is from a model file.
        """
        return self.load_robot().arm

    def chain(self) -> SerialChain:
        """The joints that the controller moves."""
        robot = self.load_robot()
        if not isinstance(robot.model, Model):
            return robot.arm.chain
        plant = MultibodyPlant(time_step=0.0)
        robot.add(plant)
        plant.Finalize()
        return robot.chain(plant)

    def start(self) -> Array:
        """Joint positions (n,) at the start [rad or m].

        Raises:
            ValueError: they are not n numbers inside the limits.
        """
        chain = self.chain()
        if not self.initial_position and self.target_motion().size == 7:
            return middle_of_limits(chain.lower, chain.upper)
        if not self.initial_position:
            return np.array(chain.default_position)
        q = check_finites("initial_position", self.initial_position, chain.num_joints, "rad or m")
        outside = np.flatnonzero((q < chain.lower) | (q > chain.upper))
        if outside.size:
            i = outside[0]
            raise ValueError(
                f"initial_position[{i}] must be in [{chain.lower[i]}, {chain.upper[i]}], got {q[i]}"
            )
        return np.array(q)

    def controller_config(self) -> FuzzyIkConfig:
        """The config of a controller `fuzzy` or `frmrc`, with the task and the rate of this scenario.

        Raises:
            ValueError: the controller is another one.
        """
        controller = self.controller_options()
        if isinstance(controller, Frmrc):
            controller = controller.loop()
        if not isinstance(controller, Fuzzy):
            raise ValueError(f"controller {self.controller!r} has no FuzzyIkConfig")
        return controller.settled(self.target_motion().size, self.control_rate)

    def with_config(self, config: FuzzyIkConfig) -> "Scenario":
        """A copy with the fuzzy controller and this config."""
        return dataclasses.replace(self, controller=Fuzzy(config))

    @property
    def corners(self) -> Array:
        """The target's path as a polyline (k,2) or (k,3) [m]."""
        return self.target_motion().corners

    def targets(self) -> Array:
        """The target of each cycle (N,m) [m], or (N,7) of poses."""
        motion = self.target_motion()
        return np.array([motion.numbers(k / self.control_rate) for k in range(self.num_cycles)])

    def target_motion(self) -> Motion:
        """The target over time."""
        return self.target.motion()

    def but(self, **changes: ArrayLike | object) -> "Scenario":
        """A copy with other values, each by its path with `__` for dots.

            scenario.but(target__duration=2.0, controller="frmrc")

        Raises:
            ValueError: there is no such option, or the copy is not valid.
        """
        return self.with_options({name.replace("__", "."): v for name, v in changes.items()})

    def with_options(self, changes: dict[str, object]) -> "Scenario":
        """A copy with other values by dotted path, such as `{"controller.config.fused": True}`.

        Raises:
            ValueError: there is no such option, or the copy is not valid.
        """
        copied = copy.deepcopy(self)
        for path, value in changes.items():
            *folders, name = path.split(".")
            owner: Any = copied
            for folder in folders:
                child = getattr(owner, folder, None)
                if isinstance(child, str) and folder in ("controller", "plant"):
                    table = CONTROLLERS if folder == "controller" else PLANTS
                    child = _named(folder, child, table)
                    setattr(owner, folder, child)
                if child is None and folder == "config":
                    child = owner.settled(copied.target_motion().size, copied.control_rate)
                    setattr(owner, folder, child)
                if not dataclasses.is_dataclass(child):
                    raise ValueError(f"no option {path!r}: {folder!r} has no options here")
                owner = child
            names = [item.name for item in dataclasses.fields(owner)]
            if name not in names:
                raise ValueError(
                    f"no option {path!r}; {type(owner).__name__} has {', '.join(names)}"
                )
            setattr(owner, name, value)
        copied.__post_init__()
        return copied

    def whole(self) -> "Scenario":
        """A copy that needs no other file: the arm's table and the target's in it (a model stays a path)."""
        copied = copy.deepcopy(self)
        robot = copied.load_robot()
        if isinstance(robot.model, DhArm):
            copied.robot = robot.arm.table
        if isinstance(copied.target, Csv):
            copied.target = copied.target.samples()
        return copied

    def to_yaml(self) -> str:
        """The scenario as YAML that `load_scenario` reads, with every option."""
        return yaml_dump_typed(self)


def _named(what: str, value: object, known: dict[str, type]) -> Any:  # noqa: ANN401
    """The options of a name, or the value if it is options already."""
    if isinstance(value, tuple(known.values())):
        return value
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{what} must be one of {', '.join(known)}, got {value!r}")
    return known[value]()
