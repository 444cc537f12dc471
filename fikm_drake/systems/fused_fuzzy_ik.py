"""The whole controller as one block, for control at 1 kHz."""

import dataclasses
from collections.abc import Callable
from math import hypot
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

from fikm_drake.kinematics.task import Task
from fikm_drake.laws.controller_status import controller_status
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.gain_supervision import GainSupervision
from fikm_drake.laws.steps import (
    all_finite,
    amplify,
    difference,
    integrate,
    is_limited,
    low_pass,
)
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.systems.joint_integrator import check_position
from fikm_drake.systems.tool_kinematics import ToolKinematics


Array = NDArray[np.float64]


class _Cycle(NamedTuple):
    """What one control cycle computes from the state and the inputs."""

    valid: bool
    error: list[float]
    gain: float
    filtered_gain: float
    filtered_error: list[float]
    joint_step: list[float]


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
        law: FuzzyMapping,
        config: FuzzyIkConfig,
    ) -> None:
        super().__init__()
        config.validate()
        self._kinematics = ToolKinematics(plant, config.frame, Task(config.task))
        self._law = law
        self._supervision = GainSupervision(config.supervisor)
        self._config = dataclasses.replace(config)
        self._error_limit = config.longest_error
        self._lower = self._kinematics.lower.tolist()
        self._upper = self._kinematics.upper.tolist()
        n, m = self._kinematics.num_joints, self._kinematics.task.size
        self._num_rows = m
        self._hold = [0.0] * n

        self._desired = self.DeclareVectorInputPort("desired_position", m)
        self._estimated = (
            self.DeclareVectorInputPort("estimated_position", n) if config.measured_position else None
        )
        supervision = self._supervision.initial_state()
        position = self.DeclareDiscreteState(self._kinematics.default_position)
        velocity = self.DeclareDiscreteState(n)
        # The filtered gain, the filtered error and the supervisor's memory.
        self.DeclareDiscreteState([config.supervisor.initial_gain, *[0.0] * m, *supervision])
        self.DeclareStateOutputPort("commanded_position", position)
        self.DeclareStateOutputPort("commanded_velocity", velocity)
        self._declare_output("joint_step", n, lambda cycle, *_: cycle.joint_step)
        self._declare_output("task_error", m, lambda cycle, *_: cycle.error)
        self._declare_output("gain", 1, lambda cycle, *_: [cycle.gain])
        self._declare_output("oscillating", 1, self._oscillating)
        self._declare_output("status", 1, self._status)
        self.DeclarePeriodicDiscreteUpdateEvent(config.period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
        """
        n = self._kinematics.num_joints
        context.SetDiscreteState(0, check_position(position, n))
        context.SetDiscreteState(1, np.zeros(n))

    def _declare_output(self, name: str, size: int, pick: Callable[..., list[float]]) -> None:
        """An output that is picked from (cycle, commanded position, memory) when somebody asks."""

        def calc(context: Context, output: BasicVector) -> None:
            command = context.get_discrete_state(0).value()
            memory = context.get_discrete_state(2).value().tolist()
            cycle = self._cycle(context, command, memory)
            output.get_mutable_value()[:] = pick(cycle, command.tolist(), memory)

        self.DeclareVectorOutputPort(
            name,
            size,
            calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )

    def _cycle(self, context: Context, command: Array, memory: list[float]) -> _Cycle:
        """Tick k in the order of the Diagram: e, K, its filter, K·e, its filter, dθ."""
        config, m = self._config, self._num_rows
        q = command if self._estimated is None else self._estimated.Eval(context)
        actual, J = self._kinematics.position_and_jacobian(q)
        error = difference(self._desired.Eval(context).tolist(), actual)
        valid = all_finite(error)
        if not valid:
            error = [0.0] * m
        gain = self._supervision.gain(memory[1 + m :], self._length(error))
        filtered_gain = low_pass(gain, memory[0], config.gain_smoothing)
        amplified = amplify(filtered_gain, error, self._error_limit)
        smoothing = config.error_smoothing
        filtered_error = [low_pass(v, p, smoothing) for v, p in zip(amplified, memory[1 : 1 + m])]
        step = self._law.step(J, filtered_error) if valid else self._hold
        if not all_finite(step):
            step = self._hold
        return _Cycle(valid, error, gain, filtered_gain, filtered_error, step)

    def _length(self, error: list[float]) -> float:
        return min(hypot(*error), self._error_limit)

    def _oscillating(self, cycle: _Cycle, command: list[float], memory: list[float]) -> list[float]:
        return [float(self._supervision.oscillating(memory[1 + self._num_rows :]))]

    def _status(self, cycle: _Cycle, command: list[float], memory: list[float]) -> list[float]:
        status = controller_status(
            valid=cycle.valid,
            error=hypot(*cycle.error),
            tolerance=self._config.tolerance,
            limited=is_limited(command, cycle.joint_step, self._lower, self._upper),
            oscillating=bool(self._oscillating(cycle, command, memory)[0]),
        )
        return [float(status)]

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # The values hold the current state until we write them.
        command = discrete_state.get_mutable_value(0)
        memory = discrete_state.get_mutable_value(2)
        before, remembered = command.tolist(), memory.tolist()
        cycle = self._cycle(context, command, remembered)
        after = integrate(before, cycle.joint_step, self._lower, self._upper)
        rate = self._config.control_rate
        command[:] = after
        discrete_state.get_mutable_value(1)[:] = [(b - a) * rate for a, b in zip(before, after)]
        supervision = self._supervision.advance(
            remembered[1 + self._num_rows :], self._length(cycle.error), cycle.joint_step
        )
        memory[:] = [cycle.filtered_gain, *cycle.filtered_error, *supervision]
