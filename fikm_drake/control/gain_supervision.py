"""The fuzzy gain and the detection of oscillation (Xu & Nechyba 1993, section 2.7), and the calm."""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_not_negative, check_positive
from fikm_drake.control.calm_rule import JUMP, CalmRule
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig, gain_rules
from fikm_drake.control.motion_windows import DOMINANT, FADING, MotionWindows, places
from fikm_drake.control.steps import length
from fikm_drake.kinematics.native.native_supervision import native_supervision

AT_REST = 1e-4
"""Nothing moves where the joints' path is on average below this a cycle [rad or m]."""

CALMED_BELOW = 0.5
"""The arm is calmed while the calm is below this [-]."""

KNOWN, CALM, CHANGES, WATCHED, TURN, TURN_BEFORE, TURNS, TICKS, JOINT, RESTS = range(10)
"""Where the numbers of the memory are that `GainSupervision.fields` names first."""

LONG_AGO = -1e9
"""Before any cycle."""

HUGE = 1e100
"""Longer errors and steps are not summed: their squares overflow."""


class WatchedMotion(NamedTuple):
    """What `GainSupervision` saw of a cycle while motion is watched."""

    size: float
    """Length of the task error [m]."""
    joint_step: Array
    """(n,) [rad or m]; zero where it was too long to be summed."""
    square: float
    """Of its length."""
    turned: list[int]
    """The joints that turned round."""


