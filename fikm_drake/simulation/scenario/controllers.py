"""The controllers that a scenario can name: of each of the five papers, and Drake's own, supervised."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BusValue, Context, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from fikm_drake.arrays import Array
from fikm_drake.control.command_supervision import CommandSupervisorConfig
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.status import ControllerStatus, controller_status
from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController
from fikm_drake.diagrams.drake_differential_ik import drake_differential_ik
from fikm_drake.diagrams.fuzzy_ik_torque_controller import AddFuzzyIkTorqueController
from fikm_drake.diagrams.supervised_differential_ik import AddSupervisedDifferentialIk
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import LawLike
from fikm_drake.simulation.scenario.position_solvers import Integer, LabVolt, Redundancy
from fikm_drake.simulation.scenario.site import TASKS, Site, Wired, no_law, only


@dataclass
class Fuzzy:
    """Paper 1's controller with any law.

    Attributes:
        config: of `AddFuzzyIkController`; None: the default for the target, paper 1's law for positions
            and a sharper one for poses. Its task `position` follows the target (`xy` for pairs, `pose`
            for poses), other tasks must fit it; with positions the task `pose` holds the orientation of
            the start. Its `control_rate` is the scenario's.
    """

    config: FuzzyIkConfig | None = None

    avoids = True

    def settled(self, size: int, rate: float) -> FuzzyIkConfig:
        """The config with the task of a target's size, at the scenario's rate.

        Raises:
            ValueError: task or rate contradict the scenario.
        """
        config = self.config or (_for_poses() if size == 7 else FuzzyIkConfig())
        task = config.task
        if config.control_rate not in (FuzzyIkConfig().control_rate, rate):
            raise ValueError(
                f"config.control_rate {config.control_rate} is not used: the scenario's "
                f"control_rate is {rate}"
            )
        fits = {2: ("xy",), 3: ("position", "pose"), 7: ("pose", "orientation")}
        if task != "position" and task not in fits[size]:
            raise ValueError(
                f"config.task {task!r} does not fit a target of {TASKS[size]}; valid: {fits[size]}"
            )
        task = TASKS[size] if task == "position" else task
        return dataclasses.replace(config, task=task, control_rate=rate)

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        if self.config is not None:
            self.config.validate()

    @property
    def measures(self) -> bool:
        """Whether it takes the measured joints."""
        return self.config is not None and self.config.measured_position

    def add(self, site: Site, law: LawLike | None = None) -> Wired:
        """Add it to a Diagram; `law`: in place of the config's."""
        config = self.settled(site.size, site.rate)
        config = dataclasses.replace(
            config,
            frame=site.robot.frame_name(site.plant),
            clearance=site.clearance or config.clearance,
        )
        if site.torque is None:
            system = AddFuzzyIkController(
                site.builder,
                site.plant,
                config=config,
                law=law,
                collision_checker=site.checker,
                joints=site.robot.joints,
                name="controller",
            )
        else:
            system = AddFuzzyIkTorqueController(
                site.builder,
                site.plant,
                config=config,
                law=law,
                collision_checker=site.checker,
                joints=site.robot.joints,
                bandwidth=site.torque.bandwidth,
                acceleration_limits=site.torque.acceleration_limit,
                estimated_state=site.state,
                name="controller",
            )
        port = system.GetOutputPort
        measured = None
        if config.measured_position and site.torque is None:
            measured = system.GetInputPort("estimated_position")
        turns = config.task in ("pose", "orientation")
        return Wired(
            system,
            system.GetInputPort("desired_pose" if turns else "desired_position"),
            port("commanded_position"),
            port("commanded_velocity"),
            {name: port(name) for name in ("joint_step", "gain", "oscillating", "status")},
            ControllerStatus,
            7 if turns else site.size,
            measured,
        )


