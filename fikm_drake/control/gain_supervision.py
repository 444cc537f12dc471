"""The fuzzy gain and the detection of oscillation (Xu & Nechyba 1993, section 2.7), and the calm."""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.checks import check_not_negative, check_positive
from fikm_drake.control.calm_rule import JUMP, CalmRule
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig, gain_rules
from fikm_drake.control.motion_windows import DOMINANT, FADING, MotionWindows
from fikm_drake.control.steps import length
from fikm_drake.kinematics.native.native_supervision import native_supervision

AT_REST = 1e-4
"""Nothing moves where the joints' path is on average below this a cycle [rad or m]."""

CALMED_BELOW = 0.5
"""The arm is calmed while the calm is below this [-]."""

LONG_AGO = -1e9
"""Before any cycle."""

HUGE = 1e100
"""Longer errors and steps are not summed: their squares overflow [m, rad]."""


class WatchedMotion(NamedTuple):
    """What `GainSupervision` saw of a cycle while motion is watched."""

    size: float
    """Length of the task error [m]."""
    joint_step: Array
    """(n,) [rad or m]; zero where it was too long to be summed."""
    square: float
    """Of its length."""
    flips: NDArray[np.bool_] | None
    """Joints that turned round (n,), bool; None: none did."""


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
        self.fields = np.dtype(
            [
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
        )
        # What every cycle reads, without the cost of names; the scalars above are 0 to 3 in order.
        self._errors, self._signs = self._slice("errors"), self._slice("signs")
        self._window, self._slow_window = config.window, config.slow_window
        self._threshold = config.sign_changes
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
        named = self._named(memory)
        named["calm"], named["joint"] = 1.0, -1.0
        named["turn"] = named["turn_before"] = LONG_AGO
        return memory

    def gain(self, memory: Array, error: float) -> float:
        """The gain for an error of length `error` [m]."""
        if self.native:
            return self.native.gain(memory, error)
        known, calm, changes, _ = memory[:4].tolist()
        if self._error_limit < error < inf:
            error = self._error_limit
        if not 0.0 < error < inf:
            relative = 0.0 if error == 0.0 else inf
        elif known + 1 < self._window:
            relative = self._medium
        else:
            errors = memory[self._errors].tolist()
            errors[int(known) % self._window] = error  # in place of the oldest
            relative = error * self._window / sum(errors)
        gain: float = self.rules.evaluate(relative, changes)
        return gain if calm == 1.0 else self._rule.gain(calm) * gain

    def calm(self, memory: Array) -> float:
        """The factor of the gain: 1, or less after an oscillation."""
        return float(memory[1])

    def damping(self, memory: Array) -> float:
        """Damping of the scaled Jacobian, 0 as long as the gain is not calmed [-]."""
        calm = float(memory[1])
        return 0.0 if calm == 1.0 else self._rule.damping(calm)

    def oscillating(self, memory: Array) -> bool:
        """True while a joint turns round `sign_changes` times within the window and something moves."""
        named = self._named(memory)
        return bool(named["changes"] >= self._threshold and not named["rests"])

    def oscillating_joint(self, memory: Array) -> int:
        """The joint that oscillates, or did so before the gain was calmed; −1: none."""
        return int(self._named(memory)["joint"])

    def calmed(self, memory: Array) -> bool:
        """True while the arm rests because the gain is calmed: the target can't be approached."""
        named = self._named(memory)
        return bool(named["calm"] < CALMED_BELOW and named["rests"])

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
        self, memory: Array, error: Array, joint_step: Array
    ) -> WatchedMotion | bool:
        """The first part of `remember`, all that most cycles need: errors, and which joints turned round.

        Returns:
            what `remember_motion` is to write at once, True where the native kernel keeps it; False while
            no motion is watched.
        """
        if self.native:
            return self.native.remember_turns(memory, error, joint_step)
        known, _, changes, watched = memory[:4].tolist()
        size = length(error)
        if 0.0 < size < inf:
            memory[self._errors.start + int(known) % self._window] = min(size, self._error_limit)
            memory[0] = known + 1.0
        square = joint_step.dot(joint_step)
        if not square < HUGE**2:
            joint_step = np.where(np.abs(joint_step) < HUGE, joint_step, 0.0)
            square = joint_step.dot(joint_step)
        flips = None
        if square > self._dead_band**2:
            signs, last = np.sign(joint_step), memory[self._signs]
            if not signs.dot(last) == signs.dot(signs):
                moves = np.abs(joint_step) > self._dead_band
                flips = moves & (signs * last < 0.0)
                np.copyto(last, signs, where=moves)
                if not flips.any():
                    flips = None
        if flips is None and not watched and not changes:
            return False
        named = self._named(memory)
        ring, ticks = named["flips"], float(named["ticks"])
        oldest = ring[int(ticks) % len(ring)]
        if flips is not None or any(oldest.tolist()):  # else the counts stay
            oldest[:] = 0.0 if flips is None else flips
            named["changes"] = np.maximum.reduce(np.add.reduce(ring))
        named["ticks"] = ticks + 1.0
        if flips is not None:
            named["turns"] += 1.0
            late, named["turn_before"] = float(named["turn_before"]), named["turn"]
            named["turn"] = known
            if not watched and known - late <= self._slow_window:
                watched = named["watched"] = named["turns"] = 1.0
                self._windows.start(named)
        calm = float(named["calm"])
        if watched and calm == 1.0 and known - float(named["turn"]) >= self._slow_window:
            watched = named["watched"] = 0.0
            named["joint"] = -1.0
        if not watched or calm == 1.0 and size <= self._tolerance:
            return False
        return WatchedMotion(size, joint_step, square, flips)

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
        named, (size, joint_step, square, flips) = self._named(memory), motion
        if not (0.0 < size < HUGE and target.dot(target) < HUGE**2):
            # No error to go by: on from the last that was.
            error, target = named["last_error"], named["last_target"]
            size, deviation = float(named["last_size"]), None
        if deviation is not None and not deviation.dot(deviation) < HUGE**2:
            deviation = None
        if size <= self._tolerance:  # to and fro there is nothing to calm
            joint_step, square, flips = 0.0 * joint_step, 0.0, None
        shift = self._windows.add(
            named, size, error, target, joint_step, square**0.5, flips, deviation
        )
        if named["calm"] < 1.0 or named["turns"] >= self._threshold:
            self._set_calm(named, size, shift)

    def _options(self, sizes: tuple[int, ...], config: GainSupervisorConfig) -> Array:
        """What the native kernel is told, in the order of `native/supervision.h`."""
        numbers: list[float] = [*sizes, self._window, self._slow_window, self._threshold]
        numbers += [config.slow_sign_changes, self._dead_band, self._error_limit, self._tolerance]
        numbers += [*config.error_breakpoints, *np.ravel(self.rules.consequents)]
        numbers += [AT_REST, DOMINANT, FADING, HUGE, *self._rule.numbers]
        return np.array(numbers, dtype=float)

    def _slice(self, field: str) -> slice:
        """Where a field is in the memory."""
        places = np.zeros(1, dtype=self.fields)
        places[0][field] = 1.0
        found = np.flatnonzero(places.view(float))
        return slice(int(found[0]), int(found[-1]) + 1)

    def _named(self, memory: Array) -> np.void:
        """The memory by its fields' names; what is written there is written to the memory."""
        return memory.view(self.fields)[0]

    def _set_calm(self, named: np.void, size: float, shift: float) -> None:
        """The calm of the next cycle, after an error of length `size` and a target that moved by `shift`."""
        fast, slow = self._windows.motions(named)
        before = calm = float(named["calm"])
        rule = self._rule
        if size <= self._tolerance:
            calm = rule.raised(calm)
        elif shift > JUMP * size and calm < 1.0:
            calm = rule.awake(calm)
            self._windows.start(named)  # what was seen holds no more
            named["rests"] = 0.0
        else:
            joint = rule.shaking_joint(size, fast, slow)
            if joint >= 0:
                named["joint"], calm = joint, rule.lowered(calm)
            else:
                calm = rule.undisturbed(calm, size, fast, slow, rests=bool(named["rests"]))
        if named["cycles"] >= self._window - 1:
            named["rests"] = fast.path_step < AT_REST * (self._window - 1)
        if calm <= rule.damped_first < before:
            self._windows.forget_turns(
                named
            )  # less gain only if they shake with all the damping too
        named["calm"] = calm
