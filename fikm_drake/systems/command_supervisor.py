"""The block that calms the velocity command of any controller."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import check_period
from fikm_drake.control.command_supervision import CommandSupervision, CommandSupervisorConfig
from fikm_drake.systems.valid_port import declare_valid_port


class CommandSupervisor(LeafSystem):
    """Passes a velocity command on, less the chatter: a supervised gain for each joint.

    .. pydrake_system::

        name: CommandSupervisor
        input_ports:
        - commanded_velocity
        output_ports:
        - calmed_velocity
        - gain
        - oscillating
        - valid

    - **commanded_velocity** (n) [rad/s or m/s]: the command of any controller.
    - **calmed_velocity** (n) [rad/s or m/s]: gain times the command, joint by joint; zeros while the
      command is not finite.
    - **gain** (n) [-]: 1 for a joint whose command passes untouched; from the state.
    - **oscillating** (n): 1 for a joint whose command changes its sign too often, else 0; from the
      state.
    - **valid** (1): 1 while the input is finite, else 0. What is not finite is not remembered.

    It must see every command once: let `period` be the controller's.

    Args:
        num_joints: n.
        period: of the control cycle [s].
        config: see `CommandSupervisorConfig`.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self, num_joints: int, *, period: float, config: CommandSupervisorConfig | None = None
    ) -> None:
        super().__init__()
        self._supervision = CommandSupervision(num_joints, config)
        self._hold = np.zeros(num_joints)
        command = self.DeclareVectorInputPort("commanded_velocity", num_joints)
        self._command = command.Eval
        self.DeclareDiscreteState(self._supervision.initial_memory())
        self.DeclareVectorOutputPort(
            "calmed_velocity",
            num_joints,
            self._calc_velocity,
            prerequisites_of_calc={command.ticket(), self.xd_ticket()},
        )
        self._declare_state_output("gain", num_joints, self._supervision.gain)
        self._declare_state_output("oscillating", num_joints, self._supervision.oscillating)
        declare_valid_port(self)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def _declare_state_output(self, name: str, size: int, read: Callable[[Array], Array]) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.set_value(read(context.get_discrete_state_vector().value()))

        self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc={self.xd_ticket()})

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        command = self._command(context)
        gain = self._supervision.gain(context.get_discrete_state_vector().value())
        output.set_value(gain * command if all_finite(command) else self._hold)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        command = self._command(context)
        if all_finite(command):
            memory = discrete_state.get_mutable_value()  # holds the present state until written
            self._supervision.remember(memory, command)
