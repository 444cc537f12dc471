"""Inverse kinematics of many targets at once."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.solvers.batch.batch_solution import BatchSolution, BatchStatus
from fikm_drake.solvers.batch.batch_targets import BatchTargets, checked_targets
from fikm_drake.solvers.batch.descent import LENGTH, Descent, Ends
from fikm_drake.solvers.batch.posture_pool import SIZE, PosturePool, start_range
from fikm_drake.solvers.batch.reach import out_of_reach

CHUNK = 2048
"""Starts that run side by side: their arrays stay in the processor's cache."""
RESTARTS = (4, 64)
"""Restarts of a target that run side by side at first, twice as many each time after, and at most."""
TOLERANCE = (1e-3, float(np.deg2rad(0.5)))
"""Of position [m] and rotation [rad]."""


def solve_batch(
    arm: DhArm,
    targets: ArrayLike,
    *,
    task: str = "position",
    initial_position: ArrayLike | None = None,
    tolerance: float | tuple[float, float] = TOLERANCE,
    limits: bool = True,
    restarts: int = 60,
    max_cycles: int = 60,
    seed: int = 0,
) -> BatchSolution:
    """Joint positions that bring the tool to each of N targets, found for all of them together.

    Each cycle is the fuzzy inverse kinematic mapping in its scaled, damped form (`batch_step`), of
    at most 0.2 m of error, rotations scaled by 0.3 m. A joint at a limit that is pushed outward
    hardly counts, and no joint crosses a limit. A start without progress is given up; its target is
    then tried from the seeded random postures whose tool is nearest to it, 4 side by side, then 8,
    16, …, and the first that arrives wins. What is left is followed to the nearest posture there; so is
    a target that is proven to be out of reach, from its first start only. Targets do not influence
    each other.

        solution = fd.solve_batch(arm, poses, task="pose", initial_position=home)
        solution.q[solution.success]

    Args:
        arm: the arm.
        targets: positions (N,3) [m] or poses (N,4,4) of the tool frame in the base frame.
        task: `position` or `pose`.
        initial_position: where every target starts (n,), or one start a target (N,n) [rad or m].
            None: each starts at the nearest of 1024 random postures, which is the fastest; give one where
            neighbouring targets should get neighbouring postures.
        tolerance: of the position [m], or of position [m] and rotation [rad].
        limits: False ignores the joints' limits.
        restarts: how many random postures a target is tried from.
        max_cycles: of each start; twice as many for the last search for the nearest posture.
        seed: of the random postures.

    Returns:
        One row a target. An invalid target (NaN, infinite, not a pose) keeps its initial position (if
        None: the middle of the limits).

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    array, valid = checked_targets(targets, task)
    pair = _checked_tolerance(tolerance)
    check_counts(0, restarts=restarts, seed=seed)
    check_counts(max_cycles=max_cycles)
    start = _checked_start(arm, initial_position, len(array), limits)

    n, count = arm.num_joints, len(array)
    solution = BatchSolution(
        np.array(np.broadcast_to(_middle(arm) if start is None else start, (count, n))),
        np.zeros(count, dtype=bool),
        np.full(count, BatchStatus.INVALID_TARGET.value),
        np.zeros(count, dtype=int),
        np.full(count, np.nan),
        np.full(count, np.nan),
    )
    chain = arm.chain
    pool = PosturePool(chain, LENGTH, seed, max(SIZE, restarts + 1))
    bounds = (arm.lower, arm.upper) if limits else None
    quick = Descent(chain, bounds, pair, max_cycles)
    careful = replace(quick, max_cycles=2 * max_cycles, careful=True)
    for chunk in _chunks(np.flatnonzero(valid), CHUNK):
        far = out_of_reach(arm, array[chunk], pair, limits=limits)
        for rows, descent in ((chunk[~far], quick), (chunk[far], careful)):
            wanted = BatchTargets.from_array(array[rows])
            q = pool.q[:, pool.nearest(wanted, 1)[:, 0]] if start is None else solution.q[rows].T
            ends = descent.run(np.ascontiguousarray(q), wanted, np.arange(rows.size))
            _write(solution, rows, ends)
        far &= ~solution.success[chunk]
        solution.status[chunk[far]] = BatchStatus.OUT_OF_REACH
    tried, batch = (1 if start is None else 0), RESTARTS[0]
    last = tried + restarts
    while tried < last:
        batch = min(batch, last - tried)
        unsolved = np.flatnonzero(solution.status == BatchStatus.NOT_SOLVED)
        for rows in _chunks(unsolved, max(1, CHUNK // batch)):
            wanted = BatchTargets.from_array(array[rows])
            owners = np.repeat(np.arange(rows.size), batch)
            q = pool.q[:, pool.nearest(wanted, batch, tried).ravel()]
            _write(solution, rows, quick.run(q, wanted.take(owners), owners).best_of(batch))
        tried, batch = tried + batch, min(2 * batch, RESTARTS[1])
    # The best of a target that stays unsolved is where a quick start was given up: go on from there.
    for rows in _chunks(np.flatnonzero(solution.status == BatchStatus.NOT_SOLVED), CHUNK):
        wanted = BatchTargets.from_array(array[rows])
        q = np.ascontiguousarray(solution.q[rows].T)
        _write(solution, rows, careful.run(q, wanted, np.arange(rows.size)))
    return solution


def _write(solution: BatchSolution, rows: NDArray[np.intp], ends: Ends) -> None:
    """Enter what is better than before."""
    errors = np.array([solution.position_error[rows], LENGTH * solution.rotation_error[rows]])
    before = np.sqrt(np.sum(errors * errors, axis=0))
    better = np.isnan(before) | (ends.size < before)
    chosen = rows[better]
    solution.q[chosen] = ends.q[:, better].T
    solution.position_error[chosen], solution.rotation_error[chosen] = ends.errors[:, better]
    solved = ends.size < 0.0
    solution.success[rows] = solved
    solution.status[rows] = np.where(solved, BatchStatus.SOLVED, BatchStatus.NOT_SOLVED)
    solution.cycles[rows] += ends.cycles


def _chunks(rows: NDArray[np.intp], size: int) -> Iterator[NDArray[np.intp]]:
    for start in range(0, rows.size, size):
        yield rows[start : start + size]


def _middle(arm: DhArm) -> Array:
    return np.mean(start_range(arm.chain), axis=0)


def _checked_tolerance(tolerance: float | tuple[float, float]) -> tuple[float, float]:
    values = np.asarray(tolerance, dtype=float)
    if values.shape not in ((), (2,)) or not (np.isfinite(values).all() and (values > 0).all()):
        raise ValueError(
            f"tolerance must be a positive position [m], or two positive numbers, position [m] and "
            f"rotation [rad], got {tolerance!r}"
        )
    if values.ndim == 0:
        return float(values), TOLERANCE[1]
    return float(values[0]), float(values[1])


def _checked_start(
    arm: DhArm, initial_position: ArrayLike | None, count: int, limits: bool
) -> Array | None:
    if initial_position is None:
        return None
    start, n = np.asarray(initial_position, dtype=float), arm.num_joints
    if start.shape not in ((n,), (count, n)):
        raise ValueError(
            f"initial_position must have shape ({n},) or ({count}, {n}), got {start.shape}"
        )
    lower, upper = (arm.lower, arm.upper) if limits else (np.full(n, -np.inf), np.full(n, np.inf))
    outside = ~(np.isfinite(start) & (start >= lower) & (start <= upper))
    if outside.any():
        where = tuple(np.argwhere(outside)[0])
        joint = where[-1]
        raise ValueError(
            f"initial_position of joint {joint + 1} must be finite and in "
            f"[{lower[joint]}, {upper[joint]}], got {start[where]}"
        )
    return start
