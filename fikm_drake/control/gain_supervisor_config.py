"""The constants and rules of the supervisor (Xu & Nechyba 1993, section 2.7)."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np

from fikm_drake.checks import check_not_negative, check_number
from fikm_drake.control.sign_changes import check_sign_changes
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition


@dataclass
class GainSupervisorConfig:
    """The constants of section 2.7; the breakpoints of figure 6 are our reading, the paper gives none.

    Attributes:
        window: how many cycles are remembered (-).
        error_breakpoints: where the error is small, medium and big, as a fraction of its average
            over the window [-].
        gains: gain for a small, medium and big error, Table I, row OFF [-]; more follows
            closer, up to where the joints shake.
        oscillating_gains: the same while a joint oscillates, Table I, row ON [-].
        sign_changes: a joint oscillates from this number of changes of sign of its steps within the
            window [-].
        dead_band: joint steps within ± this have no sign [rad or m].
        initial_gain: the gain before the first cycle [-].
        calming: while a joint oscillates, the gain shrinks by this factor a cycle, which ends the
            motion at a target out of reach [-]; less ends it sooner, 1 as in the paper does not.
        slow_window: cycles in which a slow oscillation is looked for, which the window misses (-).
        slow_sign_changes: a joint oscillates slowly from this number of changes of sign within the
            slow window, if the error meanwhile stays; that calms too [-].
        recovery: a calmed gain grows by this factor a cycle while the error falls [-]; more wakes
            sooner.
        calm_damping: damping of the scaled Jacobian while the gain is calmed, for laws that take it
            [-]; more stills more of the motion.
    """

    window: int = 10
    error_breakpoints: list[float] = field(default_factory=lambda: [0.0, 1.0, 2.0])
    gains: list[float] = field(default_factory=lambda: [1.0, 2.6, 0.8])
    oscillating_gains: list[float] = field(default_factory=lambda: [0.1, 0.4, 0.03])
    sign_changes: int = 4
    dead_band: float = 1e-12
    initial_gain: float = 1.0
    calming: float = 0.8
    slow_window: int = 64
    slow_sign_changes: int = 6
    recovery: float = 1.2
    calm_damping: float = 0.3

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        check_sign_changes("", self.sign_changes, self.window)
        check_sign_changes("slow_", self.slow_sign_changes, self.slow_window)
        if self.slow_window < self.window:
            raise ValueError(
                f"slow_window must be at least window = {self.window}, got {self.slow_window!r}"
            )
        for name in ("error_breakpoints", "gains", "oscillating_gains"):
            if np.shape(getattr(self, name)) != (3,):
                raise ValueError(
                    f"{name} needs three numbers (S, M, B), got {getattr(self, name)!r}"
                )
        small, medium, big = self.error_breakpoints
        if not (isfinite(small) and small < medium < big and isfinite(big)):
            raise ValueError(
                f"error_breakpoints must be finite and increase, got {self.error_breakpoints!r}"
            )
        for name in ("gains", "oscillating_gains"):
            for gain in getattr(self, name):
                check_not_negative(name, gain)
        check_number("calming", self.calming, "in (0, 1]", lambda x: 0.0 < x <= 1.0)
        check_number("recovery", self.recovery, "finite and above 1", lambda x: 1.0 < x < inf)
        for name in ("dead_band", "initial_gain", "calm_damping"):
            check_not_negative(name, getattr(self, name))


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
