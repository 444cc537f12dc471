"""The whole controller as one block, for control at 1 kHz."""

import dataclasses
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import Value
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from fikm_drake.kinematics.task import Task
from fikm_drake.laws.controller_status import controller_status
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.gain_supervision import GainSupervision
from fikm_drake.laws.steps import all_finite, amplify, difference, integrate, low_pass
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.systems.joint_integrator import check_position
from fikm_drake.systems.tool_kinematics import ToolKinematics


class _Cycle(NamedTuple):
    """What one control cycle computes, before its update."""

    valid: bool
    error: list[float]
    gain: float
    oscillating: bool
    joint_step: list[float]
    position: list[float]
    limited: bool
    memory: list[float]


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

        self._desired = self.DeclareVectorInputPort("desired_position", m)
        self._estimated = (
            self.DeclareVectorInputPort("estimated_position", n) if config.measured_position else None
        )
        supervision = self._supervision.initial_state()
        position = self.DeclareDiscreteState(self._kinematics.default_position)
        velocity = self.DeclareDiscreteState(n)
        # The filtered gain, the filtered error and the supervisor's memory.
        self.DeclareDiscreteState([supervision[0], *[0.0] * m, *supervision])
        self._scratch = self._kinematics.declare_scratch(self)
        self._cycle = self.DeclareCacheEntry(
            description="control cycle",
            value_producer=ValueProducer(allocate=lambda: Value[object](()), calc=self._calc_cycle),
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclareStateOutputPort("commanded_position", position)
        self.DeclareStateOutputPort("commanded_velocity", velocity)
        self._declare_output("joint_step", n, lambda cycle: cycle.joint_step)
        self._declare_output("task_error", m, lambda cycle: cycle.error)
        self._declare_output("gain", 1, lambda cycle: [cycle.gain])
        self._declare_output("oscillating", 1, lambda cycle: [float(cycle.oscillating)])
        self._declare_output("status", 1, lambda cycle: [float(self._status(cycle))])
        self.DeclarePeriodicDiscreteUpdateEvent(config.period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
        """
        n = self._kinematics.num_joints
        context.SetDiscreteState(0, check_position(position, n))
        context.SetDiscreteState(1, np.zeros(n))

    def _declare_output(self, name: str, size: int, pick) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.set_value(pick(self._cycle.Eval(context)))

        self.DeclareVectorOutputPort(
            name, size, calc, prerequisites_of_calc={self._cycle.ticket()}
        )

    def _calc_cycle(self, context: Context, cycle: Value) -> None:
        """Tick k in the order of the Diagram: e, K, its filter, K·e, its filter, dθ, q."""
        kinematics, supervision = self._kinematics, self._supervision
        scratch = self._scratch.Eval(context)
        command = context.get_discrete_state(0).value()
        memory = context.get_discrete_state(2).value().tolist()
        m = kinematics.task.size
        filtered_gain, filtered_error, state = memory[:1], memory[1 : 1 + m], memory[1 + m :]

        q = command if self._estimated is None else self._estimated.Eval(context)
        error = difference(self._desired.Eval(context).tolist(), kinematics.position(scratch, q))
        valid = all_finite(error)
        if not valid:
            error = [0.0] * m
        length = min(hypot(*error), self._error_limit)
        gain = supervision.gain(state, length)
        oscillating = supervision.oscillating(state)
        filtered_gain = low_pass([gain], filtered_gain, self._config.gain_smoothing)
        amplified = amplify(filtered_gain[0], error, self._error_limit)
        filtered_error = low_pass(amplified, filtered_error, self._config.error_smoothing)
        step = [0.0] * kinematics.num_joints
        if valid:
            J = kinematics.jacobian(scratch, q)
            proposed = self._law.step(J, filtered_error)
            step = proposed if all_finite(proposed) else step
        before = command.tolist()
        after = integrate(before, step, self._lower, self._upper)
        limited = after != [a + b for a, b in zip(before, step)]
        state = supervision.advance(state, length, gain, step)
        memory = [*filtered_gain, *filtered_error, *state]
        cycle.set_value(_Cycle(valid, error, gain, oscillating, step, after, limited, memory))

    def _status(self, cycle: _Cycle) -> int:
        return controller_status(
            valid=cycle.valid,
            error=hypot(*cycle.error),
            tolerance=self._config.tolerance,
            limited=cycle.limited,
            oscillating=cycle.oscillating,
        )

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        cycle = self._cycle.Eval(context)
        before = context.get_discrete_state(0).value().tolist()
        rate = self._config.control_rate
        discrete_state.get_mutable_value(0)[:] = cycle.position
        discrete_state.get_mutable_value(1)[:] = [
            (b - a) * rate for a, b in zip(before, cycle.position)
        ]
        discrete_state.get_mutable_value(2)[:] = cycle.memory
