"""How far from the wanted point of the workplane the tool comes to lie."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk
from fikm_drake.solvers.workplane.workplane_inverse import WorkplaneInverse


def workplane_errors(inverse: WorkplaneInverse, points: ArrayLike, q: Array) -> tuple[Array, Array]:
    """Distance in the workplane's plane and height over it of the tool.

    Args:
        inverse: of the arm at its workplane.
        points: wanted points (…,2) [mm].
        q: joint positions (…,n) [rad].

    Returns:
        Distances (…) and heights (…) [mm].
    """
    reached = inverse.reached(q)
    return np.linalg.norm(reached[..., :2] - np.asarray(points), axis=-1), reached[..., 2]


def grid_errors(
    ik: IntegerFuzzyIk, inverse: WorkplaneInverse, *, every: int = 1
) -> tuple[Array, Array]:
    """`workplane_errors` on the whole workplane at every whole millimetre, or every so many."""
    points = inverse.workplane.grid(every)
    return workplane_errors(inverse, points, ik.to_radians(ik.solve_batch(points)[0]))
