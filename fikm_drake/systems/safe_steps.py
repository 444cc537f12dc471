"""The safe step and the rate limits of a plant's arm, for the blocks."""

from collections.abc import Sequence
from math import inf

import numpy as np

from fikm_drake.checks import check_not_negative, check_number, check_positive
from fikm_drake.control.limit_weights import LimitWeights
from fikm_drake.control.safe_step import SafeStep
from fikm_drake.laws.law import Law
from fikm_drake.systems.joint_integrator import check_position
from fikm_drake.systems.tool_kinematics import ToolKinematics


def make_safe_step(
    kinematics: ToolKinematics,
    law: Law,
    *,
    max_joint_step: float = inf,
    limit_margin: float = 0.0,
    posture_gain: float = 0.0,
    nominal_position: Sequence[float] = (),
    singularity_nudge: float = 0.0,
) -> SafeStep:
    """The law's step with the plant's joint limits; the arguments are those of `DifferentialIk`.

    Raises:
        ValueError: naming the bad value.
    """
    lower, upper = kinematics.lower, kinematics.upper
    check_not_negative("limit_margin", limit_margin)
    check_number("posture_gain", posture_gain, "in [0, 1] a cycle", lambda x: 0.0 <= x <= 1.0)
    posture = kinematics.default_position
    both = np.isfinite(lower) & np.isfinite(upper)
    posture[both] = 0.5 * (lower[both] + upper[both])
    if np.size(nominal_position):
        posture = check_position(nominal_position, lower, upper, name="nominal_position")
    bounded = np.isfinite(lower).any() or np.isfinite(upper).any()
    return SafeStep(
        law,
        longest=check_positive("max_joint_step", max_joint_step),
        limits=LimitWeights(lower, upper, limit_margin) if limit_margin and bounded else None,
        posture=posture if posture_gain else None,
        posture_gain=posture_gain,
        singularity_nudge=check_not_negative("singularity_nudge", singularity_nudge),
    )
