"""The way out where no step leads nearer: another posture, found by search and driven to."""

from collections.abc import Callable
from math import inf, pi
from typing import Any

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.checks import check_period, check_positive
from fikm_drake.control.clear_way import ClearWay
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.limit_weights import LimitWeights
from fikm_drake.control.native_descent import native_descent
from fikm_drake.control.restart_starts import STARTS, RestartStarts
from fikm_drake.control.restart_state import RestartState
from fikm_drake.control.safe_step import SafeStep, aside
from fikm_drake.control.steps import length
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

ErrorAndJacobian = Callable[[Any, Array], tuple[Array, Array]]

AT_REST = 0.01
"""An arm that moves less in a cycle than this times the error is at rest [rad/m]."""
APPROACH = 0.01
"""The target is approached while the least error falls by this fraction [-]..."""
PATIENCE = 40
"""...within this number of cycles, of which one at rest counts as three; then the search begins [-]."""
LOOKS, LONG = 4, 0.01
"""Steps of the search in a control cycle that is so long or longer [-, s]; in a shorter one they are less."""
WINDOW, PROGRESS = 6, 0.3
"""A start of the search is given up unless `WINDOW` steps take away this fraction of its error [-]."""
AGAIN = 25
"""Times that a way to the postures so far is searched for after the last start [-]."""
ERROR_LIMIT = 0.1
"""A longer error counts as this long in the search [of the longest that there is]."""
DAMPING = 0.05
"""Of the search's steps where an error is that long; it falls with its root [-]."""
ZONE = 0.05
"""Zone of the joint limits in the search [rad or m]."""
NEAR = 1e-3
"""Distance at which a posture is reached [rad or m]."""
PASSED = 0.02
"""Distance at which a posture in between is passed [rad or m]."""
LANDING = 0.25
"""Of what is left of a way a cycle takes at most this fraction, so that filters of the error settle [-]."""
LOST = 10.0
"""A posture with a longer error is none of the target any more [tolerances]."""
LATE = 3.0
"""A way takes at most this many times as long as it should [-]."""


