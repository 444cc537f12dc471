"""Rules for more than one arm."""

import numpy as np

from fikm_drake.fuzzy.integer import IntegerRuleBase
from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.solvers.workplane.integer_fuzzy_ik import tojo_inverse
from fikm_drake.solvers.workplane.tilted_plane_inverse import TiltedPlaneInverse

JOINTS = (4, 8, 12, 24)
"""Of Table 2."""
ASIDE = 0.01
"""From one arm's shoulder to the next one's [m]."""
RESOLUTION = 0.01
"""One step of the angles [°]."""


def many_joints(
    joints: int,
    *,
    labels: tuple[int, int] = (3, 3),
    conjunction: Conjunction = "min",
    rounding: Rounding = "truncate",
) -> IntegerRuleBase:
    """Rules for arms of 4 joints side by side that reach for the same point.

    Args:
        joints: a positive multiple of 4.
        labels: of x and of y.
        conjunction: `min` or `product`.
        rounding: `truncate` or `nearest`.
    """
    own, positions = tojo_inverse(), []
    for k in range(joints // 4):
        workplane = own.workplane
        workplane.origin[1] += ASIDE * k
        inverse = TiltedPlaneInverse(own.arm, workplane)
        first, second, found = inverse.singletons(labels, conjunction, least_squares=False)
        positions.append(found)
    steps = np.rint(np.rad2deg(np.concatenate(positions, axis=-1)) / RESOLUTION)
    return IntegerRuleBase(
        first, second, steps.astype(np.int64), conjunction=conjunction, rounding=rounding
    )
