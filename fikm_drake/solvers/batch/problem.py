"""What a search needs to know: the chain with its reach as the unit of length, targets' kind, limits."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.unit_chain import joint_units, unit_chain
from fikm_drake.solvers.batch.batch_targets import TASKS
from fikm_drake.solvers.batch.descent import LENGTH
from fikm_drake.solvers.batch.posture_pool import SIZE, PosturePool, start_range
from fikm_drake.solvers.batch.reach import Reach

TOLERANCE = (1e-3, float(np.deg2rad(0.5)))
"""Tolerance of position [m] and rotation [rad]."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A chain and how its targets are to be met; `solvers.solver.Solver` tells the fields.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    chain: SerialChain
    task: str
    tolerance: tuple[float, float]
    limits: bool
    restarts: int
    max_cycles: int
    seed: int

    def __post_init__(self) -> None:
        if self.task not in TASKS:
            raise ValueError(f"task must be one of {TASKS}, got {self.task!r}")
        check_counts(0, restarts=self.restarts, seed=self.seed)
        check_counts(max_cycles=self.max_cycles)

    @property
    def pose(self) -> bool:
        """Whether targets are poses, else positions."""
        return self.task == "pose"

    @cached_property
    def unit(self) -> Array:
        """(n,): 1 for a joint that turns; the reach [m] for one that slides."""
        return joint_units(self.chain)

    @cached_property
    def normal(self) -> SerialChain:
        """The chain with lengths divided by its reach, so that arms of all sizes are alike."""
        return unit_chain(self.chain)

    @cached_property
    def normal_tolerance(self) -> tuple[float, float]:
        """Normal tolerance of position [reach] and rotation [rad]."""
        return self.tolerance[0] / self.chain.reach, self.tolerance[1]

    @cached_property
    def pool(self) -> PosturePool:
        """Postures to start from, enough for all restarts, in multiples of 8 for the kernel."""
        size = max(SIZE, 8 * -(-(self.restarts + 1) // 8))
        return PosturePool(self.normal, LENGTH, self.seed, size)

    @cached_property
    def reach(self) -> Reach:
        """Proofs that a target is out of reach."""
        return Reach(self.normal, self.pose, self.normal_tolerance, self.limits)

    @cached_property
    def middle(self) -> Array:
        """(n,): where invalid targets leave the joints."""
        return np.mean(start_range(self.chain), axis=0)

    def inside(self, q: Array) -> Array:
        """Joint positions (…,n) [rad or m], with what rounding put past a limit put back."""
        return np.clip(q, self.chain.lower, self.chain.upper) if self.limits else q

    def checked_start(self, start: ArrayLike, shapes: tuple[tuple[int, ...], ...]) -> Array:
        """A start, finite and inside the limits.

        Raises:
            ValueError: naming the joint.
        """
        q, chain = np.asarray(start, dtype=float), self.chain
        if q.shape not in shapes:
            allowed = " or ".join(map(str, shapes))
            raise ValueError(f"initial_position must have shape {allowed}, got {q.shape}")
        # NaN compares false.
        if (np.abs(q) < np.inf).all():
            if not self.limits or ((q >= chain.lower) & (q <= chain.upper)).all():
                return np.ascontiguousarray(q)
        lower = chain.lower if self.limits else np.full(chain.num_joints, -np.inf)
        upper = chain.upper if self.limits else np.full(chain.num_joints, np.inf)
        where = tuple(np.argwhere(~(np.isfinite(q) & (q >= lower) & (q <= upper)))[0])
        joint = where[-1]
        raise ValueError(
            f"initial_position[{joint}] must be finite and in "
            f"[{lower[joint]}, {upper[joint]}], got {q[where]}"
        )


def checked_tolerance(tolerance: float | tuple[float, float]) -> tuple[float, float]:
    """Position [m] and rotation [rad], the second by default.

    Raises:
        ValueError: not positive numbers.
    """
    values = np.asarray(tolerance, dtype=float)
    if values.shape not in ((), (2,)) or not (np.isfinite(values).all() and (values > 0).all()):
        raise ValueError(
            f"tolerance must be a positive position [m], or two positive numbers, position [m] and "
            f"rotation [rad], got {tolerance!r}"
        )
    if values.ndim == 0:
        return float(values), TOLERANCE[1]
    return float(values[0]), float(values[1])
