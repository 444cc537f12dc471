"""Fuzzy weights of the joints near their limits."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition


def limit_rules() -> RuleBase:
    """The rules that `LimitWeights` evaluates in closed form.

    A joint that moves toward a limit counts the less the nearer it is, at the limit not at all; one
    that moves away counts in full.
    """
    distance = TriangularPartition((0.0, 1.0), labels=("AT", "FAR"))
    motion = TriangularPartition((-1.0, 1.0), labels=("AWAY", "TOWARD"))
    return RuleBase(distance, motion, [(1.0, 0.0), (1.0, 1.0)], names=("distance", "motion", "w"))


class LimitWeights:
    """Weights (n,) from 0 to 1 for the columns of a Jacobian, by the rules of `limit_rules`.

    A law's step w · law(J · w, e) then leaves to the other joints what a joint near its limit cannot
    do. The weighted step can turn another joint toward its limit, so `JointLimits` stays necessary.

    Args:
        lower: lower limits (n,) [rad or m]; −inf for none.
        upper: upper limits (n,) [rad or m]; inf for none.
        zone: distance from a limit where weights begin to fall [rad or m]; at most a quarter of the
            joint's range.
    """

    def __init__(self, lower: Array, upper: Array, zone: float) -> None:
        self._lower, self._upper = lower, upper
        self._zone = np.maximum(np.minimum(zone, 0.25 * (upper - lower)), 1e-12)
        self._begin_low, self._begin_high = lower + self._zone, upper - self._zone

    @property
    def numbers(self) -> tuple[Array, ...]:
        """What the native kernel takes, (n,) each: the limits, where the zones begin, how wide they are."""
        return self._lower, self._upper, self._begin_low, self._begin_high, self._zone

    def near(self, q: Array) -> bool:
        """True if a joint at q (n,) is in a zone."""
        return min(np.minimum(q - self._begin_low, self._begin_high - q).tolist()) < 0.0

    def __call__(self, q: Array, step: Array) -> Array:
        """Weights (n,) at q (n,) for a joint step (n,), whose direction counts."""
        distance = np.where(step > 0.0, self._upper - q, q - self._lower)
        return np.where(step == 0.0, 1.0, np.clip(distance / self._zone, 0.0, 1.0))
