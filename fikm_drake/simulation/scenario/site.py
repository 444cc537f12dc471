"""Where a scenario puts its controller, and what the controller hands back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum

from pydrake.multibody.plant import MultibodyPlant
from pydrake.planning import CollisionChecker
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, OutputPort, System
from pydrake.systems.primitives import ZeroOrderHold

from fikm_drake.arrays import Array
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.simulation.scenario.environment import TorqueDriven
from fikm_drake.simulation.scenario.robots import Robot

TASKS = {2: "xy", 3: "position", 7: "pose"}
"""The task of a controller by the size of the target."""


@dataclass(frozen=True)
class Site:
    """Where a controller is put."""

    builder: DiagramBuilder
    robot: Robot
    plant: MultibodyPlant
    chain: SerialChain
    size: int
    """Size of the target: 2, 3 or 7."""
    rate: float
    start: Array
    """Joint positions at the start (n,) [rad or m]."""
    torque: TorqueDriven | None
    """How torques move the plant, where they do."""
    state: OutputPort | None = None
    """The measured state of the plant; None: it is as it is."""
    checker: CollisionChecker | None = None
    """What the controller keeps clear of."""
    clearance: ClearanceConfig | None = None
    """How it does; None: as its own config says."""


@dataclass(frozen=True)
class Wired:
    """A controller in its place."""

    system: System
    desired: InputPort
    command: OutputPort
    velocity: OutputPort | None
    logged: dict[str, OutputPort]
    statuses: type[IntEnum] | None
    size: int
    """Size of the target that it takes."""
    measured: InputPort | None = None
    """For the measured joints; None: it takes none, or has them already."""
    status: Callable[[Mapping[str, Array], Array], IntEnum] | None = None
    """Status of what is logged and of the error, [rad; m] or [m], of a controller that has no such port."""
    hold: ZeroOrderHold | None = None
    """What keeps the command from cycle to cycle, where the controller's own state does not."""

    def set_start(self, root: Context, position: Array) -> None:
        """Set the command (n,) at the start."""
        if self.hold is not None:
            self.hold.GetMyMutableContextFromRoot(root).SetDiscreteState(position)
        if hasattr(self.system, "SetPositions"):  # else it was told when it was made
            self.system.SetPositions(self.system.GetMyMutableContextFromRoot(root), position)


def position_block(
    site: Site,
    system: System,
    desired: str,
    command: str,
    more: tuple[str, ...],
    statuses: type[IntEnum],
    *,
    held: bool = False,
) -> Wired:
    """A block that gives positions and a status, and no velocity.

    Args:
        site: where it is put.
        system: the block.
        desired: name of its port for the target.
        command: name of its port of joint positions.
        more: names of other ports for the log.
        statuses: what its port `status` means.
        held: whether its command is to be sampled and held, as it follows from the target at once: the robot
            then is where it was until the end of a cycle, as with all other controllers.
    """
    site.builder.AddNamedSystem("controller", system)
    port, hold = system.GetOutputPort(command), None
    if held:
        hold = site.builder.AddNamedSystem("hold", ZeroOrderHold(1.0 / site.rate, port.size()))
        site.builder.Connect(port, hold.get_input_port())
        port = hold.get_output_port()
    return Wired(
        system,
        system.GetInputPort(desired),
        port,
        None,
        {name: system.GetOutputPort(name) for name in (*more, "status")},
        statuses,
        site.size,
        hold=hold,
    )


def no_law(controller: object, law: Callable | None) -> None:
    """ValueError if a law is given to a controller that has none."""
    if law is not None:
        raise ValueError(f"a law is not used by {type(controller).__name__}; take Fuzzy or Frmrc")


def only(controller: object, site: Site, size: int) -> None:
    """ValueError unless the target has this size and the plant takes positions."""
    name = type(controller).__name__
    if site.size != size:
        raise ValueError(f"{name} takes targets of {TASKS[size]}, got {TASKS[site.size]}")
    if site.torque is not None:
        raise ValueError(
            f"{name} commands positions: take the plant kinematic, servos or sim_iiwa, not torque_driven"
        )
