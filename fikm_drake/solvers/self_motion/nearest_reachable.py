"""The point nearest to a wanted one that a planar 3R arm reaches, in closed form."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.kinematics.planar_border import nearest_on_border
from fikm_drake.kinematics.planar_links import PlanarLinks
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.solvers.self_motion.feasible_intervals import EDGE, feasible_interval_table


@dataclass(frozen=True)
class NearestReachable:
    """What comes nearest to N points."""

    q: Array
    """(N,3) postures inside the limits that put the tool there [rad]; NaN for invalid points."""
    point: Array
    """(N,2): where [m]; the wanted point itself where it can be reached, NaN for invalid points."""
    distance: Array
    """(N,) from the wanted point [m]: 0 where it can be reached, NaN for invalid points."""

    @property
    def reachable(self) -> Bools:
        """(N,): the point itself can be reached."""
        return self.distance == 0.0


def nearest_reachable(arm: DhArm | SerialChain, points: ArrayLike) -> NearestReachable:
    """The reachable point nearest to each of some points, exact, and a posture that reaches it.

        nearest = fd.nearest_reachable(fd.load_arm("hassantabar3r"), [[9.0, 0.0], [1.0, 2.0]])
        nearest.distance, nearest.q

    Args:
        arm: a planar arm with three revolute joints about z, of any lengths and limits.
        points: (N,2) [m].

    Raises:
        ValueError: the arm is of another kind, or `points` has another shape.
    """
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {array.shape}")
    geometry = Planar3R(arm)
    q, distance = np.full((len(array), 3), np.nan), np.full(len(array), np.nan)
    near = np.full(array.shape, np.nan)
    table = feasible_interval_table(arm, array)
    inside = np.flatnonzero(table.feasible)
    lower, upper = (bound[inside] for bound in table.widest())
    both = geometry.postures(array[inside], 0.5 * (lower + upper))
    left = geometry.is_inside(both[:, 0], EDGE)
    posture = np.where(left[:, None], both[:, 0], both[:, 1])
    q[inside] = np.clip(posture, geometry.lower, geometry.upper)
    near[inside], distance[inside] = array[inside], 0.0
    far = np.flatnonzero(~table.feasible & np.isfinite(array).all(axis=1))
    if far.size:
        links = _links(geometry)
        bent, distance[far] = nearest_on_border(links, (array[far] - geometry.base).T)
        near[far] = links.tool(bent).T + geometry.base
        q[far] = np.clip(bent.T - geometry.offsets, geometry.lower, geometry.upper)
    return NearestReachable(q, near, distance)


def _links(geometry: Planar3R) -> PlanarLinks:
    """The arm by its bent angles; a joint without limits has a whole turn, from one limit if it has it."""
    no_lower, no_upper = np.isinf(geometry.lower), np.isinf(geometry.upper)
    lower = np.where(no_lower, geometry.middle - np.pi, geometry.lower) + geometry.offsets
    upper = np.where(no_upper, geometry.middle + np.pi, geometry.upper) + geometry.offsets
    first, second, third = geometry.lengths.tolist()
    return PlanarLinks((first, second, third), tuple(lower.tolist()), tuple(upper.tolist()))
