"""A control cycle by the native kernel, wherever nothing out of the ordinary happens in it."""

import threading
from typing import Any

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import UNTOUCHED, ControlCycle, CycleState, Tick
from fikm_drake.control.native_safe_step import step_options
from fikm_drake.kinematics.native.kernel import Kernel, address, kernel, writable_address
from fikm_drake.kinematics.task_kinematics import PlantTask


class NativeCycle(threading.local):
    """`ControlCycle.tick` and `advance` as one call, for the configurations that `native_cycle` takes.

    It leaves to them each cycle in which an input is not finite, a step is too long, a limit takes a part
    of it away, or the law's equations are nearly singular. The buffers are one set for each thread.

    Args:
        loaded: the kernel.
        cycle: what it does the same as.
        task: the cycle's task.
        options: as `native/cycle.h` lists them, with the chain.
    """

    def __init__(
        self,
        loaded: Kernel,
        cycle: ControlCycle,
        task: PlantTask,
        options: Array,
    ) -> None:
        self._cycle, self._loaded, self._options, self._task = cycle, loaded, options, task
        m, n = task.size, task.arm.num_joints
        self._m, self._n = m, n
        state = cycle.start(task.arm.default_position)
        self._command, self._velocity, self._memory = np.zeros(n), np.zeros(n), packed(state)
        self._target = np.zeros((3, 4) if task.port == "desired_pose" else m)
        self._q, self._out = np.zeros(n), np.zeros(3 + 2 * m + 2 * n)
        self._numbers = task.target_numbers
        self._run = loaded.cycle
        self._at_options, self._at_target = address(options), address(self._target)
        self._at_q = address(self._q) if cycle.config.measured_position else None
        own = self._command, self._velocity, self._memory, self._out
        self._at = tuple(map(address, own))

    def __reduce__(self) -> tuple:
        """Pickled as what it was made of: addresses hold in one process only."""
        return native_cycle, (self._cycle,)

    def advance(
        self, command: Array, velocity: Array, memory: Array, target: Any, q: Array
    ) -> bool:
        """A tick, written into the state.

        Args:
            command: of the state (n,); it and the next two are changed.
            velocity: of the state (n,).
            memory: the rest of the state, see `packed`.
            target: as the task takes it.
            q: joint positions (n,): the command, or measured [rad or m].

        Returns:
            False if this cycle is not one of the ordinary; then nothing is changed.
        """
        self._target[:] = self._numbers(target)
        if self._at_q:
            self._q[:] = q
        return bool(
            self._run(
                self._at_options,
                writable_address(command),
                writable_address(velocity),
                writable_address(memory),
                self._at_target,
                self._at_q,
                None,
            )
        )

    def tick(self, command: Array, memory: Array, target: Any, q: Array) -> Tick | None:
        """A tick; nothing is changed. The arguments are those of `advance`; None for False."""
        self._target[:] = self._numbers(target)
        self._command[:], self._memory[:] = command, memory
        if self._at_q:
            self._q[:] = q
        at_command, at_velocity, at_memory, at_out = self._at
        state = at_command, at_velocity, at_memory
        if not self._run(self._at_options, *state, self._at_target, self._at_q, at_out):
            return None
        size, gain, filtered = self._out[:3].tolist()
        m, n = self._m, self._n
        ends = np.cumsum([3, m, m, n]).tolist()
        error, filtered_error, step, after = np.split(self._out.copy(), ends)[1:]
        return Tick(
            *(True, error, size, gain, filtered, filtered_error),
            *(step, after, step, False, UNTOUCHED),
        )


def packed(state: CycleState) -> Array:
    """All of a state but command and velocity as one vector."""
    return np.concatenate(state[2:])


def native_cycle(cycle: ControlCycle, *, free: bool = False) -> NativeCycle | None:
    """The kernel's cycle for an ordinary configuration, or None: `ControlCycle` does it.

    Ordinary are tasks of the tool's position and orientation under the indirect fuzzy mapping, with one
    iteration or with as many as there are rows, without limits of acceleration, obstacles, secondary
    motion and search for another posture.

    Args:
        cycle: the cycle.
        free: obstacles are the caller's: they must take nothing away of the step.
    """
    loaded, task, law, config = kernel(), cycle.task, cycle.law, cycle.config
    if not (loaded and isinstance(task, PlantTask) and cycle.supervision.native):
        return None
    if cycle.restart or (cycle.clearance and (not free or cycle.num_others)):
        return None
    options = step_options(task, law, cycle.safe_step, cycle.limits)
    if options is None:
        return None
    numbers = [config.error_limit, config.gain_smoothing, config.error_smoothing]
    numbers += [1.0 / config.period, config.measured_position, cycle.damped]
    whole = np.concatenate([options, np.array(numbers, dtype=float), cycle.supervision.options])
    return NativeCycle(loaded, cycle, task, whole)
