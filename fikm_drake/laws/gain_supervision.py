"""The fuzzy gain and the detection of oscillation (Xu & Nechyba 1993, section 2.7)."""

from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

MAX_JOINTS = 52
"""The signs of the joint steps are kept as the bits of an integer in a double."""

HEAD = 5
"""Length of the part of the memory before the rings."""

Array = NDArray[np.float64]


@dataclass
class GainSupervisorConfig:
    """The constants of section 2.7; the breakpoints of figure 6 are our reading, the paper gives none."""

    window: int = 10
    """How many cycles are remembered (-)."""
    error_breakpoints: list[float] = field(default_factory=lambda: [0.0, 1.0, 2.0])
    """Where the error is small, medium and big, as a fraction of its average over the window [-]."""
    gains: list[float] = field(default_factory=lambda: [1.0, 2.6, 0.8])
    """Gain for a small, medium and big error, Table I, row OFF [-]."""
    oscillating_gains: list[float] = field(default_factory=lambda: [0.1, 0.4, 0.03])
    """The same while a joint oscillates, Table I, row ON [-]."""
    sign_changes: int = 4
    """A joint oscillates from this number of changes of sign of its steps within the window [-]."""
    dead_band: float = 1e-12
    """Joint steps within ± this have no sign [rad or m]."""
    initial_gain: float = 1.0
    """The gain before the first cycle [-]."""

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if not isinstance(self.window, int) or self.window < 2:
            raise ValueError(f"window must be an integer of at least 2 cycles, got {self.window!r}")
        if not 1 <= self.sign_changes < self.window:
            raise ValueError(
                f"sign_changes must be from 1 to window − 1 = {self.window - 1}, "
                f"got {self.sign_changes!r}"
            )
        for name in ("error_breakpoints", "gains", "oscillating_gains"):
            if len(getattr(self, name)) != 3:
                raise ValueError(
                    f"{name} needs three numbers (S, M, B), got {getattr(self, name)!r}"
                )
        small, medium, big = self.error_breakpoints
        if not (isfinite(small) and small < medium < big and isfinite(big)):
            raise ValueError(
                f"error_breakpoints must be finite and increase, got {self.error_breakpoints!r}"
            )
        for name in ("gains", "oscillating_gains"):
            if not all(isfinite(g) and g >= 0 for g in getattr(self, name)):
                raise ValueError(
                    f"{name} must be finite and not negative, got {getattr(self, name)!r}"
                )
        for name in ("dead_band", "initial_gain"):
            if not (isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise ValueError(
                    f"{name} must be finite and not negative, got {getattr(self, name)!r}"
                )


def gain_rules(config: GainSupervisorConfig) -> RuleBase:
    """Table I with the memberships of figures 6 and 7: gain over (relative error, sign changes).

    The relative error is |dr| over its average; the sign changes are the largest count of a joint.
    """
    error = TriangularPartition(config.error_breakpoints, labels=("S", "M", "B"))
    changes = TriangularPartition(
        (config.sign_changes - 1.0, float(config.sign_changes)), labels=("OFF", "ON")
    )
    consequents = list(zip(config.gains, config.oscillating_gains))
    return RuleBase(error, changes, consequents, names=("error", "sign changes", "K"))


class GainSupervision:
    """Section 2.7 as a law: a gain from the error, its recent average and the signs of the steps.

    What it remembers is a vector that the caller keeps, so that a block's Context can:

    - the largest number of sign changes of a joint, how many errors and how many cycles are known;
    - the joints whose last motion was positive, and those whose was negative (bit j: joint j);
    - the last `window` errors, and the joints that changed sign (bits too) between each two of the
      last `window` cycles, both as rings.

    Until `window` errors are known there is no average to compare with and an error counts as
    medium. An error of exactly zero tells nothing and is not remembered. One that is not finite
    counts as big and is not remembered either; a joint step that is not finite has no sign.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(self, config: GainSupervisorConfig | None = None) -> None:
        config = config or GainSupervisorConfig()
        config.validate()
        self.rules = gain_rules(config)
        self._window = config.window
        self._errors = slice(HEAD, HEAD + config.window)
        self._flips = slice(HEAD + config.window, HEAD + 2 * config.window - 1)
        self._threshold = config.sign_changes
        self._medium = float(config.error_breakpoints[1])
        self._dead_band = config.dead_band

    def initial_memory(self) -> Array:
        """The memory before the first cycle."""
        return np.zeros(self._flips.stop)

    def gain(self, memory: Array, error: float) -> float:
        """The gain for an error of length `error` [m]."""
        changes, known = memory[:2].tolist()
        if not 0.0 < error < inf:
            relative = 0.0 if error == 0.0 else inf
        elif known + 1 < self._window:
            relative = self._medium
        else:
            errors = memory[self._errors].tolist()
            errors[int(known) % self._window] = error  # in place of the oldest
            relative = error * self._window / sum(errors)
        return self.rules.evaluate(relative, changes)

    def oscillating(self, memory: Array) -> bool:
        """True while the steps of a joint change sign `sign_changes` times within the window."""
        return bool(memory[0] >= self._threshold)

    def remember(self, memory: Array, error: float, joint_step: Array) -> None:
        """Write a cycle with an error of length `error` [m] and these joint steps into `memory`."""
        changes, known, cycles, was_positive, was_negative = map(int, memory[:HEAD].tolist())
        if 0.0 < error < inf:
            memory[HEAD + known % self._window] = error
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
        slot = self._flips.start + cycles % (self._window - 1)
        if flips or memory[slot]:  # else the count stays
            memory[slot] = flips
            changes = _most_changes(memory[self._flips].tolist())
        positive, negative = (
            positive | was_positive & ~negative,
            negative | was_negative & ~positive,
        )
        memory[:HEAD] = changes, known, cycles + 1, positive, negative


def _most_changes(flips: list[float]) -> int:
    """The largest number of changes of one joint; bit j of each number is joint j's change."""
    changed = [int(f) for f in flips if f]
    joints = max(changed, default=0).bit_length()
    return max((sum(f >> j & 1 for f in changed) for j in range(joints)), default=0)