class RestartSearch:
    """Leaves dead points and local minima at joint limits, which no local law can.

    When the law does not approach a target that rests, a virtual arm searches for a posture that solves the
    task inside the joint limits, from a small step aside first and then from postures spread over
    the joints' ranges: first those whose tool is near and that are soon reached. It takes a few steps a
    cycle, so a cycle's cost is bounded. The joints then move there in a straight line at `pace`, without
    whole turns that their limits let them leave out, and the law takes over again. If none is found, the
    arm stays; the next search waits until the error has changed. The search is the same each time: its
    starts are fixed numbers.

    What it remembers is a vector that the caller keeps: the state; cycles without approach, or steps of
    the search; the last error, or the start; the least error, or that at the last look at the search's
    progress; then a posture (n,), of the last cycle or of the search.

    With a `clearance` the posture and the way to it are clear, looked at as finely as the joints move: the
    straight way, or one with bends that is searched for (`ClearWay`); else the search for a posture goes
    on, and what it found so far is kept.

    Args:
        kinematics: (target, q) to the task error (m,) and Jacobian (m,n).
        num_rows: m.
        lower: lower joint limits (n,) [rad or m]; −inf for none.
        upper: upper joint limits (n,) [rad or m]; inf for none.
        tolerance: an error up to this is solved [m].
        pace: largest joint motion in a cycle on the way [rad or m].
        turning: joints that take the same posture after a whole turn (n,); None: none does.
        longest_error: that the task can have, about, by which errors are judged [m].
        limits: of the joints, which shorten a step of the way as a whole; None: only the pace does.
        clearance: what the way keeps clear of; None: nothing.
        looks: steps of the search in a control cycle [-].
        task: whose error and Jacobian `kinematics` tells; then the kernel may take steps.
    """

    def __init__(
        self,
        kinematics: ErrorAndJacobian,
        num_rows: int,
        *,
        lower: Array,
        upper: Array,
        tolerance: float,
        pace: float,
        turning: Bools | None = None,
        longest_error: float = 2.0,
        limits: JointLimits | None = None,
        clearance: Clearance | None = None,
        looks: int = LOOKS,
        task: TaskKinematics | None = None,
    ) -> None:
        self._limits, self._error_limit = limits, ERROR_LIMIT * longest_error
        self._own, self._rest = slice(4, 4 + len(lower)), slice(4 + len(lower), None)
        self._kinematics = kinematics
        self._lower, self._upper = lower, upper
        self._tolerance, self._pace, self._looks = tolerance, pace, looks
        law = FuzzyMapping(iterations=max(2, num_rows), damping=1e-3, row_floor=0.01)
        self._search_step = SafeStep(law, longest=1.0, limits=LimitWeights(lower, upper, ZONE))
        self._native = None
        if task is not None:
            numbers = tolerance, self._error_limit, DAMPING, WINDOW, PROGRESS
            self._native = native_descent(task, law, self._search_step, numbers)
        self._starts = RestartStarts(
            self._errors,
            lower=lower,
            upper=upper,
            pace=pace,
            turning=turning,
            longest_error=longest_error,
            limits=limits,
        )
        self._way = None
        if clearance is not None:
            self._way = ClearWay(clearance, pace=pace, lower=lower, upper=upper)

    def initial_memory(self) -> Array:
        """The memory before the first cycle."""
        way = self._way.initial_memory() if self._way else np.zeros(0)
        return np.concatenate([np.zeros(4 + len(self._lower)), way])

    def state(self, memory: Array) -> RestartState:
        """What the restart search does."""
        return RestartState(int(memory[0]))

    @property
    def numbers(self) -> tuple[float, ...]:
        """What the native kernel takes to watch the law and to drive."""
        watching = self._tolerance, AT_REST, APPROACH, PATIENCE
        return *watching, self._pace, LANDING, NEAR, PASSED, LOST

    def posture(self, memory: Array) -> Array | None:
        """The posture (n,) to which the joints go now; None: the law leads."""
        if memory.item(0) != RestartState.UNDERWAY:
            return None
        via = self._way.via(memory[self._rest]) if self._way else None
        return memory[self._own] if via is None else via

    def pass_posture(self, memory: Array) -> None:
        """The joints are at the posture to which they went: on to the next, if there is one."""
        if self._way and self._way.via(memory[self._rest]) is not None:
            self._way.pass_via(memory[self._rest])

    def step(self, memory: Array, q: Array, joint_step: Array) -> Array:
        """The joint step (n,): on the way that to the posture, else the law's `joint_step`."""
        posture = self.posture(memory)
        if posture is None:
            return joint_step
        way = posture - q
        way = way * min(LANDING, self._pace / max(float(np.abs(way).max()), 1e-300))
        return self._limits.shorten(self._limits.brakeable(way)) if self._limits else way

    def remember(
        self, memory: Array, desired: Any, q: Array, error: float, others: Array | None = None
    ) -> None:
        """Write a cycle into `memory`: watch the law, search, or see whether the way is done.

        Args:
            memory: what is changed.
            desired: the target, as `kinematics` takes it.
            q: joint positions (n,) [rad or m].
            error: length of the task error [m].
            others: where obstacles are (p,), see `Clearance`; None: where they are by default.
        """
        state = memory.item(0)
        if not error < inf or (error <= self._tolerance and state != RestartState.UNDERWAY):
            memory[:4] = 0.0
        elif state == RestartState.NONE:
            self._watch(memory, desired, q, error)
        elif state == RestartState.SEARCHING:
            self._search(memory, desired, q, error, others)
        elif state == RestartState.UNDERWAY:
            self._arrive(memory, desired, q)
        elif abs(error - memory[3]) > max(self._tolerance, 0.1 * memory[3]):
            memory[:4] = 0.0

    def _watch(self, memory: Array, desired: Any, q: Array, error: float) -> None:
        """Begin to search if the law does not approach a target that rests."""
        _, quiet, last_error, least = memory[:4]
        moved = abs(length(self._kinematics(desired, memory[self._own])[0]) - last_error)
        if moved > 0.1 * self._tolerance or error < (1.0 - APPROACH) * least:
            quiet, least = 0, error
        else:
            quiet += 3 if length(q - memory[self._own]) < AT_REST * error else 1
        if quiet < PATIENCE:
            memory[1:4], memory[self._own] = (quiet, error, least), q
        else:
            memory[:4], memory[self._rest] = (RestartState.SEARCHING, 0, 0, error), 0.0
            memory[self._own] = self._aside(q)

    def _search(
        self, memory: Array, desired: Any, q: Array, error: float, others: Array | None
    ) -> None:
        """The cycle's steps of the search; the kernel takes those that only go down."""
        left = self._looks
        while left and memory.item(0) == RestartState.SEARCHING:
            left -= self._native(memory, desired, left) if self._native else 0
            if left:
                self._look(memory, desired, q, error, others)
                left -= 1

    def _look(
        self, memory: Array, desired: Any, q: Array, error: float, others: Array | None
    ) -> None:
        """One step of the search."""
        posture = memory[self._own]
        dr, J = self._kinematics(desired, posture)
        size = length(dr)
        if size <= 0.5 * self._tolerance:
            posture[:] = self._starts.unwound(posture, q)
            legs = [(q, posture)]
            if self._way:
                found = self._way.look(memory[self._rest], q, posture, others)
                if found is False:
                    self._start_again(memory, desired, q, error)
                if not found:
                    return
                posture[:] = self._way.end(memory[self._rest])
                legs = self._way.legs(memory[self._rest], q)
            cycles = sum(self._starts.cycles(a, b) for a, b in legs)
            memory[:3] = RestartState.UNDERWAY, -LATE * cycles - PATIENCE, 0
            return
        if memory[1] % WINDOW == 0:
            if memory[1] and size > (1.0 - PROGRESS) * min(memory[3], self._error_limit):
                self._start_again(memory, desired, q, error)
                return
            memory[3] = size
        if size > self._error_limit:
            dr = dr * (self._error_limit / size)
        damping = DAMPING * min(size / self._error_limit, 1.0) ** 0.5
        step = self._search_step(posture, J, dr, damping)
        memory[self._own] = np.clip(posture + step, self._lower, self._upper)
        memory[1] += 1

    def _start_again(self, memory: Array, desired: Any, q: Array, error: float) -> None:
        start = int(memory[2])
        memory[1:4] = 0, start + 1, 0
        if start >= STARTS:
            goal = self._way.goal(memory[self._rest]) if self._way else None
            if goal is None or start >= STARTS + AGAIN:
                memory[:4] = RestartState.STUCK, 0, 0, error
            else:
                memory[self._own] = goal
            return
        memory[self._own] = self._starts(desired, q)[start]

    def _arrive(self, memory: Array, desired: Any, q: Array) -> None:
        """Leave it to the law at the end of the way, if it takes too long or if the target moved."""
        posture = self.posture(memory)
        memory[1] += 1
        if posture is not None and np.abs(posture - q).max() <= PASSED:
            self.pass_posture(memory)
        lost = length(self._kinematics(desired, memory[self._own])[0]) > LOST * self._tolerance
        if memory[1] >= 0 or lost or np.abs(memory[self._own] - q).max() <= NEAR:
            memory[:4] = 0.0

    def _errors(self, desired: Any, postures: Array) -> Array:
        """Lengths of the error (N,) at postures (N,n) [m]."""
        if self._native:
            return self._native.sizes(desired, postures)
        return np.array([length(self._kinematics(desired, p)[0]) for p in postures])

    def _aside(self, q: Array) -> Array:
        """A posture beside q, the same each time."""
        return np.clip(q + 0.1 * aside(len(q)), self._lower, self._upper)


def make_restart_search(
    task: TaskKinematics,
    *,
    tolerance: float,
    speed: float,
    period: float,
    limits: JointLimits | None = None,
    clearance: Clearance | None = None,
) -> RestartSearch:
    """The restart search of a task's arm.

    Args:
        task: what counts.
        tolerance: a task error up to this is no reason for a search [m].
        speed: of the fastest joint on the way [rad/s or m/s].
        period: of the control cycle [s].
        limits: of the joints; None: none.
        clearance: what the way keeps clear of; None: nothing.

    Raises:
        ValueError: naming the bad value.
    """
    turn = getattr(task, "characteristic_length", 0.0)  # [m/rad], of tasks that count turns
    return RestartSearch(
        task.error_and_jacobian,
        task.size,
        lower=task.arm.lower,
        upper=task.arm.upper,
        tolerance=check_positive("tolerance", tolerance),
        pace=check_positive("speed", speed) * check_period(period),
        turning=task.arm.chain.revolute,
        longest_error=2.0 * task.arm.chain.reach + pi * turn,
        limits=limits,
        clearance=clearance,
        looks=max(1, min(LOOKS, round(LOOKS * period / LONG))),
        task=task,
    )
