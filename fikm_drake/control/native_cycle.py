"""A control cycle by the native kernel, wherever nothing out of the ordinary happens in it."""

import threading
from typing import Any

import numpy as np
from pydrake.planning import RobotClearance

from fikm_drake.arrays import Array
from fikm_drake.control.clear_step import LOOKS
from fikm_drake.control.clearance import ClearanceInfo, info_of, may_ask
from fikm_drake.control.cycle import UNTOUCHED, ControlCycle, CycleState, Tick
from fikm_drake.control.native_safe_step import step_options
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel, address, kernel
from fikm_drake.kinematics.native.native_clearance import CLEARED, WANT_LOOK
from fikm_drake.kinematics.task_kinematics import PlantTask

MOST_ROWS = 6
SEARCH_LEFT, POSTURE_PASSED = 2, 3
"""What the kernel answers of a cycle whose restart search Python goes on with; 0: it leaves all to Python."""
PARTS = {
    "numbers": 4,
    "error": MOST_ROWS,
    "filtered_error": MOST_ROWS,
    **dict.fromkeys(("asked", "step", "after"), MOST_JOINTS),
    "J": MOST_ROWS * MOST_JOINTS,
    **dict.fromkeys(("low", "high"), MOST_JOINTS),
}
"""`Cycle` of native/cycle.h: its parts and how many doubles they are."""


class NativeCycle(threading.local):
    """`ControlCycle.tick` and `advance` as one call, for the configurations that `native_cycle` takes.

    It leaves to them each cycle in which an input is not finite or the law's equations are nearly singular.
    A restart search that finds nothing to do costs what its watch does. The buffers are one set for each
    thread.

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
        state = cycle.start(task.arm.default_position)
        self._restart = cycle.restart
        self._search = search_place(state)
        self._others = slice(self._search.stop, None)
        self._among = None
        if cycle.clearance and cycle.clearance.native:
            self._among = cycle.clearance.near, cycle.clearance.native
        self._used = slice(0, self._search.start + (4 + n if cycle.restart else 0))
        self._command, self._velocity = np.zeros(n), np.zeros(n)
        self._memory = np.zeros(self._used.stop)
        self._target = np.zeros((3, 4) if task.port == "desired_pose" else m)
        self._q, self._posture, self._end = np.zeros(n), np.zeros(n), np.zeros(n)
        self._known: tuple[Array, Array | None, int, bytes | None] | None = None
        self._numbers = task.target_numbers
        self._run, self._ask, self._go = loaded.cycle, loaded.ask_clear, loaded.cycle_clear
        self._computed = np.zeros(sum(PARTS.values()))
        starts = np.cumsum([0, *PARTS.values()]).tolist()[1:6]
        self._parts = [slice(a, a + k) for a, k in zip(starts, (m, m, n, n, n))]
        own = self._command, self._velocity, self._memory
        self._at_inputs = tuple(map(address, (options, *own, self._target, self._q)))
        self._at_posture, self._at_computed = address(self._posture), address(self._computed)

    def __reduce__(self) -> tuple:
        """Pickled as what it was made of: addresses hold in one process only."""
        return native_cycle, (self._cycle,)

    def advance(
        self,
        command: Array,
        velocity: Array,
        memory: Array,
        target: Any,
        q: Array,
        others: Array | None = None,
    ) -> bool:
        """A tick, written into the state.

        Args:
            command: of the state (n,); it and the next two are changed.
            velocity: of the state (n,).
            memory: the rest of the state, see `packed`.
            target: as the task takes it.
            q: joint positions (n,): the command, or measured [rad or m].
            others: where obstacles are (p,), as of `Clearance`; None: where they are by default.

        Returns:
            False if this cycle is not one of the ordinary; then nothing is changed.
        """
        done, _ = self._do(command, velocity, memory, target, q, others, False)
        if not done:
            return False
        command[:], velocity[:], memory[self._used] = self._command, self._velocity, self._memory
        if self._restart and done == SEARCH_LEFT:
            size = float(self._computed[0])
            self._restart.remember(memory[self._search], target, self._q.copy(), size, others)
        elif self._restart and done == POSTURE_PASSED:
            self._restart.pass_posture(memory[self._search])
        if others is not None:
            memory[self._others] = others
        return True

    def tick(
        self,
        command: Array,
        velocity: Array,
        memory: Array,
        target: Any,
        q: Array,
        others: Array | None = None,
    ) -> Tick | None:
        """A tick; nothing is changed. The arguments are those of `advance`; None for False."""
        done, cleared = self._do(command, velocity, memory, target, q, others, True)
        if not done:
            return None
        computed = self._computed.copy()
        error, filtered_error, asked, step, after = [computed[part] for part in self._parts]
        size, gain, filtered, limited = computed[:4].tolist()
        return Tick(
            *(True, error, size, gain, filtered, filtered_error, step, after, asked),
            limited=bool(limited),
            cleared=cleared,
        )

    def _do(
        self,
        command: Array,
        velocity: Array,
        memory: Array,
        target: Any,
        q: Array,
        others: Array | None,
        peek: bool,
    ) -> tuple[int, ClearanceInfo]:
        """What the kernel answers, which has the state of its own, and what obstacles did."""
        self._target[:], self._q[:] = self._numbers(target), q
        # Sooner done than to ask for addresses.
        self._command[:], self._velocity[:] = command, velocity
        self._memory[:] = memory[self._used]
        at_posture = None
        if self._restart:
            posture = self._restart.posture(memory[self._search])
            if posture is not None:
                self._posture[:], at_posture = posture, self._at_posture
        if self._among is None:
            return self._run(*self._at_inputs, at_posture, peek, self._at_computed), UNTOUCHED
        (near, clear), q = self._among, self._q
        if not may_ask(q, others):
            return 0, UNTOUCHED
        found, after, moved = None, others, None
        if peek or not self._knows(q, others, memory[self._others]):
            found = near.ask(q, others)
            after, moved = near.moving(q, found, others, memory[self._others])
            if not clear.read(found, near.padded, moved):
                return 0, UNTOUCHED
            if peek and moved is None:  # `advance` will follow
                self._know(q, others)
        answer = self._ask(*self._at_inputs, at_posture, clear.at, self._at_computed)
        if answer == WANT_LOOK:

            def look(step: Array) -> RobotClearance:
                np.add(q, step, out=self._end)
                return near.ask(self._end, after)

            answer = clear.look(look, LOOKS)
            if moved is None:  # the next cycle begins there
                self._know(self._end, others)
        if answer != CLEARED:
            return 0, UNTOUCHED
        done = self._go(*self._at_inputs, at_posture, clear.at, peek, self._at_computed)
        return done, info_of(clear.answer(), found) if found is not None and peek else UNTOUCHED

    def _know(self, q: Array, others: Array | None) -> None:
        """The kernel has what the checker says of a posture (n,), until it gets something else."""
        if self._among:
            near, clear = self._among
            seen = None if others is None else others.copy()
            self._known = q.copy(), seen, clear.taken, near.world

    def _knows(self, q: Array, others: Array | None, before: Array) -> bool:
        """True if it has what the checker would say of this cycle's posture, and nothing moves."""
        if self._among is None or self._known is None:
            return False
        near, clear = self._among
        posture, seen, taken, world = self._known
        if taken != clear.taken or not np.array_equal(posture, q):
            return False
        if others is None or seen is None:
            same = others is seen
        else:
            same = np.array_equal(others, seen) and np.array_equal(others, before)
        return same and world is not None and world == near.world


