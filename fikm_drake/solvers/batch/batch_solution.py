"""What `solve_batch` returns."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.solvers.count_statuses import count_statuses


class BatchStatus(IntEnum):
    """How the search for one target ended."""

    SOLVED = 0
    """Within the tolerance, and inside the limits unless they are ignored."""
    OUT_OF_REACH = 1
    """No posture can reach it: proven from the lengths of the links or the plane of the arm."""
    NOT_SOLVED = 2
    """Nothing within the tolerance was found; that does not prove that there is nothing."""
    INVALID_TARGET = 3
    """NaN, infinite (beyond 1e100 m), or not a pose: nothing was tried."""


@dataclass(frozen=True)
class BatchSolution:
    """Joint positions for N targets, and how good they are."""

    q: Array
    """(N,n) joint positions [rad or m]; of a failed target the best ones found, never NaN."""
    success: Bools
    """(N,): within the tolerance."""
    status: NDArray[np.int_]
    """(N,): values of `BatchStatus`."""
    cycles: NDArray[np.int_]
    """(N,): control cycles from the first start to the end of the search; restarts run side by side
    and count once."""
    position_error: Array
    """(N,) [m]; NaN for invalid targets."""
    rotation_error: Array
    """(N,) [rad]; 0 for positions, NaN for invalid targets."""

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        counts = count_statuses(self.status, BatchStatus)
        return f"<BatchSolution: {counts or 'no targets'}>"