@dataclass
class Frmrc:
    """Paper 3's law in a plain resolved-rate loop: gain 1, no filters.

    Attributes:
        variant: `smooth` or `paper`.
        sweeps: passes over the joints in a cycle.
        gain: of each joint's step, in (0, 2) [-]; None: the law's own.
        own_reach: True: the universes of the joints are fixed, what each can reach; False: they follow the
            posture. `paper` has them fixed.
    """

    variant: str = "smooth"
    sweeps: int = 1
    gain: float | None = None
    own_reach: bool = False

    measures, avoids = False, True

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        FuzzyRateControl(self.variant, gain=self.gain, sweeps=self.sweeps)
        if self.variant == "paper" and not self.own_reach:
            raise ValueError("variant paper needs own_reach: true")

    def add(self, site: Site, law: LawLike | None = None) -> Wired:
        """Add it to a Diagram; `law`: in place of its own."""
        if law is None and self.own_reach:
            law = FuzzyRateControl.for_arm(
                site.robot.arm,
                self.variant,
                task=TASKS[site.size],
                gain=self.gain,
                sweeps=self.sweeps,
            )
        law = law or FuzzyRateControl(self.variant, gain=self.gain, sweeps=self.sweeps)
        return self.loop().add(site, law)

    def loop(self) -> Fuzzy:
        """The plain loop that the law is put in."""
        return Fuzzy(FuzzyIkConfig().resolved_rate())


@dataclass
class SupervisedDrake:
    """Drake's `DifferentialInverseKinematicsSystem` behind our supervisor; targets are poses.

    Attributes:
        supervisor: see `CommandSupervisorConfig`.
    """

    supervisor: CommandSupervisorConfig = field(default_factory=CommandSupervisorConfig)

    measures, avoids = False, True

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        self.supervisor.validate()

    def add(self, site: Site, law: LawLike | None = None) -> Wired:
        """Add it to a Diagram."""
        no_law(self, law)
        only(self, site, 7)
        arm = site.robot.arm
        ik = drake_differential_ik(arm, period=1.0 / site.rate)
        system = AddSupervisedDifferentialIk(
            site.builder,
            ik,
            ik.plant(),
            period=1.0 / site.rate,
            config=self.supervisor,
            collision_checker=site.checker,
            clearance=site.clearance,
            name="controller",
        )
        bus = site.builder.AddNamedSystem("pose_bus", _PoseBus(f"{arm.name}::tool"))
        nominal = site.builder.AddNamedSystem(
            "nominal_posture",
            ConstantVectorSource(np.clip(np.zeros(arm.num_joints), arm.lower, arm.upper)),
        )
        site.builder.Connect(nominal.get_output_port(), system.GetInputPort("nominal_posture"))
        site.builder.Connect(bus.get_output_port(), system.GetInputPort("desired_cartesian_poses"))
        port = system.GetOutputPort
        more = () if site.checker is None else ("blocked",)
        logged = {name: port(name) for name in ("gain", "oscillating", "valid", *more)}
        return Wired(
            system,
            bus.get_input_port(),
            port("commanded_position"),
            port("commanded_velocity"),
            logged,
            ControllerStatus,
            7,
            status=_supervised_status,
        )


def _supervised_status(logged: Mapping[str, Array], error: Array) -> ControllerStatus:
    """Of Drake's differential IK behind the supervisor, in the words of our own controller."""
    config = FuzzyIkConfig()
    turn, away = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
    return controller_status(
        valid=bool(logged["valid"][0]),
        error=float(np.hypot(config.characteristic_length * turn, away)),
        tolerance=config.tolerance,
        limited=False,
        oscillating=bool(logged["oscillating"].any()),
        blocked="blocked" in logged and bool(logged["blocked"][0]),
    )


def _for_poses() -> FuzzyIkConfig:
    """What `controller: fuzzy` takes for poses, where the paper's law is slow."""
    return FuzzyIkConfig(law=FuzzyMapping.iterated())


Controller = Fuzzy | Frmrc | SupervisedDrake | LabVolt | Redundancy | Integer | str
CONTROLLERS = {
    "fuzzy": Fuzzy,
    "frmrc": Frmrc,
    "supervised_drake": SupervisedDrake,
    "labvolt": LabVolt,
    "redundancy": Redundancy,
    "integer": Integer,
}
"""Controllers by name, with their defaults; in YAML also by a tag, `controller: !Frmrc {sweeps: 3}`."""


class _PoseBus(LeafSystem):
    """A pose as the bus that Drake's differential IK takes."""

    def __init__(self, frame: str) -> None:
        super().__init__()
        self._frame = frame
        self._pose = self.DeclareAbstractInputPort("pose", Value(RigidTransform())).Eval
        self.DeclareAbstractOutputPort("poses", lambda: Value(BusValue()), self._calc)

    def _calc(self, context: Context, output: Value) -> None:
        bus = BusValue()
        bus.Set(self._frame, Value(self._pose(context)))
        output.set_value(bus)
