"""Intervals of one joint, for one point and for many."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools

TURNING_POINT = "turning point"
"""Name of an end where no joint is at a limit: the joint turns back on the self-motion."""
FULL_TURN = "full turn"
"""Name of an end that is none: the joint turns on without end."""
END_NAMES = (
    TURNING_POINT,
    FULL_TURN,
    *(f"joint {j} {side}" for j in (1, 2, 3) for side in ("lower", "upper")),
)
"""What can end an interval, in the order of the codes of an `IntervalTable`."""


@dataclass(frozen=True)
class FeasibleInterval:
    """Positions of a joint for which some posture reaches the point within all limits."""

    lower: float
    """[rad]."""
    upper: float
    """[rad]."""
    lower_end: str
    """What ends it below: one of `END_NAMES`, such as `joint 3 upper` (its upper limit)."""
    upper_end: str
    """What ends it above."""

    @property
    def middle(self) -> float:
        """The position half-way [rad]."""
        return 0.5 * (self.lower + self.upper)


@dataclass(frozen=True)
class IntervalTable:
    """Feasible intervals of a joint for N points, at most K each, in ascending order.

    Entries past a point's count are NaN in `lower` and `upper` and −1 in the codes of the ends.
    """

    count: NDArray[np.int_]
    """(N,) intervals of each point; 0 where it is infeasible."""
    lower: Array
    """(N,K) [rad]."""
    upper: Array
    """(N,K) [rad]."""
    lower_end: NDArray[np.int_]
    """(N,K) index in `END_NAMES` of what ends an interval below."""
    upper_end: NDArray[np.int_]
    """(N,K) the same above."""

    def __len__(self) -> int:
        return len(self.count)

    def __getitem__(self, i: int) -> list[FeasibleInterval]:
        """The intervals of one point."""
        return [
            FeasibleInterval(
                float(self.lower[i, k]),
                float(self.upper[i, k]),
                END_NAMES[self.lower_end[i, k]],
                END_NAMES[self.upper_end[i, k]],
            )
            for k in range(self.count[i])
        ]

    @property
    def feasible(self) -> Bools:
        """(N,): whether a posture reaches the point within all limits."""
        return self.count > 0

    @staticmethod
    def concatenated(tables: "list[IntervalTable]") -> "IntervalTable":
        """One table of the points of several, in their order."""
        most = max(table.lower.shape[1] for table in tables)

        def column(name: str, filler: float) -> NDArray:
            values = [getattr(table, name) for table in tables]
            widths = [((0, 0), (0, most - part.shape[1])) for part in values]
            padded = [np.pad(p, width, constant_values=filler) for p, width in zip(values, widths)]
            return np.concatenate(padded)

        count = np.concatenate([table.count for table in tables])
        bounds = column("lower", np.nan), column("upper", np.nan)
        return IntervalTable(count, *bounds, column("lower_end", -1), column("upper_end", -1))

    def widest(self) -> tuple[Array, Array]:
        """Lower and upper bound (N,) of the widest interval of each point [rad], NaN for none."""
        if not self.lower.shape[1]:
            return np.full(len(self), np.nan), np.full(len(self), np.nan)
        width = np.where(np.isnan(self.lower), -1.0, self.upper - self.lower)
        rows, best = np.arange(len(self)), np.argmax(width, axis=1)
        return self.lower[rows, best], self.upper[rows, best]