class GainSupervision:
    """Section 2.7 as a law: a gain from the error, its recent average and the signs of the steps.

    The gain of Table I needs the last `window` errors and the changes of sign of each joint within the
    last `window` cycles.

    Past the paper it sees whether the joints shake for no reason, and the *calm* (1 to 0) answers with
    damping and a lower gain until the motion ends: see `CalmRule`, whose motions `MotionWindows` sums.

    What it remembers is a vector that the caller keeps, so that a block's Context can; its fields have
    names, `fields`. As long as no joint turns round only errors and signs are written; from the first turn
    until all has been quiet for a slow window the motion is watched too.

    Until `window` errors are known there is no average to compare with and an error counts as
    medium. An error of exactly zero tells nothing and is not remembered. One that is not finite
    counts as big and is not remembered either; a joint step that is not finite counts as none.

    Args:
        num_rows: m, of the task error.
        num_joints: n.
        config: the constants.
        damped: the law takes the damping, which then comes before the gain is lowered.
        num_coordinates: c, of the target; by default m.
        error_limit: for the gain a longer error counts as this long [m].
        tolerance: within this an error needs no calm [m].

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        num_rows: int,
        num_joints: int,
        config: GainSupervisorConfig | None = None,
        *,
        num_coordinates: int | None = None,
        error_limit: float = inf,
        tolerance: float = 0.0,
        damped: bool = False,
    ) -> None:
        config = config or GainSupervisorConfig()
        config.validate()
        coordinates = num_rows if num_coordinates is None else num_coordinates
        self.rules = gain_rules(config)
        self._windows = MotionWindows(
            num_rows,
            num_joints,
            coordinates,
            window=config.window,
            slow_window=config.slow_window,
        )
        fields = [
            ("known", "f8"),  # errors so far
            ("calm", "f8"),
            ("changes", "f8"),  # of sign of the joint that has most, within the window
            ("watched", "f8"),  # 1 while the motion is watched
            ("turn", "f8"),  # when joints last turned round, as the number of errors then...
            ("turn_before", "f8"),  # ...and the time before
            ("turns", "f8"),  # cycles with a turn since the motion is watched
            ("ticks", "f8"),
            ("joint", "f8"),  # that oscillates, or did
            ("rests", "f8"),  # 1 if nothing moves
            ("errors", "f8", (config.window,)),  # a ring
            ("signs", "f8", (num_joints,)),  # of each joint's last motion
            ("flips", "f8", (config.window - 1, num_joints)),  # a ring: who turned round
            *self._windows.fields,
        ]
        self.fields = np.dtype(fields)
        place = places(fields)
        self._errors, self._signs, self._flips = place["errors"], place["signs"], place["flips"]
        self._motion = slice(self._flips.stop, None)
        self._window, self._slow_window = config.window, config.slow_window
        self._num_joints, self._threshold = num_joints, config.sign_changes
        self._medium = float(config.error_breakpoints[1])
        self._dead_band = config.dead_band
        self._rule = CalmRule(config, damped=damped)
        self._error_limit = check_positive("error_limit", error_limit)
        self._tolerance = check_not_negative("tolerance", tolerance)
        self.options = self._options((num_rows, num_joints, coordinates), config)
        self.native = native_supervision(self.options, self.fields.itemsize // 8)

    def initial_memory(self) -> Array:
        """The memory before the first cycle."""
        memory = np.zeros(self.fields.itemsize // 8)
        memory[CALM], memory[JOINT] = 1.0, -1.0
        memory[TURN] = memory[TURN_BEFORE] = LONG_AGO
        return memory

    def gain(self, memory: Array, error: float) -> float:
        """The gain for an error of length `error` [m]."""
        if self.native:
            return self.native.gain(memory, error)
        numbers = memory[: self._errors.stop].tolist()
        known, calm, changes = numbers[:WATCHED]
        if self._error_limit < error < inf:
            error = self._error_limit
        if not 0.0 < error < inf:
            relative = 0.0 if error == 0.0 else inf
        elif known + 1 < self._window:
            relative = self._medium
        else:
            errors = numbers[-self._window :]
            errors[int(known) % self._window] = error  # in place of the oldest
            relative = error * self._window / sum(errors)
        gain: float = self.rules.evaluate(relative, changes)
        return gain if calm == 1.0 else self._rule.gain(calm) * gain

    def calm(self, memory: Array) -> float:
        """The factor of the gain: 1, or less after an oscillation."""
        return float(memory[CALM])

    def damping(self, memory: Array) -> float:
        """Damping of the scaled Jacobian, 0 as long as the gain is not calmed [-]."""
        calm = float(memory[CALM])
        return 0.0 if calm == 1.0 else self._rule.damping(calm)

    def oscillating(self, memory: Array) -> bool:
        """True while a joint turns round `sign_changes` times within the window and something moves."""
        return bool(memory[CHANGES] >= self._threshold and not memory[RESTS])

    def oscillating_joint(self, memory: Array) -> int:
        """The joint that oscillates, or did so before the gain was calmed; −1: none."""
        return int(memory[JOINT])

    def calmed(self, memory: Array) -> bool:
        """True while the arm rests because the gain is calmed: the target can't be approached."""
        return bool(memory[CALM] < CALMED_BELOW and memory[RESTS])

    def remember(
        self,
        memory: Array,
        error: Array,
        joint_step: Array,
        target: Array,
        deviation: Array | None = None,
    ) -> None:
        """Write a cycle into `memory`.

        Args:
            memory: what is changed.
            error: the task error (m,) [m].
            joint_step: (n,) [rad or m].
            target: its coordinates (c,), two of which are as far apart as the target moves [m].
            deviation: of the measured joints from their command (n,), where they are measured [rad or m].
        """
        motion = self.remember_turns(memory, error, joint_step)
        if motion:
            self.remember_motion(memory, motion, error, target, deviation)

    def remember_turns(
        self, memory: Array, error: Array, joint_step: Array, size: float | None = None
    ) -> WatchedMotion | bool:
        """The first part of `remember`, all that most cycles need: errors, and which joints turned round.

        Args:
            memory: what is changed.
            error: the task error (m,) [m].
            joint_step: (n,) [rad or m].
            size: length of the error, where it is known [m].

        Returns:
            what `remember_motion` is to write at once, True where the native kernel keeps it; False while
            no motion is watched.
        """
        if self.native:
            return self.native.remember_turns(memory, error, joint_step)
        known, calm, changes, watched, last, late, turns, ticks = memory[:JOINT].tolist()
        size = length(error) if size is None else size
        if 0.0 < size < inf:
            memory[self._errors.start + int(known) % self._window] = min(size, self._error_limit)
            memory[KNOWN] = known + 1.0
        square = joint_step.dot(joint_step)
        if not square < HUGE**2:
            joint_step = np.where(np.abs(joint_step) < HUGE, joint_step, 0.0)
            square = joint_step.dot(joint_step)
        turned = self._turned(memory, joint_step) if square > self._dead_band**2 else []
        if not (turned or watched or changes):
            return False
        if turned or changes:  # else the ring is empty
            self._count_changes(memory, turned, int(ticks))
        memory[TICKS] = ticks + 1.0
        if turned:
            memory[TURN], memory[TURN_BEFORE], memory[TURNS] = known, last, turns + 1.0
            if not watched and known - late <= self._slow_window:
                watched = memory[WATCHED] = memory[TURNS] = 1.0
                self._windows.start(memory[self._motion])
        elif watched and calm == 1.0 and known - last >= self._slow_window:
            watched, memory[WATCHED], memory[JOINT] = 0.0, 0.0, -1.0
        if not watched or (calm == 1.0 and size <= self._tolerance):
            return False
        return WatchedMotion(size, joint_step, square, turned)

    def remember_motion(
        self,
        memory: Array,
        motion: WatchedMotion | bool,
        error: Array,
        target: Array,
        deviation: Array | None = None,
    ) -> None:
        """The second part of `remember`: the motion, and what it says of the calm."""
        if self.native:
            self.native.remember_motion(memory, error, target, deviation)
            return
        assert isinstance(motion, WatchedMotion)
        (size, joint_step, square, turned), seen = motion, memory[self._motion]
        if not (0.0 < size < HUGE and target.dot(target) < HUGE**2):
            # No error to go by: on from the last that was.
            size, error, target = self._windows.last(seen)
            deviation = None
        if deviation is not None and not deviation.dot(deviation) < HUGE**2:
            deviation = None
        if size <= self._tolerance:  # to and fro there is nothing to calm
            joint_step, square, turned = 0.0 * joint_step, 0.0, []
        went = sqrt(square)
        shift = self._windows.add(seen, size, error, target, joint_step, went, turned, deviation)
        if memory[CALM] < 1.0 or memory[TURNS] >= self._threshold:
            self._set_calm(memory, size, shift, went)

    def _options(self, sizes: tuple[int, ...], config: GainSupervisorConfig) -> Array:
        """What the native kernel is told, in the order of `native/supervision.h`."""
        numbers: list[float] = [*sizes, self._window, self._slow_window, self._threshold]
        numbers += [config.slow_sign_changes, self._dead_band, self._error_limit, self._tolerance]
        numbers += [*config.error_breakpoints, *np.ravel(self.rules.consequents)]
        numbers += [AT_REST, DOMINANT, FADING, HUGE, *self._rule.numbers]
        return np.array(numbers, dtype=float)

    def _turned(self, memory: Array, joint_step: Array) -> list[int]:
        """The joints that turn round with this step, whose new signs are written."""
        before, turned = memory[self._signs], []
        for j, (x, sign) in enumerate(zip(joint_step.tolist(), before.tolist())):
            if x * sign <= 0.0 and abs(x) > self._dead_band:
                before[j] = 1.0 if x > 0.0 else -1.0
                if sign:
                    turned.append(j)
        return turned

    def _count_changes(self, memory: Array, turned: list[int], tick: int) -> None:
        """Write the joints that turned round in place of the oldest of the ring, and count anew."""
        ring = memory[self._flips].reshape(-1, self._num_joints)
        oldest = ring[tick % len(ring)]
        if turned or any(oldest.tolist()):  # else the counts stay
            oldest[:] = 0.0
            for joint in turned:
                oldest[joint] = 1.0
            memory[CHANGES] = max(np.add.reduce(ring).tolist())

    def _set_calm(self, memory: Array, size: float, shift: float, went: float) -> None:
        """The calm after an error of length `size`; the target moved by `shift`, the joints by `went`."""
        little = AT_REST * (self._window - 1)
        windows, seen, rule = self._windows, memory[self._motion], self._rule
        before = calm = float(memory[CALM])
        if calm == 1.0 and rule.too_few(windows.most_changes(seen)):  # as in most cycles
            path_step = went if went >= little else windows.path_step(seen)
        else:
            fast, slow = windows.motions(seen)
            path_step = fast.path_step
            if size <= self._tolerance:
                calm = rule.raised(calm)
            elif shift > JUMP * size and calm < 1.0:
                calm = rule.awake(calm)
                windows.start(seen)  # what was seen holds no more
                memory[RESTS] = 0.0
            else:
                joint = rule.shaking_joint(size, fast, slow)
                if joint >= 0:
                    memory[JOINT], calm = joint, rule.lowered(calm)
                else:
                    calm = rule.undisturbed(calm, size, fast, slow, rests=bool(memory[RESTS]))
        if windows.cycles(seen) >= self._window - 1:
            memory[RESTS] = path_step < little
        if calm <= rule.damped_first < before:
            windows.forget_turns(seen)  # less gain only if they shake with all the damping too
        memory[CALM] = calm
