"""Calms the velocity command of any controller that chatters."""

from dataclasses import dataclass

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts, check_finite, check_not_negative, check_number
from fikm_drake.control.sign_changes import SignChanges, check_sign_changes

DOMINANT = 0.05
"""A change of sign counts if the command is above this fraction of the largest of late [-]."""

FADING = 0.9
"""The largest command of late fades by this factor a cycle [-]."""

LONG = 20
"""Windows for which a command keeps its sign until its joint counts as one that goes somewhere [-]."""

STEADY = 1.3
"""The fraction of recovery grows by this a cycle while a command keeps its sign [-]."""

REGROWTH = 1.02
"""The fraction of recovery grows by this a cycle of calm at a gain of 1: 35 make up for a halving."""


@dataclass
class CommandSupervisorConfig:
    """When a joint's command counts as chatter, and how its gain answers.

    Attributes:
        window: how many cycles are remembered (-).
        sign_changes: a joint oscillates from this number of changes of sign of its command in the
            window [-].
        dead_band: commands within ± this have no sign [rad/s or m/s]; above the noise of the
            controller.
        fall: the gain falls by this factor a cycle while the joint oscillates [-].
        recovery: the gain rises by at most this fraction of itself a cycle while the joint does not
            [-].
        slowest_recovery: the fraction halves with every outbreak of oscillation, down to this [-].
        least_gain: the gain falls no lower [-]: what is left of a chatter that never ends.
    """

    window: int = 10
    sign_changes: int = 4
    dead_band: float = 1e-3
    fall: float = 0.8
    recovery: float = 0.5
    slowest_recovery: float = 0.008
    least_gain: float = 0.01

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        check_sign_changes("", self.sign_changes, self.window)
        check_not_negative("dead_band", self.dead_band)
        for name in ("fall", "least_gain"):
            check_number(name, getattr(self, name), "in (0, 1)", lambda x: 0.0 < x < 1.0)
        for name in ("recovery", "slowest_recovery"):
            check_finite(name, getattr(self, name))
        if not 0.0 < self.slowest_recovery <= self.recovery < np.inf:
            raise ValueError(
                "recovery must be finite and slowest_recovery in (0, recovery], "
                f"got {self.recovery!r} and {self.slowest_recovery!r}"
            )


class CommandSupervision:
    """A gain for each joint of somebody else's velocity command, lowered while the joint chatters.

    The idea of section 2.7 of Xu & Nechyba 1993, turned to the output of a controller: count the
    changes of sign of each joint's command in the last cycles; while there are too many the joint's
    gain falls, else it rises again up to 1. A command that does not chatter passes untouched. Each
    joint has its own gain: a joint that only shakes is calmed, one that makes way goes on. Chatter
    that comes back with the gain makes the gain rise more slowly each time, until the joint has
    been calm at a gain of 1, or its command has kept its sign for `LONG` windows: that is a joint that goes
    somewhere, not one that is pushed to and fro.

    A joint whose command is small beside the largest of late does not chatter: what it does shakes nothing.

    There is no filter, unlike equation 31: it would turn a reversal every cycle into one every
    other cycle, which is harder to see and lasts, and delay every command.

    What it remembers is a vector that the caller keeps, so that a block's Context can: gain,
    fraction of recovery, whether it oscillates and for how long its command kept its sign for each joint,
    the largest command of late, then the memory of `SignChanges`.

    Args:
        num_joints: n.
        config: see `CommandSupervisorConfig`.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(self, num_joints: int, config: CommandSupervisorConfig | None = None) -> None:
        config = config or CommandSupervisorConfig()
        config.validate()
        check_counts(num_joints=num_joints)
        self._n = num_joints
        self._changes = SignChanges(num_joints, window=config.window, dead_band=config.dead_band)
        self._threshold, self._dead_band = config.sign_changes, config.dead_band
        self._long = LONG * config.window
        self._fall, self._least = config.fall, config.least_gain
        self._recovery, self._slowest = config.recovery, config.slowest_recovery

    def initial_memory(self) -> Array:
        """The memory before the first cycle: gains of 1."""
        n = self._n
        joints = [np.ones(n), np.full(n, self._recovery), np.zeros(n), np.zeros(n)]
        return np.concatenate([*joints, [0.0], self._changes.initial_memory()])

    def gain(self, memory: Array) -> Array:
        """The gain of each joint (n,) [-]; a view."""
        return memory[: self._n]

    def oscillating(self, memory: Array) -> Array:
        """1 for each joint that oscillates, else 0 (n,); a view."""
        return memory[2 * self._n : 3 * self._n]

    def remember(self, memory: Array, command: Array) -> None:
        """Write a cycle with this command (n,) [rad/s or m/s] into `memory`."""
        joints, n = 4 * self._n, self._n
        gain, recovery, oscillated, kept = memory[:joints].reshape(4, n)  # views
        changes = memory[joints + 1 :]
        sizes = np.abs(command)
        largest = max(float(sizes.max()), FADING * float(memory[joints]))
        memory[joints] = largest
        self._changes.remember(changes, np.where(sizes > DOMINANT * largest, command, 0.0))
        count = self._changes.count(changes)
        oscillates = count >= self._threshold
        outbreak = oscillates & (oscillated == 0.0)
        calm = ~oscillates & (gain >= 1.0)
        goes = (count == 0.0) & (sizes > max(self._dead_band, DOMINANT * largest))
        kept[:] = np.where(goes, kept + 1.0, 0.0)
        steady = kept >= self._long
        growth = np.where(steady, STEADY, np.where(calm, REGROWTH, 1.0))
        regrown = recovery * np.where(outbreak, 0.5, growth)
        recovery[:] = np.minimum(np.maximum(regrown, self._slowest), self._recovery)
        changed = gain * np.where(oscillates, self._fall, 1.0 + recovery)
        gain[:] = np.minimum(np.maximum(changed, self._least), 1.0)
        oscillated[:] = oscillates