def packed(state: CycleState) -> Array:
    """All of a state but command and velocity as one vector."""
    return np.concatenate(state[2:])


def search_place(state: CycleState) -> slice:
    """Where the memory of a restart search is in `packed`; empty without one."""
    start = len(state.gain) + len(state.error) + len(state.supervision)
    return slice(start, start + len(state.restart))


def native_cycle(cycle: ControlCycle) -> NativeCycle | None:
    """The kernel's cycle for an ordinary configuration, or None: `ControlCycle` does it.

    Ordinary are tasks of the tool's position and orientation under the indirect fuzzy mapping, with one
    iteration or with as many as there are rows.
    """
    loaded, task, law, config = kernel(), cycle.task, cycle.law, cycle.config
    if not (loaded and isinstance(task, PlantTask) and cycle.supervision.native):
        return None
    if cycle.clearance and cycle.clearance.native is None:
        return None
    options = step_options(task, law, cycle.safe_step, cycle.limits)
    if options is None:
        return None
    numbers = [config.error_limit, config.gain_smoothing, config.error_smoothing]
    numbers += [1.0 / config.period, config.measured_position, cycle.damped]
    search = [0.0] * 10
    if cycle.restart:
        start = cycle.start(task.arm.default_position)
        search = [search_place(start).start, *cycle.restart.numbers]
    parts = options, np.array(numbers, dtype=float), cycle.supervision.options, np.array(search)
    return NativeCycle(loaded, cycle, task, np.concatenate(parts))
