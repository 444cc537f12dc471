"""The fuzzy gain and the detection of oscillation (Xu & Nechyba 1993, section 2.7), and the calm."""

from math import inf

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_not_negative, check_positive
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig, gain_rules
from fikm_drake.control.motion_windows import Motion, MotionWindows
from fikm_drake.control.steps import length

LEAST_CALM = 1e-6
"""The gain is calmed to this fraction at the least, so that it finds back [-]."""

CANCELLED = 0.65
"""Joints shake if more than this fraction of their path leads nowhere [-]."""

CONSISTENT = 0.4
"""They run on if less than this fraction does [-]."""

EXPLAINED = 0.3
"""A target whose own jitter is above this fraction of the error's explains that joints shake [-]."""

STAYS = 0.85
"""An error above this fraction of its mean over the slow window does not fall [-]."""

AWAKE = 0.25
"""An arm that runs on has at least this fraction of its gain [-]."""

PROGRESS = 0.01
"""The error falls if a cycle takes away this fraction of it, times the calm of the gain [-]."""

JUMP = 0.05
"""A target that moves by more than this fraction of the error in a cycle has jumped [-]."""

NEAR = 3.0
"""An error below this many times what the target moved in the fast window is of an arm that follows [-]."""

LEAST_PROGRESS = 1e-3
"""A calm below this counts as this for the progress: there motion that ends is none [-]."""

DEEP = 0.1
"""An arm at rest with less than this fraction of its gain is calmed further [-]."""

CHANGES = 2e-3
"""An error that changes by this fraction of it within the fast window is not flat [-]."""

AT_REST = 1e-4
"""Nothing moves where the joints' path is on average below this a cycle [rad or m]."""

DAMPED_FIRST = 0.2
"""A law that takes damping is given all of it before the calm, down here, lowers the gain [-]."""

HUGE = 1e100
"""Longer errors and steps are not summed: their squares overflow [m, rad]."""

CALMED_BELOW = 0.5
"""The arm is calmed while the gain is below this fraction of what it would be [-]."""


