"""Any velocity-commanding differential IK, supervised and integrated, as one Diagram."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.planning import CollisionChecker
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import Gain

from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.control.command_supervision import CommandSupervisorConfig
from fikm_drake.diagrams.add_fuzzy_ik_controller import unique_name
from fikm_drake.kinematics.checker_joints import arm_joint_names
from fikm_drake.kinematics.plant_frames import check_plant
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.systems.clearance_filter import ClearanceFilter
from fikm_drake.systems.command_supervisor import CommandSupervisor
from fikm_drake.systems.joint_integrator import JointIntegrator


class SupervisedDifferentialIk(Diagram):
    """A differential-IK system, its velocity command calmed and integrated to a position command.

    .. pydrake_system::

        name: SupervisedDifferentialIk
        input_ports:
        - <every input of the differential IK but position>
        output_ports:
        - commanded_position
        - commanded_velocity
        - gain
        - oscillating
        - valid

    - inputs: those of the differential IK under their own names, such as **nominal_posture** and
      **desired_cartesian_poses** of Drake's `DifferentialInverseKinematicsSystem`. (Connect one of
      its two kinds of target, and not both: else Drake ends the process.)
    - **commanded_position** (n) [rad or m]: from the state; set its start by `SetPositions`.
    - **commanded_velocity** (n) [rad/s or m/s]: the last change of the command over the period.
    - **gain** (n) [-], **oscillating** (n), **valid** (1): of the `CommandSupervisor`.

    It stands in for Drake's `DifferentialInverseKinematicsController`, which has no place between
    its velocity and its integrator. The position command stays inside the plant's limits, and holds
    while the velocity is not finite.

    Args:
        differential_ik: a system with an input `position` (n) and an output `commanded_velocity` (n)
            for all n joints of the plant, such as Drake's `DifferentialInverseKinematicsSystem`.
        plant: a finalized plant with the joints' limits, such as `differential_ik.plant()`; with the
            arm only, unless `chain` is given.
        period: of the control cycle [s], such as `differential_ik.time_step()`.
        config: see `CommandSupervisorConfig`.
        chain: the n joints that `differential_ik` moves, of a plant with others too; None: all of the
            plant's.
        collision_checker: what the command keeps clear of, whatever the differential IK does, such as of
            `MakeCollisionChecker`; then there are the ports **clearance**, **blocked**, **blocking_bodies**
            and, where something in its world can move, **obstacle_position**, of `ClearanceFilter`.
        clearance: distances and rules; None: the defaults of `ClearanceConfig`.

    Raises:
        ValueError: the plant is not finalized or has a free base, the ports are missing or of another
            size, or naming the bad value.
    """

    def __init__(
        self,
        differential_ik: System,
        plant: MultibodyPlant,
        *,
        period: float,
        config: CommandSupervisorConfig | None = None,
        chain: SerialChain | None = None,
        collision_checker: CollisionChecker | None = None,
        clearance: ClearanceConfig | None = None,
    ) -> None:
        super().__init__()
        if chain is None:
            check_plant(plant)
            lower, upper = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
            start = np.clip(plant.GetPositions(plant.CreateDefaultContext()), lower, upper)
        else:
            lower, upper, start = chain.lower, chain.upper, chain.default_position
        n = len(start)
        _check_ports(differential_ik, n)

        supervisor = CommandSupervisor(n, period=period, config=config)
        integrator = JointIntegrator(lower, upper, period=period, initial_position=start)
        builder = DiagramBuilder()
        ik = builder.AddNamedSystem("differential_ik", differential_ik)
        builder.AddNamedSystem("command_supervisor", supervisor)
        step = builder.AddNamedSystem("step", Gain(period, n))
        self._integrator = builder.AddNamedSystem("joint_integrator", integrator)

        velocity = ik.GetOutputPort("commanded_velocity")
        builder.Connect(velocity, supervisor.GetInputPort("commanded_velocity"))
        builder.Connect(supervisor.GetOutputPort("calmed_velocity"), step.get_input_port())
        self._clear = None
        if collision_checker is None:
            builder.Connect(step.get_output_port(), integrator.GetInputPort("joint_step"))
        else:
            names = arm_joint_names(plant, None if chain is None else chain.position_indices)
            guard = Clearance(collision_checker, clearance, period=period, joints=names)
            clear = builder.AddNamedSystem("clearance_filter", ClearanceFilter(guard))
            builder.Connect(step.get_output_port(), clear.GetInputPort("asked_step"))
            builder.Connect(integrator.GetOutputPort("position"), clear.GetInputPort("position"))
            builder.Connect(
                clear.GetOutputPort("joint_step"), integrator.GetInputPort("joint_step")
            )
            self._clear = clear
        builder.Connect(integrator.GetOutputPort("position"), ik.GetInputPort("position"))
        for i in range(ik.num_input_ports()):
            port = ik.get_input_port(i)
            if port.get_name() != "position":
                builder.ExportInput(port, port.get_name())
        if self._clear is not None:
            if self._clear.HasInputPort("obstacle_position"):
                builder.ExportInput(
                    self._clear.GetInputPort("obstacle_position"), "obstacle_position"
                )
        for block, name, exported in (
            (integrator, "position", "commanded_position"),
            (integrator, "velocity", "commanded_velocity"),
            (supervisor, "gain", "gain"),
            (supervisor, "oscillating", "oscillating"),
            (supervisor, "valid", "valid"),
        ):
            builder.ExportOutput(block.GetOutputPort(name), exported)
        if self._clear is not None:
            for name in ("clearance", "blocked", "blocking_bodies"):
                builder.ExportOutput(self._clear.GetOutputPort(name), name)
        builder.BuildInto(self)

    def BlockingPair(self, context: Context) -> tuple[str, str]:
        """Scoped names of the bodies that push most in this Diagram's context; empty for none."""
        if self._clear is None:
            return "", ""
        return self._clear.BlockingPair(self.GetSubsystemContext(self._clear, context))

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this Diagram's context, at rest.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        own = self.GetMutableSubsystemContext(self._integrator, context)
        self._integrator.SetPositions(own, position)


def AddSupervisedDifferentialIk(
    builder: DiagramBuilder,
    differential_ik: System,
    plant: MultibodyPlant,
    *,
    period: float,
    config: CommandSupervisorConfig | None = None,
    chain: SerialChain | None = None,
    collision_checker: CollisionChecker | None = None,
    clearance: ClearanceConfig | None = None,
    name: str = "supervised_differential_ik",
) -> SupervisedDifferentialIk:
    """Add a `SupervisedDifferentialIk` to `builder` and return it; see there for all else."""
    system = SupervisedDifferentialIk(
        differential_ik,
        plant,
        period=period,
        config=config,
        chain=chain,
        collision_checker=collision_checker,
        clearance=clearance,
    )
    return builder.AddNamedSystem(unique_name(builder, name), system)


def _check_ports(system: System, n: int) -> None:
    """ValueError unless the system takes `position` (n) and gives `commanded_velocity` (n)."""
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    for kind, name, ports in (
        ("input", "position", inputs),
        ("output", "commanded_velocity", outputs),
    ):
        sizes = {port.get_name(): port.size() for port in ports}
        if sizes.get(name) != n:
            raise ValueError(
                f"differential_ik needs an {kind} {name} of size {n}, the plant's joints; "
                f"its {kind}s have the sizes {sizes}"
            )
