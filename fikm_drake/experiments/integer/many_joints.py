"""Rules for more than one arm."""

import copy

import numpy as np

from fikm_drake.fuzzy.integer import IntegerRuleBase
from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.solvers.desk_data import DeskData
from fikm_drake.solvers.integer_fuzzy_ik import IntegerFuzzyIk, tojo_inverse
from fikm_drake.solvers.tilted_plane_inverse import TiltedPlaneInverse

JOINTS = (4, 8, 12, 24)
"""Of Table 2."""
ASIDE = 0.01
"""From one arm's shoulder to the next one's [m]."""


def many_joints(
    joints: int,
    *,
    labels: tuple[int, int] = (3, 3),
    conjunction: Conjunction = "min",
    rounding: Rounding = "truncate",
) -> IntegerRuleBase:
    """Rules for arms of 4 joints side by side that reach for the same point.

    Args:
        joints: a multiple of 4.
        labels: of x and of y.
        conjunction: `min` or `product`.
        rounding: `truncate` or `nearest`.
    """
    first = tojo_inverse()
    grid = IntegerFuzzyIk(labels=labels).rules
    points = np.stack(np.meshgrid(grid.first.knots, grid.second.knots, indexing="ij"), axis=-1)
    points = points.reshape(-1, 2)
    positions = []
    for k in range(joints // 4):
        desk = copy.deepcopy(first.desk)
        desk.origin[1] += ASIDE * k
        positions.append(TiltedPlaneInverse(first.arm, desk)(points))
    data = DeskData(points, np.concatenate(positions, axis=1))
    return IntegerFuzzyIk(data, labels=labels, conjunction=conjunction, rounding=rounding).rules