class GainSupervision:
    """Section 2.7 as a law: a gain from the error, its recent average and the signs of the steps.

    The gain of Table I needs the last `window` errors and the changes of sign of each joint within the
    last `window` cycles.

    Past the paper the gain is multiplied by the *calm*, a factor from 1 down to `LEAST_CALM`. It
    shrinks while the joints shake before a target that is out of the tolerance:

    - they turn round `sign_changes` times within the fast window, or `slow_sign_changes` times
      within the slow one while the error stays, turns of joints that hardly move left aside;
    - most of their motion in that window leads nowhere;
    - the target's own jitter does not explain it.

    It grows again within the tolerance, while the error falls, and while the joints run on and the error
    changes, as behind a target that moves. Else it stays, so that the arm rests where the error can't be
    made smaller.

    What it remembers is a vector that the caller keeps, so that a block's Context can; its fields have
    names, see `fields`. As long as no joint has turned round for a slow window nothing is kept but errors
    and signs.

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
                ("known", "f8"),
                ("calm", "f8"),
                ("changes", "f8"),
                ("watched", "f8"),
                ("quiet", "f8"),
                ("ticks", "f8"),
                ("joint", "f8"),
                ("rests", "f8"),
                ("errors", "f8", (config.window,)),
                ("signs", "f8", (num_joints,)),
                ("flips", "f8", (config.window - 1, num_joints)),
                *self._windows.fields,
            ]
        )
        self._window, self._slow_window = config.window, config.slow_window
        self._threshold, self._slow_threshold = config.sign_changes, config.slow_sign_changes
        self._medium = float(config.error_breakpoints[1])
        self._dead_band = config.dead_band
        self._calming, self._recovery = config.calming, config.recovery
        self._calm_damping = config.calm_damping
        self._error_limit = check_positive("error_limit", error_limit)
        self._damped_first = DAMPED_FIRST if damped else 1.0
        self._tolerance = check_not_negative("tolerance", tolerance)

    def initial_memory(self) -> Array:
        """The memory before the first cycle."""
        memory = np.zeros(self.fields.itemsize // 8)
        named = self._named(memory)
        named["calm"], named["joint"] = 1.0, -1.0
        return memory

    def gain(self, memory: Array, error: float) -> float:
        """The gain for an error of length `error` [m]."""
        known, calm, changes = memory[:3].tolist()
        if self._error_limit < error < inf:
            error = self._error_limit
        if not 0.0 < error < inf:
            relative = 0.0 if error == 0.0 else inf
        elif known + 1 < self._window:
            relative = self._medium
        else:
            errors = self._named(memory)["errors"].tolist()
            errors[int(known) % self._window] = error  # in place of the oldest
            relative = error * self._window / sum(errors)
        return self._gain_calm(calm) * self.rules.evaluate(relative, changes)

    def calm(self, memory: Array) -> float:
        """The factor of the gain: 1, or less after an oscillation."""
        return float(self._named(memory)["calm"])

    def damping(self, memory: Array) -> float:
        """Damping of the scaled Jacobian, 0 as long as the gain is not calmed [-]."""
        calm, first = self.calm(memory), self._damped_first
        return self._calm_damping * min(1.0, (1.0 - calm) / (1.0 - first if first < 1.0 else 1.0))

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

    def remember(self, memory: Array, error: Array, joint_step: Array, target: Array) -> None:
        """Write a cycle into `memory`.

        Args:
            memory: what is changed.
            error: the task error (m,) [m].
            joint_step: (n,) [rad or m].
            target: its coordinates (c,), two of which are as far apart as the target moves [m].
        """
        named = self._named(memory)
        size = length(error)
        if 0.0 < size < inf:
            known = int(named["known"])
            named["errors"][known % self._window] = min(size, self._error_limit)
            named["known"] = known + 1
        square = joint_step.dot(joint_step)
        if not square < HUGE**2:
            joint_step = np.where(np.abs(joint_step) < HUGE, joint_step, 0.0)
            square = joint_step.dot(joint_step)
        flips = None
        if square > self._dead_band**2:
            signs, last = np.sign(joint_step), named["signs"]
            if not signs.dot(last) == signs.dot(signs):
                moves = np.abs(joint_step) > self._dead_band
                flips = moves & (signs * last < 0.0)
                np.copyto(last, signs, where=moves)
                if not flips.any():
                    flips = None
        if flips is None and not named["watched"]:
            return
        if not named["watched"]:
            named["watched"], named["quiet"], named["flips"] = 1.0, 0.0, 0.0
            named["ticks"] = 0.0
            self._windows.start(named)
        if not (
            0.0 < size < HUGE and target.dot(target) < HUGE**2
        ):  # goes on from the last that was
            error, target = named["last_error"], named["last_target"]
            size = float(named["last_size"])
        self._watch(named, size, error, joint_step, target, square**0.5, flips)

    def _gain_calm(self, calm: float) -> float:
        return min(1.0, calm / self._damped_first)

    def _named(self, memory: Array) -> np.void:
        """The memory by its fields' names; what is written there is written to the memory."""
        return memory.view(self.fields)[0]

    def _watch(
        self,
        named: np.void,
        size: float,
        error: Array,
        step: Array,
        target: Array,
        step_length: float,
        flips: Array | None,
    ) -> None:
        """A cycle of an arm of which a joint turned round of late, or that is calmed."""
        ring, ticks = named["flips"], float(named["ticks"])
        ring[int(ticks) % len(ring)] = 0.0 if flips is None else flips
        named["changes"], named["ticks"] = np.add.reduce(ring).max(), ticks + 1.0
        if size <= self._tolerance:  # to and fro there is nothing to calm
            shift = self._windows.add(named, size, error, target, 0.0 * step, 0.0, None)
        else:
            shift = self._windows.add(named, size, error, target, step, step_length, flips)
        fast, slow = self._windows.motions(named)
        before = calm = float(named["calm"])
        if shift > JUMP * size and calm < 1.0:
            calm = self._recovered(calm)
            self._windows.start(named)  # what was seen holds no more
            named["rests"] = 0.0
        else:
            calm = self._next_calm(calm, size, fast, slow, named)
            if named["cycles"] >= self._window - 1:
                named["rests"] = fast.path_step < AT_REST * (self._window - 1)
        if calm <= self._damped_first < before:
            self._windows.start(named)  # less gain only if they shake with all the damping too
        named["calm"] = calm
        quiet = float(named["quiet"]) + 1.0 if flips is None else 0.0
        named["quiet"] = quiet
        if quiet >= self._slow_window and calm == 1.0:
            named["watched"], named["changes"], named["joint"] = 0.0, 0.0, -1.0

    def _next_calm(
        self, calm: float, size: float, fast: Motion, slow: Motion, named: np.void
    ) -> float:
        if size <= self._tolerance:
            return min(1.0, calm * self._recovery)
        joint = self._shaking_joint(size, fast, slow)
        if joint >= 0:
            named["joint"] = joint
            return max(LEAST_CALM, calm * self._calming)
        if calm == 1.0:
            return calm
        cycles = self._window - 1
        progress = PROGRESS * max(calm, LEAST_PROGRESS) * cycles * size
        if fast.fall > max(progress, 0.6 * fast.rough):
            return self._recovered(calm)
        runs = fast.path_step > 0.0 and fast.cancelled < CONSISTENT
        if runs and abs(fast.fall) > CHANGES * size:
            if size < NEAR * fast.net_target:
                return self._recovered(calm)
            return max(calm, min(self._damped_first, self._recovered(calm)))
        if named["rests"] and calm < DEEP * self._damped_first:
            return max(LEAST_CALM, calm * self._calming)  # so that what is left of a motion ends
        return calm

    def _shaking_joint(self, size: float, fast: Motion, slow: Motion) -> int:
        """The joint that shakes for no reason, −1 if none does."""
        if fast.changes >= self._threshold and _to_and_fro(fast):
            return fast.joint
        if slow.changes >= self._slow_threshold and _to_and_fro(slow):
            return slow.joint if size > STAYS * slow.mean_error else -1
        return -1

    def _recovered(self, calm: float) -> float:
        return min(1.0, max(AWAKE, calm) * self._recovery)


def _to_and_fro(motion: Motion) -> bool:
    """True if joints shake and not because the target does."""
    jitter = motion.path_target - motion.net_target
    return motion.cancelled > CANCELLED and not (
        jitter > EXPLAINED * (motion.path_error - motion.net_error)
    )
