"""The whole controller as one block, for control at 1 kHz."""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.planning import CollisionChecker
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
)

from fikm_drake.arrays import Array
from fikm_drake.checks import check_position
from fikm_drake.control.cycle import ControlCycle, CycleState, Tick
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.native_cycle import native_cycle, packed
from fikm_drake.control.steps import length
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws import LawLike
from fikm_drake.systems.clearance_filter import FAR
from fikm_drake.systems.joint_integrator import set_command
from fikm_drake.systems.start import declare_start


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

    The ports are those of `FuzzyIkController`, described there. What a tick does is told in
    `control.cycle`; its state is this block's discrete state in three groups: command, velocity, and the
    rest of `CycleState`. Where there is the native kernel it does the ordinary cycles, `NativeCycle`.

    Args:
        plant: a finalized plant; it is not copied.
        config: see `FuzzyIkConfig`.
        law: another law than the config's.
        task: another task than the config's, an object.
        collision_checker: see `FuzzyIkController`.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import fikm_drake as fd
        >>> plant = fd.MakeDhArmPlant(fd.load_arm("arm7"))
        >>> fd.FusedFuzzyIk(plant, config=fd.FuzzyIkConfig()).GetOutputPort("joint_step").size()
        7
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        config: FuzzyIkConfig,
        law: LawLike | None = None,
        task: TaskKinematics | None = None,
        collision_checker: CollisionChecker | None = None,
    ) -> None:
        super().__init__()
        config.validate()
        config = dataclasses.replace(config)
        task = as_task(plant, config.frame, task or config.task, config.characteristic_length)
        self._cycle = ControlCycle(task, config, law, collision_checker=collision_checker)
        n, m = task.arm.num_joints, task.size
        self._desired = task.declare_target(self).Eval
        estimated = self.DeclareVectorInputPort("estimated_position", n)
        self._estimated, self._measured = estimated, config.measured_position
        self._motion, self._others = None, None
        if config.null_space_motion:
            self._motion = self.DeclareVectorInputPort("null_space_motion", n)
        if self._cycle.num_others:
            count = self._cycle.num_others
            self._others = self.DeclareVectorInputPort("obstacle_position", count)
        start = self._cycle.start(task.arm.default_position)
        self._native = native_cycle(self._cycle)
        ends = np.cumsum([0, *(len(part) for part in start[2:])]).tolist()
        self._parts = [slice(first, end) for first, end in zip(ends, ends[1:])]
        groups = [
            self.DeclareDiscreteState(part)
            for part in (start.command, start.velocity, packed(start))
        ]
        self._jerk_limit, self._window = self._cycle.jerk_limit, len(groups)
        if self._jerk_limit:
            self.DeclareDiscreteState(self._jerk_limit.start(start.command).ravel())
        declare_start(self, estimated, self._start)
        if self._jerk_limit:
            for name, calc in (
                ("commanded_position", self._jerk_limit.command),
                ("commanded_velocity", self._jerk_limit.velocity),
            ):
                self._declare_sent(name, n, calc)
        else:
            self.DeclareStateOutputPort("commanded_position", groups[0])
            self.DeclareStateOutputPort("commanded_velocity", groups[1])
        self._declare_output("joint_step", n, lambda tick: tick.joint_step)
        self._declare_output("task_error", m, lambda tick: tick.error)
        self._declare_output("gain", 1, lambda tick: tick.gain)
        self.DeclareVectorOutputPort(
            "oscillating", 1, self._calc_oscillating, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclareVectorOutputPort(
            "oscillating_joint", 1, self._calc_joint, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclareVectorOutputPort(
            "status",
            1,
            self._calc_status,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        if self._cycle.clearance:
            self._declare_output("clearance", 1, lambda tick: min(tick.cleared.distance, FAR))
            self._declare_output("blocking_bodies", 2, lambda tick: np.array(tick.cleared.pair))
        self.DeclarePeriodicDiscreteUpdateEvent(config.period, 0.0, self._update)

    def BlockingPair(self, context: Context) -> tuple[str, str]:
        """Scoped names of the bodies that push most in this block's context; empty for none."""
        clearance = self._cycle.clearance
        return clearance.names(self._tick(context)[1].cleared.pair) if clearance else ("", "")

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        arm = self._cycle.task.arm
        position = check_position(position, arm.lower, arm.upper)
        set_command(self, context, position)
        if self._jerk_limit:
            context.SetDiscreteState(self._window, self._jerk_limit.start(position).ravel())

    def _start(self, discrete_state: DiscreteValues, position: Array) -> None:
        start = self._cycle.start(position)
        for i, part in enumerate((start.command, start.velocity, packed(start))):
            discrete_state.set_value(i, part)
        if self._jerk_limit:
            discrete_state.set_value(self._window, self._jerk_limit.start(position).ravel())

    def _state(self, command: Array, velocity: Array, memory: Array) -> CycleState:
        """The state by its names; what is written there is written to the vectors."""
        return CycleState(command, velocity, *map(memory.__getitem__, self._parts))

    def _tick(self, context: Context) -> tuple[CycleState, Tick]:
        command, velocity, memory = (context.get_discrete_state(i).value() for i in range(3))
        state = self._state(command, velocity, memory)
        target, q, others = self._inputs(context, command)
        motion = _value(self._motion, context)
        if self._native and motion is None:
            tick = self._native.tick(command, velocity, memory, target, q, others)
            if tick:
                return state, tick
        tick = self._cycle.tick(state, target, q, others=others, null_space_motion=motion)
        return state, tick

    def _inputs(self, context: Context, command: Array) -> tuple[Any, Array, Array | None]:
        """The target, the joints and where obstacles are, as `ControlCycle.tick` takes them."""
        q = self._estimated.Eval(context) if self._measured else command
        return self._desired(context), q, _value(self._others, context)

    def _declare_output(self, name: str, size: int, pick: Callable[[Tick], Array | float]) -> None:
        """An output picked from a tick, computed when somebody asks."""

        def calc(context: Context, output: BasicVector) -> None:
            output.get_mutable_value()[:] = pick(self._tick(context)[1])

        self.DeclareVectorOutputPort(
            name,
            size,
            calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )

    def _declare_sent(self, name: str, size: int, sent: Callable[[Array, Array], Array]) -> None:
        """An output made of the last commands (M,n) and the newest (n,)."""

        def calc(context: Context, output: BasicVector) -> None:
            output.set_value(sent(*self._commands(context)))

        self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc={self.xd_ticket()})

    def _commands(self, context: Context) -> tuple[Array, Array]:
        """The last commands (M,n), with a limit of jerk, and the newest (n,)."""
        newest = context.get_discrete_state(0).value()
        return context.get_discrete_state(self._window).value().reshape(-1, len(newest)), newest

    def _settled(self, context: Context, tick: Tick) -> bool:
        """False while what goes out, smoothed, is not within the tolerance as the newest command is."""
        tolerance = self._cycle.config.tolerance
        if not self._jerk_limit or self._measured or not tick.error_length <= tolerance:
            return True
        sent = self._jerk_limit.command(*self._commands(context))
        return length(self._cycle.task.error(self._desired(context), sent)) <= tolerance

    def _calc_oscillating(self, context: Context, output: BasicVector) -> None:
        output[0] = self._cycle.supervision.oscillating(self._supervision(context))

    def _calc_joint(self, context: Context, output: BasicVector) -> None:
        output[0] = self._cycle.supervision.oscillating_joint(self._supervision(context))

    def _supervision(self, context: Context) -> Array:
        state = self._state(*(context.get_discrete_state(i).value() for i in range(3)))
        return state.supervision

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        state, tick = self._tick(context)
        known = self._estimated.HasValue(context)
        measured = self._estimated.Eval(context) if known else None
        settled = self._settled(context, tick)
        output[0] = self._cycle.status(state, tick, measured, settled=settled)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # The values hold the present state until they are written.
        get = discrete_state.get_mutable_value
        command, velocity, memory = get(0), get(1), get(2)
        target, q, others = self._inputs(context, command)
        motion = _value(self._motion, context)
        if self._jerk_limit:
            # A view: the last commands.
            self._jerk_limit.remember(get(self._window).reshape(-1, len(command)), command)
        if self._native and motion is None:
            if self._native.advance(command, velocity, memory, target, q, others):
                return
        state = self._state(command, velocity, memory)
        tick = self._cycle.tick(state, target, q, others=others, null_space_motion=motion)
        self._cycle.advance(state, target, q, tick, others)


def _value(port: InputPort | None, context: Context) -> Array | None:
    """What a port that need not be there nor connected reads."""
    return port.Eval(context) if port is not None and port.HasValue(context) else None
