"""What `solve_batch` returns."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.solvers.count_statuses import count_statuses


class SolverStatus(IntEnum):
    """How the search for one target ended."""

    INVALID_INPUT = 0
    """NaN, infinite (beyond 1e100 m), or not a pose: nothing was tried."""
    SOLVED = 1
    """Within the tolerance, and inside the limits unless they are ignored."""
    UNREACHABLE = 2
    """No posture can reach it: proven from the lengths of the links or the plane of the arm."""
    NOT_SOLVED = 3
    """Nothing within the tolerance was found; that does not prove that there is nothing."""


@dataclass(frozen=True)
class BatchSolution:
    """Joint positions for N targets, and how good they are."""

    q: Array
    """(N,n) joint positions [rad or m]; of a failed target the best ones found, never NaN."""
    success: Bools
    """(N,): within the tolerance."""
    status: NDArray[np.int_]
    """(N,): values of `SolverStatus`."""
    cycles: NDArray[np.int_]
    """(N,): control cycles of all starts up to the one that is the answer."""
    position_error: Array
    """(N,) [m]; NaN for invalid targets."""
    rotation_error: Array
    """(N,) [rad]; 0 for positions, NaN for invalid targets."""

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        counts = count_statuses(self.status, SolverStatus)
        return f"<BatchSolution: {counts or 'no targets'}>"
