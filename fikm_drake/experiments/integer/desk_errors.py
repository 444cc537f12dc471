"""How far from the wanted point of the desk the tool comes to lie."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.solvers.desk_inverse import DeskInverse
from fikm_drake.solvers.integer_fuzzy_ik import IntegerFuzzyIk

Array = NDArray[np.float64]


def desk_errors(inverse: DeskInverse, points: ArrayLike, q: Array) -> tuple[Array, Array]:
    """Distance in the desk's plane and height over it of the tool.

    Args:
        inverse: of the arm at its desk.
        points: wanted points (…,2) [mm].
        q: joint positions (…,n) [rad].

    Returns:
        Distances (…) and heights (…) [mm].
    """
    reached = inverse.reached(q)
    return np.linalg.norm(reached[..., :2] - np.asarray(points), axis=-1), reached[..., 2]


def grid_errors(ik: IntegerFuzzyIk, inverse: DeskInverse, *, every: int = 1) -> tuple[Array, Array]:
    """`desk_errors` on the whole desk at every whole millimetre, or every so many."""
    points = inverse.desk.grid(every)
    return desk_errors(inverse, points, ik.to_radians(ik.solve_batch(points)[0]))
