"""The whole controller as one block, for control at 1 kHz."""

import dataclasses
from collections.abc import Callable
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
)

from fikm_drake.laws.controller_status import controller_status
from fikm_drake.laws.gain_supervision import GainSupervision
from fikm_drake.laws.law import Law
from fikm_drake.laws.safe_step import safe_step
from fikm_drake.laws.steps import amplify, integrate, is_limited, length, low_pass
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.systems.joint_integrator import check_position, set_command
from fikm_drake.systems.tool_pose_kinematics import make_tool_kinematics

Array = NDArray[np.float64]


class _Cycle(NamedTuple):
    """What one control cycle computes from the state and the inputs."""

    valid: bool
    error: Array
    error_length: float
    gain: float
    filtered_gain: float
    filtered_error: Array
    joint_step: Array


class FusedFuzzyIk(LeafSystem):
    """The fuzzy IK controller in one block: the ports and the steps of the Diagram, less its calls.

    .. pydrake_system::

        name: FusedFuzzyIk
        input_ports:
        - desired_position
        - estimated_position
        output_ports:
        - commanded_position
        - commanded_velocity
        - joint_step
        - task_error
        - gain
        - oscillating
        - status

    The ports are those of `FuzzyIkController`, described there; `estimated_position` exists with
    `config.measured_position` only.

    Args:
        plant: a finalized plant; it is not copied.
        law: the mapping (J, dr) to a joint step.
        config: see `FuzzyIkConfig`.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        law: Law,
        config: FuzzyIkConfig,
    ) -> None:
        super().__init__()
        config.validate()
        self._kinematics = make_tool_kinematics(plant, config.frame, config.make_task())
        self._law = law
        self._supervision = GainSupervision(config.supervisor)
        self._config = dataclasses.replace(config)
        self._lower = self._kinematics.lower
        self._upper = self._kinematics.upper
        n, m = self._kinematics.num_joints, self._kinematics.task.size
        self._no_error, self._hold = np.zeros(m), np.zeros(n)

        self._desired = self._kinematics.declare_desired(self).Eval
        self._estimated = (
            self.DeclareVectorInputPort("estimated_position", n).Eval
            if config.measured_position
            else None
        )
        position = self.DeclareDiscreteState(self._kinematics.default_position)
        velocity = self.DeclareDiscreteState(n)
        self.DeclareDiscreteState([config.supervisor.initial_gain, *[0.0] * m])  # the filters
        self.DeclareDiscreteState(self._supervision.initial_memory())
        self.DeclareStateOutputPort("commanded_position", position)
        self.DeclareStateOutputPort("commanded_velocity", velocity)
        self._declare_output("joint_step", n, lambda cycle, *_: cycle.joint_step)
        self._declare_output("task_error", m, lambda cycle, *_: cycle.error)
        self._declare_output("gain", 1, lambda cycle, *_: cycle.gain)
        self.DeclareVectorOutputPort(
            "oscillating", 1, self._calc_oscillating, prerequisites_of_calc={self.xd_ticket()}
        )
        self._declare_output("status", 1, self._status)
        self.DeclarePeriodicDiscreteUpdateEvent(config.period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        set_command(self, context, check_position(position, self._lower, self._upper))

    def _declare_output(self, name: str, size: int, pick: Callable[..., Array | float]) -> None:
        """An output picked from (cycle, command, memory), computed when somebody asks."""

        def calc(context: Context, output: BasicVector) -> None:
            command, filters, memory = (context.get_discrete_state(i).value() for i in (0, 2, 3))
            cycle = self._cycle(context, command, filters, memory)
            output.get_mutable_value()[:] = pick(cycle, command, memory)

        self.DeclareVectorOutputPort(
            name,
            size,
            calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )

    def _cycle(self, context: Context, command: Array, filters: Array, memory: Array) -> _Cycle:
        """Tick k in the order of the Diagram: e, K, its filter, K·e, its filter, dθ."""
        config = self._config
        q = command if self._estimated is None else self._estimated(context)
        error, J = self._kinematics.error_and_jacobian(self._desired(context), q)
        size = length(error)
        valid = isfinite(size)
        if not valid:
            error, size = self._no_error, 0.0
        limit = config.error_limit
        gain = self._supervision.gain(memory, min(size, limit))
        filtered_gain = low_pass(gain, float(filters[0]), config.gain_smoothing)
        amplified = amplify(filtered_gain, error, size, limit)
        filtered_error = low_pass(amplified, filters[1:], config.error_smoothing)
        step = self._hold
        if valid:
            jacobian = self._kinematics.jacobian
            longest, aside = config.longest_step, config.side_step
            step = safe_step(self._law, jacobian, q, J, filtered_error, longest, aside)
        return _Cycle(valid, error, size, gain, filtered_gain, filtered_error, step)

    def _calc_oscillating(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(3).value()
        output[0] = self._supervision.oscillating(memory)

    def _status(self, cycle: _Cycle, command: Array, memory: Array) -> float:
        return controller_status(
            valid=cycle.valid,
            error=cycle.error_length,
            tolerance=self._config.tolerance,
            limited=is_limited(command, cycle.joint_step, self._lower, self._upper),
            oscillating=self._supervision.oscillating(memory),
        )

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # The values hold the present state until they are written.
        command = discrete_state.get_mutable_value(0)
        filters, memory = discrete_state.get_mutable_value(2), discrete_state.get_mutable_value(3)
        cycle = self._cycle(context, command, filters, memory)
        after = integrate(command, cycle.joint_step, self._lower, self._upper)
        discrete_state.set_value(1, (after - command) * self._config.control_rate)
        command[:] = after
        filters[0], filters[1:] = cycle.filtered_gain, cycle.filtered_error
        size = min(cycle.error_length, self._config.error_limit)
        self._supervision.remember(memory, size, cycle.joint_step)
