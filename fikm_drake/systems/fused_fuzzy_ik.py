"""The whole controller as one block, for control at 1 kHz."""

import dataclasses
from collections.abc import Callable
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
)

from fikm_drake.arrays import Array
from fikm_drake.control.gain_supervision import GainSupervision
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.restart_search import RestartState
from fikm_drake.control.status import controller_status
from fikm_drake.control.steps import amplify, length, low_pass
from fikm_drake.laws.law import Law, takes_damping
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.systems.joint_integrator import check_position, set_command
from fikm_drake.systems.restart_planner import make_restart_search
from fikm_drake.systems.safe_steps import make_safe_step
from fikm_drake.systems.tool_pose_kinematics import make_tool_kinematics


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
        - oscillating_joint
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
        kinematics = self._kinematics
        self._damped = takes_damping(law)
        self._safe_step = make_safe_step(kinematics, law, **config.step_options())
        self._supervision = GainSupervision(
            kinematics.task.size,
            kinematics.num_joints,
            config.supervisor,
            num_coordinates=kinematics.num_coordinates,
            error_limit=config.error_limit,
            tolerance=config.tolerance,
            damped=self._damped,
        )
        self._limits = JointLimits(
            kinematics.lower, kinematics.upper, period=config.period, **config.rates(kinematics)
        )
        self._restart = (
            make_restart_search(kinematics, **config.restart_options())
            if config.restart_search
            else None
        )
        self._config = dataclasses.replace(config)
        n, m = kinematics.num_joints, kinematics.task.size
        self._no_error, self._hold = np.zeros(m), np.zeros(n)

        self._desired = kinematics.declare_desired(self).Eval
        self._estimated = (
            self.DeclareVectorInputPort("estimated_position", n).Eval
            if config.measured_position
            else None
        )
        # States: the command, its velocity, the filters, the supervisor's memory, the restart_search's.
        position = self.DeclareDiscreteState(kinematics.default_position)
        velocity = self.DeclareDiscreteState(n)
        self.DeclareDiscreteState([config.supervisor.initial_gain, *[0.0] * m])
        self.DeclareDiscreteState(self._supervision.initial_memory())
        if self._restart:
            self.DeclareDiscreteState(self._restart.initial_memory())
        self.DeclareStateOutputPort("commanded_position", position)
        self.DeclareStateOutputPort("commanded_velocity", velocity)
        self._declare_output("joint_step", n, lambda cycle, _: cycle.joint_step)
        self._declare_output("task_error", m, lambda cycle, _: cycle.error)
        self._declare_output("gain", 1, lambda cycle, _: cycle.gain)
        self.DeclareVectorOutputPort(
            "oscillating", 1, self._calc_oscillating, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclareVectorOutputPort(
            "oscillating_joint", 1, self._calc_joint, prerequisites_of_calc={self.xd_ticket()}
        )
        self._declare_output("status", 1, self._status)
        self.DeclarePeriodicDiscreteUpdateEvent(config.period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        set_command(self, context, check_position(position, self._limits.lower, self._limits.upper))

    def _declare_output(
        self, name: str, size: int, pick: Callable[[_Cycle, list[Array]], Array | float]
    ) -> None:
        """An output picked from a cycle and the states before it, computed when somebody asks."""

        def calc(context: Context, output: BasicVector) -> None:
            count = context.num_discrete_state_groups()
            states = [context.get_discrete_state(i).value() for i in range(count)]
            output.get_mutable_value()[:] = pick(self._cycle(context, states), states)

        self.DeclareVectorOutputPort(
            name,
            size,
            calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )

    def _cycle(self, context: Context, states: list[Array]) -> _Cycle:
        """Tick k in the order of the Diagram: e, K, its filter, K·e, its filter, dθ."""
        config = self._config
        command, filters, memory = states[0], states[2], states[3]
        q = command if self._estimated is None else self._estimated(context)
        error, J = self._kinematics.error_and_jacobian(self._desired(context), q)
        size = length(error)
        valid = isfinite(size)
        if not valid:
            error, size = self._no_error, 0.0
        gain = self._supervision.gain(memory, size)
        filtered_gain = low_pass(gain, float(filters[0]), config.gain_smoothing)
        amplified = amplify(filtered_gain, error, size, config.error_limit)
        filtered_error = low_pass(amplified, filters[1:], config.error_smoothing)
        step = self._hold
        if valid:
            damping = self._supervision.damping(memory) if self._damped else None
            step = self._safe_step(q, J, filtered_error, damping)
            if self._restart:
                step = self._restart.step(states[4], q, step)
        return _Cycle(valid, error, size, gain, filtered_gain, filtered_error, step)

    def _calc_oscillating(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(3).value()
        output[0] = self._supervision.oscillating(memory)

    def _calc_joint(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(3).value()
        output[0] = self._supervision.oscillating_joint(memory)

    def _status(self, cycle: _Cycle, states: list[Array]) -> float:
        command, velocity, _, memory = states[:4]
        return controller_status(
            valid=cycle.valid,
            error=cycle.error_length,
            tolerance=self._config.tolerance,
            limited=self._limits.limits(command, cycle.joint_step, velocity),
            oscillating=self._supervision.oscillating(memory),
            calmed=self._supervision.calmed(memory),
            restart_search=self._restart.state(states[4]) if self._restart else RestartState.NONE,
        )

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # The values hold the present state until they are written.
        get = discrete_state.get_mutable_value
        states = [get(0), get(1), get(2), get(3), *([get(4)] if self._restart else ())]
        command, velocity, filters, memory = states[:4]
        cycle = self._cycle(context, states)
        if self._restart and cycle.valid:
            q = command if self._estimated is None else self._estimated(context)
            self._restart.remember(states[4], self._desired(context), q, cycle.error_length)
        elif self._restart:
            states[4][:] = self._restart.initial_memory()
        after = self._limits.integrate(command, cycle.joint_step, velocity)
        motion = after - command
        velocity[:] = motion * self._config.control_rate
        command[:] = after
        filters[0], filters[1:] = cycle.filtered_gain, cycle.filtered_error
        target = self._kinematics.target_coordinates(self._desired(context))
        self._supervision.remember(memory, cycle.error, motion, target)
