"""Feasible intervals of a joint at many points: what a learner is trained on."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.files import whole_file
from fikm_drake.kinematics.angles import middle_of_limits
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer


@dataclass
class FeasibilityData:
    """What `generate_feasibility_data` returns: one row a point, NaN where it is infeasible."""

    points: Array
    """(N,m) points [m], or (N,4,4) poses."""
    count: NDArray[np.int_]
    """(N,) feasible intervals of the joint; 0: infeasible, −1: not computed yet."""
    lower: Array
    """(N,) lower bound of the widest interval [rad or m]."""
    upper: Array
    """(N,) upper bound of the widest interval [rad or m]."""
    closest: Array
    """(N,n) the posture within the limits that is closest to their middle [rad or m]."""
    source: str
    """The arm, the task and the joint that it was made for."""

    def __len__(self) -> int:
        return len(self.count)

    @property
    def feasible(self) -> Bools:
        """(N,): whether some posture reaches the point within the limits."""
        return self.count > 0

    def save(self, path: str | Path) -> None:
        """Write a .npz file; one that is there stays whole until the new one is."""
        with whole_file(path) as stream:
            np.savez_compressed(stream, **vars(self))

    @staticmethod
    def load(path: str | Path) -> "FeasibilityData":
        """Read a file that `save` has written.

        Raises:
            FileNotFoundError: there is none.
            ValueError: it is another kind of file.
        """
        try:
            with np.load(path) as file:
                columns = {name: file[name] for name in FeasibilityData.__annotations__}
        except (KeyError, ValueError, EOFError) as error:
            raise ValueError(f"{path} holds no feasibility data: {error}") from error
        return FeasibilityData(**columns | {"source": str(columns["source"])})


@dataclass(frozen=True)
class FeasibilityRows:
    """The columns of `FeasibilityData` for a few points; what a worker sends back."""

    count: NDArray[np.int_]
    lower: Array
    upper: Array
    closest: Array


def feasibility_rows(arm: DhArm, points: Array, task: str | None, joint: int) -> FeasibilityRows:
    """The data of some points, in closed form for `task` None, else traced."""
    if task is None:
        table = feasible_interval_table(arm, points)
        return FeasibilityRows(table.count, *table.widest(), closest_to_mid_range(arm, points))
    tracer = SelfMotionTracer(arm, task)
    middle = middle_of_limits(arm.lower, arm.upper)
    rows = FeasibilityRows(
        np.zeros(len(points), dtype=int),
        np.full(len(points), np.nan),
        np.full(len(points), np.nan),
        np.full((len(points), arm.num_joints), np.nan),
    )
    for i, point in enumerate(points):
        motion = tracer.trace(point)
        intervals = motion.intervals(joint)
        rows.count[i] = len(intervals)
        if intervals:
            widest = max(intervals, key=lambda interval: interval.upper - interval.lower)
            rows.lower[i], rows.upper[i] = widest.lower, widest.upper
            rows.closest[i] = motion.closest_to(middle)
    return rows


def empty_data(arm: DhArm, points: ArrayLike, source: str) -> FeasibilityData:
    """Data of points, none of them computed yet."""
    array = np.array(points, dtype=float)
    count = len(array)
    return FeasibilityData(
        array,
        np.full(count, -1),
        np.full(count, np.nan),
        np.full(count, np.nan),
        np.full((count, arm.num_joints), np.nan),
        source,
    )
