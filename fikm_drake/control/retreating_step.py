"""A safe step whose joints draw back from their limits."""

from math import inf

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.joint_limits import StepBox
from fikm_drake.control.limit_retreat import LimitRetreat
from fikm_drake.control.safe_step import SafeStep
from fikm_drake.control.steps import length
from fikm_drake.laws.law import Law
from fikm_drake.laws.quadratic import QuadraticOf

UNBOUNDED = 1e3
"""Steps that something else bounds are asked for in a box of this half width [rad or m]."""


class RetreatingStep(SafeStep):
    """`SafeStep` with a `LimitRetreat` in place of weights near the limits.

    Args:
        law: the law.
        minimises: what it minimises.
        retreat: of the joints.
        longest: see `SafeStep`, as the others.
    """

    def __init__(
        self,
        law: Law,
        minimises: QuadraticOf,
        retreat: LimitRetreat,
        *,
        longest: float = inf,
        posture: Array | None = None,
        posture_gain: float = 0.0,
        singularity_nudge: float = 0.0,
    ) -> None:
        super().__init__(
            law,
            longest=longest,
            posture=posture,
            posture_gain=posture_gain,
            singularity_nudge=singularity_nudge,
        )
        self._minimises = minimises
        self.retreat = retreat

    def inside(
        self,
        q: Array,
        J: Array,
        error: Array,
        box: StepBox,
        damping: float | None = None,
        *,
        resolved: bool = True,
    ) -> tuple[Array, bool]:
        """The joint step (n,) inside limits [rad or m], and whether they took a part of it away.

        The law's own step where the tool is near and nothing is in its way, else the least one, see
        `LimitRetreat`; with limits of acceleration it is shortened as a whole so that it can be braked.
        The arguments are those of `SafeStep.inside`.
        """
        asked = length(error)
        if asked == inf:
            return np.zeros(len(q)), False
        own, _, secondary = self._free(q, J, error, damping)
        size = length(own)
        short = own if self._passes(size, asked) else self._short(own, size, asked, J)
        low, high = self.retreat.bounds(box, q)
        if asked <= self.retreat.near:
            inside = (np.minimum(np.maximum(short, low), high) == short).all()
            if inside or not resolved:
                step = box.limits.brakeable(short)
                return step, step is not short or not inside
        least = self._minimises(J, error, damping or 0.0)
        added = np.zeros(len(q)) if secondary is None else secondary
        if size < self.dead * asked and size <= self.longest:  # aside from a dead point
            added = added + (short - own)
        least = least._replace(g=least.g + least.H.dot(added))
        bounds = (low, high) if resolved else (np.full(len(q), x) for x in (-UNBOUNDED, UNBOUNDED))
        step = self.retreat.step(least, q, error, *bounds)
        longest = self.longest / max(length(step), 1e-300)
        if longest < 1.0:
            step = longest * step
        step = box.limits.brakeable(step)
        return step, bool(((step <= low) | (step >= high)).any())
