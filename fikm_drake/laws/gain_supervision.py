"""The fuzzy gain and the detection of oscillation (Xu & Nechyba 1993, section 2.7)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, isfinite

from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

MAX_JOINTS = 52
"""The signs of the joint steps are kept as the bits of an integer in a double."""


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
        if self.window < 2:
            raise ValueError(f"window must be at least 2 cycles, got {self.window!r}")
        if not 1 <= self.sign_changes < self.window:
            raise ValueError(
                f"sign_changes must be from 1 to window − 1 = {self.window - 1}, "
                f"got {self.sign_changes!r}"
            )
        for name in ("error_breakpoints", "gains", "oscillating_gains"):
            if len(getattr(self, name)) != 3:
                raise ValueError(f"{name} needs three numbers (S, M, B), got {getattr(self, name)!r}")
        for name in ("gains", "oscillating_gains"):
            if not all(isfinite(g) and g >= 0 for g in getattr(self, name)):
                raise ValueError(f"{name} must be finite and not negative, got {getattr(self, name)!r}")
        for name in ("dead_band", "initial_gain"):
            if not (isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise ValueError(f"{name} must be finite and not negative, got {getattr(self, name)!r}")


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
    """Section 2.7 as a pure law: a gain from the error, its recent average and the joints' signs.

    What it remembers is a list of floats that the caller keeps, so that a block's Context can:
    the largest number of sign changes of a joint, how many errors are known, the joints whose last
    motion was positive, those whose was negative (bit j: joint j), the last errors, and for each
    pair of successive cycles the joints that changed sign (bits too); newest last.

    Until `window` errors are known there is no average to compare with and an error counts as
    medium. An error of exactly zero tells nothing and is not remembered. One that is not finite
    counts as big and is not remembered either.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(self, config: GainSupervisorConfig | None = None) -> None:
        config = config or GainSupervisorConfig()
        config.validate()
        self.rules = gain_rules(config)
        self._window = config.window
        self._threshold = config.sign_changes
        self._medium = float(config.error_breakpoints[1])
        self._dead_band = config.dead_band

    @property
    def state_size(self) -> int:
        """Length of the state list."""
        return 4 + self._window + self._window - 1

    def initial_state(self) -> list[float]:
        """The state before the first cycle."""
        return [0.0] * self.state_size

    def gain(self, state: Sequence[float], error: float) -> float:
        """The gain for an error of length `error` [m]."""
        return self.rules.evaluate(self._relative(state, error), state[0])

    def oscillating(self, state: Sequence[float]) -> bool:
        """True while the steps of a joint change sign `sign_changes` times within the window."""
        return state[0] >= self._threshold

    def advance(
        self, state: Sequence[float], error: float, joint_step: Sequence[float]
    ) -> list[float]:
        """The state after a cycle with an error of length `error` [m] and these joint steps."""
        window = self._window
        _, known, was_positive, was_negative = state[:4]
        errors, flips = state[4 : 4 + window], state[4 + window :]
        if 0.0 < error < inf:
            known = min(known + 1, window)
            errors = [*errors[1:], error]
        positive = negative = 0
        bit, dead_band = 1, self._dead_band
        for step in joint_step:
            if step > dead_band:
                positive |= bit
            elif step < -dead_band:
                negative |= bit
            bit <<= 1
        before_positive, before_negative = int(was_positive), int(was_negative)
        changed = positive & before_negative | negative & before_positive
        now_positive = positive | before_positive & ~negative
        now_negative = negative | before_negative & ~positive
        flips = [*flips[1:], changed]
        return [_most_changes(flips), known, now_positive, now_negative, *errors, *flips]

    def _relative(self, state: Sequence[float], error: float) -> float:
        """The error over its average over the last `window` cycles, itself among them."""
        if not 0.0 < error < inf:
            return 0.0 if error == 0.0 else inf
        window = self._window
        if state[1] + 1 < window:
            return self._medium
        return error * window / (sum(state[5 : 4 + window]) + error)


def _most_changes(flips: Sequence[float]) -> int:
    """The largest number of changes of one joint; bit j of each number is joint j's change."""
    changed = [int(f) for f in flips if f]
    if not changed:  # the usual case
        return 0
    joints = max(changed).bit_length()
    return max(sum(f >> j & 1 for f in changed) for j in range(joints))
