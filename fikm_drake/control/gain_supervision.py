"""The fuzzy gain and the detection of oscillation (Xu & Nechyba 1993, section 2.7)."""

from math import inf, isfinite

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_positive
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig, gain_rules
from fikm_drake.control.steps import length

MAX_JOINTS = 52
"""The signs of the joint steps are kept as the bits of an integer in a double."""

CALM, LAST_ERROR, HEAD = 2, 8, 10
"""Where the memory holds the calm, the last error and step, and where its rings begin."""

LEAST_CALM = 1e-4
"""The gain is calmed to this fraction at the least, so that it finds back [-]."""

STAYS = 0.85
"""An error above this fraction of its mean over the slow window does not fall [-]."""

AWAKE = 0.25
"""A target that moves brings the gain back to this fraction at once [-]."""

PROGRESS = 0.01
"""The error falls if a cycle takes away this fraction of it, times the calm of the gain [-]."""

TARGET_MOVED = 10.0
"""An error that changes by more than this times the joint motion was changed by the target [m/rad]."""


class GainSupervision:
    """Section 2.7 as a law: a gain from the error, its recent average and the signs of the steps.

    What it remembers is a vector that the caller keeps, so that a block's Context can:

    - the largest number of sign changes of a joint in the window, how many errors are known, the calm of
      the gain (a factor from 1 down to `LEAST_CALM`), the mean error over about the slow window, the
      largest number of sign changes in it, how many cycles are known;
    - the joints whose last motion was positive, and those whose was negative (bit j: joint j);
    - while the calm may change, the last error and the length of the last joint step;
    - the last `window` errors, and the joints that changed sign (bits too) between each two of the
      last `window` cycles, and of the last `slow_window`, as rings.

    Past the paper: the gain of Table I is multiplied by the calm. It shrinks while a joint oscillates,
    grows while the error falls and wakes when the target moves; else it stays, so that the arm rests
    where the error can't be made smaller.

    Until `window` errors are known there is no average to compare with and an error counts as
    medium. An error of exactly zero tells nothing and is not remembered. One that is not finite
    counts as big and is not remembered either; a joint step that is not finite has no sign.

    Args:
        config: the constants.
        error_limit: for the gain a longer error counts as this long [m].

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self, config: GainSupervisorConfig | None = None, *, error_limit: float = inf
    ) -> None:
        config = config or GainSupervisorConfig()
        config.validate()
        self.rules = gain_rules(config)
        self._window = config.window
        self._errors = slice(HEAD, HEAD + config.window)
        self._flips = slice(self._errors.stop, self._errors.stop + config.window - 1)
        self._slow_flips = slice(self._flips.stop, self._flips.stop + config.slow_window - 1)
        self._slow_window = config.slow_window
        self._threshold, self._slow_threshold = config.sign_changes, config.slow_sign_changes
        self._medium = float(config.error_breakpoints[1])
        self._dead_band = config.dead_band
        self._calming, self._recovery = config.calming, config.recovery
        self._calm_damping = config.calm_damping
        self._error_limit = check_positive("error_limit", error_limit)

    def initial_memory(self) -> Array:
        """The memory before the first cycle."""
        memory = np.zeros(self._slow_flips.stop)
        memory[CALM] = 1.0
        return memory

    def gain(self, memory: Array, error: float) -> float:
        """The gain for an error of length `error` [m]."""
        changes, known, calm = memory[: CALM + 1].tolist()
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
        return calm * self.rules.evaluate(relative, changes)

    def calm(self, memory: Array) -> float:
        """The factor of the gain: 1, or less after an oscillation."""
        return float(memory[CALM])

    def damping(self, memory: Array) -> float:
        """Damping of the scaled Jacobian, 0 as long as the gain is not calmed [-]."""
        return self._calm_damping * (1.0 - float(memory[CALM]))

    def oscillating(self, memory: Array) -> bool:
        """True while the steps of a joint change sign `sign_changes` times within the window."""
        return bool(memory[0] >= self._threshold)

    def remember(self, memory: Array, error: float, joint_step: Array) -> None:
        """Write a cycle with an error of length `error` [m] and these joint steps into `memory`."""
        changes, known, calm, mean, slow, cycles, *signs = memory[:LAST_ERROR].tolist()
        was_positive, was_negative = map(int, signs)
        if 0.0 < error < inf:
            memory[HEAD + int(known) % self._window] = min(error, self._error_limit)
            mean += (error - mean) / self._slow_window if known else error
            known += 1
        positive = negative = 0
        bit, dead_band = 1, self._dead_band
        for step in joint_step.tolist():
            if dead_band < step < inf:
                positive |= bit
            elif -inf < step < -dead_band:
                negative |= bit
            bit <<= 1
        flips = positive & was_negative | negative & was_positive
        if flips or slow:  # else both rings are empty
            slot = self._flips.start + int(cycles) % (self._window - 1)
            if flips or memory[slot]:
                memory[slot] = flips
                changes = _most_changes(memory[self._flips].tolist())
            slot = self._slow_flips.start + int(cycles) % (self._slow_window - 1)
            if flips or memory[slot]:
                memory[slot] = flips
                slow = _most_changes(memory[self._slow_flips].tolist())
        shakes = changes >= self._threshold or slow >= self._slow_threshold
        if (shakes or calm < 1.0) and error < inf:
            if calm < 1.0 and _target_moved(memory, error):
                memory[self._flips.start :] = changes = slow = 0  # what was seen holds no more
                calm = max(calm, AWAKE)
            else:
                stays = slow >= self._slow_threshold and self._stays(memory, error, mean)
                oscillates = changes >= self._threshold or stays
                calm = self._next_calm(memory, oscillates, calm, error)
            motion = length(joint_step)
            memory[LAST_ERROR:HEAD] = error, motion if isfinite(motion) else 0.0
        memory[:LAST_ERROR] = (
            changes,
            known,
            calm,
            mean,
            slow,
            cycles + 1,
            positive | was_positive & ~negative,
            negative | was_negative & ~positive,
        )

    def _stays(self, memory: Array, error: float, mean: float) -> bool:
        """True if the error neither falls nor shakes, as behind a target that shakes."""
        errors = memory[self._errors].tolist()
        return error > STAYS * mean and min(errors) > 0.5 * max(errors)

    def _next_calm(self, memory: Array, oscillates: bool, calm: float, error: float) -> float:
        if oscillates:
            return max(LEAST_CALM, calm * self._calming)
        last_error = float(memory[LAST_ERROR])
        falls = last_error - error > PROGRESS * calm * last_error
        return min(1.0, calm * self._recovery) if falls else calm


def _target_moved(memory: Array, error: float) -> bool:
    """True if the error changed by more than the joints can have changed it."""
    last_error, last_step = memory[LAST_ERROR:HEAD].tolist()
    return bool(abs(error - last_error) > TARGET_MOVED * last_step)


def _most_changes(flips: list[float]) -> int:
    """The largest number of changes of one joint; bit j of each number is joint j's change."""
    changed = [int(f) for f in flips if f]
    joints = max(changed, default=0).bit_length()
    return max((sum(f >> j & 1 for f in changed) for j in range(joints)), default=0)
