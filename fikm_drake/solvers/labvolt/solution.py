"""What `labvolt.solve` returns."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.solvers.count_statuses import count_statuses


class LabVoltStatus(IntEnum):
    """How one target ended."""

    INVALID_INPUT = 0
    """NaN, infinite or beyond 1e100 m: nothing was tried, the angles are the middle of the limits."""
    SOLVED = 1
    """Reached by the method's first way."""
    FELL_BACK = 2
    """Reached, but by a later way of the method."""
    NOT_SOLVED = 3
    """Can be reached, but the method did not find how: a local minimum, or no guess of θ_3."""
    UNREACHABLE = 4
    """Proven to be out of reach by more than the tolerance: the angles are those of the nearest reachable
    point."""
    TURNED = 5
    """Reached, but not at the approach angle that was asked for: at the nearest one."""


@dataclass(frozen=True)
class LabVoltSolution:
    """Angles for N targets, and how good they are."""

    angles: Array
    """(N,3) θ_1, θ_2, θ_3 from the horizontal [rad], inside the limits, never NaN."""
    yaw: Array
    """(N,) of the base, atan2(y, x) [rad]; zeros for targets in the arm's plane."""
    success: Bools
    """(N,): the tool is within the tolerance of the target, by forward kinematics."""
    status: NDArray[np.int_]
    """(N,): values of `LabVoltStatus`."""
    error: Array
    """(N,): distance of the tool from the target [m]; NaN for invalid targets."""
    tries: NDArray[np.int_]
    """(N,): guesses of θ_3 plus starts of the SQP; 0 where nothing had to be tried."""
    nearest: Array
    """(N,2) or (N,3), as the targets: the reachable point nearest to the target [m]; NaN for invalid
    targets. The target itself where it can be reached."""
    distance: Array
    """(N,): of the target from `nearest` [m]: 0 where it can be reached, NaN for invalid targets."""

    approach_error: Array
    """(N,): θ_3 less the approach angle that was asked for, in [−π, π] [rad]; 0 where none was, NaN where
    the target cannot be reached."""

    def __len__(self) -> int:
        return len(self.angles)

    @property
    def joints(self) -> Array:
        """(N,4) joint positions of `models/labvolt5250.yaml`: yaw and the relative angles [rad]."""
        relative = np.diff(self.angles, axis=1, prepend=0.0)
        return np.column_stack([self.yaw, relative])

    def __repr__(self) -> str:
        counts = count_statuses(self.status, LabVoltStatus)
        return f"<LabVoltSolution: {counts or 'no targets'}>"
