"""Tables as large as an ANFIS, to compare it with."""

from collections.abc import Callable

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy import RuleBase, TriangularPartition
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table

NUMBERS = 224
"""Numbers of an 8 x 8 ANFIS: 192 coefficients and 32 parameters of memberships."""


def bilinear_table(X: Array, Y: Array, side: int) -> RuleBase:
    """A table of side x side values that fits data (N,2), (N,) best, linear between neighbours."""
    first, second = (
        TriangularPartition(np.linspace(column.min(), column.max(), side)) for column in X.T
    )
    grades = first.grades(X[:, 0])[:, :, None] * second.grades(X[:, 1])[:, None, :]
    # Nodes far from the data: the least values that fit.
    values = np.linalg.lstsq(grades.reshape(len(X), -1), Y, rcond=1e-6)[0]
    return RuleBase(first, second, values.reshape(side, side))


def radial_table(arm: DhArm, name: str, count: int) -> Callable[[Array], Array]:
    """The bound `lower` or `upper` of joint 1 by a table over the distance from joint 1 alone.

    Without its own limits joint 1 has bounds that turn with the point: angle + G(distance). So G is
    tabled, at `count` distances, and the limits of joint 1 cut what comes out.

    Returns:
        A function of distance and angle (N,2) [m, rad] to bounds (N,) [rad].
    """
    table = arm.table
    table.joints[0].lower = table.joints[0].upper = None
    free = DhArm(table)
    distances = np.linspace(0.0, Planar3R(arm).lengths.sum(), 20 * count)
    along_x = np.column_stack([distances, np.zeros_like(distances)])
    reachable = distances[feasible_interval_table(free, along_x).feasible]
    knots = np.linspace(reachable[0], reachable[-1], count)
    lower, upper = feasible_interval_table(free, np.column_stack([knots, 0.0 * knots])).widest()
    G = upper if name == "upper" else lower
    low, high = arm.lower[0], arm.upper[0]

    def bound(polar: Array) -> Array:
        return np.clip(polar[:, 1] + np.interp(polar[:, 0], knots, G), low, high)

    return bound
