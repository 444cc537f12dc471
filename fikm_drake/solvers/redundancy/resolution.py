"""What `RedundancyResolver.resolve` returns."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.solvers.count_statuses import count_statuses


class ResolutionStatus(IntEnum):
    """How the joints of one point were found."""

    INVALID_INPUT = 0
    """NaN, infinite, beyond 1e100 m, or not a pose."""
    SOLVED = 1
    """In the middle of the learned bounds, inside all limits."""
    REPAIRED = 2
    """In the middle of the exact bounds, in closed form or traced: the learned middle was outside a
    limit, or nothing has been learned."""
    INFEASIBLE = 3
    """No posture reaches the point inside all limits: proven in closed form; by tracing, none was found,
    and a posture that several limits leave no freedom may be missed."""


@dataclass(frozen=True)
class Resolution:
    """Joint positions for N points."""

    q: Array
    """(N,n) [rad or m], inside all limits; NaN where there is no success."""
    success: Bools
    """(N,)."""
    status: NDArray[np.int_]
    """(N,): values of `ResolutionStatus`."""
    lower: Array
    """(N,) lower bound of the joint [rad or m], learned, exact where repaired, NaN without success."""
    upper: Array
    """(N,) upper bound of the joint [rad or m], alike."""
    position_error: Array
    """(N,) distance of the tool from the point by forward kinematics [m]; NaN without success."""
    rotation_error: Array
    """(N,) the same of its orientation [rad]; zero where the task does not count it."""

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        counts = count_statuses(self.status, ResolutionStatus)
        return f"<Resolution: {counts or 'no points'}>"
