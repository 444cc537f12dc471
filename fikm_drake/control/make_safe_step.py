"""The safe step of a configuration."""

from collections.abc import Sequence
from math import inf

import numpy as np

from fikm_drake.checks import check_not_negative, check_number, check_position, check_positive
from fikm_drake.control.limit_retreat import LimitRetreat
from fikm_drake.control.limit_weights import LimitWeights
from fikm_drake.control.retreating_step import RetreatingStep
from fikm_drake.control.safe_step import SafeStep
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.laws.law import Law
from fikm_drake.laws.quadratic import quadratic_of


def make_safe_step(
    arm: PlantArm,
    law: Law,
    *,
    max_joint_step: float = inf,
    limit_margin: float = 0.0,
    posture_gain: float = 0.0,
    nominal_position: Sequence[float] = (),
    singularity_nudge: float = 0.0,
    limit_retreat: float = 0.0,
    num_rows: int = 6,
) -> SafeStep:
    """The law's step with an arm's joint limits; the arguments are those of `DifferentialIk`.

    `num_rows` is m, of the task.

    Raises:
        ValueError: naming the bad value, or a law that does not go with `limit_retreat`.
    """
    lower, upper = arm.lower, arm.upper
    check_not_negative("limit_margin", limit_margin)
    check_number("posture_gain", posture_gain, "in [0, 1] a cycle", lambda x: 0.0 <= x <= 1.0)
    posture = arm.default_position
    both = np.isfinite(lower) & np.isfinite(upper)
    posture[both] = 0.5 * (lower[both] + upper[both])
    if np.size(nominal_position):
        posture = check_position(nominal_position, lower, upper, name="nominal_position")
    bounded = np.isfinite(lower).any() or np.isfinite(upper).any()
    longest = check_positive("max_joint_step", max_joint_step)
    singularity_nudge = check_not_negative("singularity_nudge", singularity_nudge)
    preferred = posture if posture_gain else None
    if check_not_negative("limit_retreat", limit_retreat):
        minimises = quadratic_of(law, num_rows)
        if minimises is None:
            raise ValueError(
                f"limit_retreat needs a law that minimises something: DampedLeastSquares, or an indirect "
                f"FuzzyMapping with 1 or at least {num_rows} iterations; got {law!r}"
            )
        return RetreatingStep(
            law,
            minimises,
            LimitRetreat(
                lower,
                upper,
                strength=limit_retreat,
                reach=arm.chain.reach,
                margin=limit_margin,
            ),
            longest=longest,
            posture=preferred,
            posture_gain=posture_gain,
            singularity_nudge=singularity_nudge,
        )
    return SafeStep(
        law,
        longest=longest,
        limits=LimitWeights(lower, upper, limit_margin) if limit_margin and bounded else None,
        posture=preferred,
        posture_gain=posture_gain,
        singularity_nudge=singularity_nudge,
    )
