"""The search for many targets at once: first starts, restarts, the nearest postures; in numpy or in C."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel, address, kernel
from fikm_drake.solvers.batch import descent as constants
from fikm_drake.solvers.batch.batch_solution import SolverStatus
from fikm_drake.solvers.batch.batch_targets import FARTHEST, ORTHONORMAL, BatchTargets, are_valid
from fikm_drake.solvers.batch.descent import LENGTH, Descent, Ends
from fikm_drake.solvers.batch.descent_of_one import DescentOfOne
from fikm_drake.solvers.batch.problem import Problem

CHUNK = 2048
"""Starts that run side by side: their arrays stay in the processor's cache."""
RESTARTS = (4, 64)
"""Restarts of a target that run side by side at first, twice as many each time after, and at most."""
ALONE = 8
"""Restarts of an only target, one after the other, before others run side by side."""
STATUS, CYCLES, POSITION, ROTATION = range(4)
"""Columns of a search's figures."""


class NumpySearch:
    """The search in numpy.

    Args:
        problem: what is searched for.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        limits = (problem.normal.lower, problem.normal.upper) if problem.limits else None
        self._quick = Descent(problem.normal, limits, problem.normal_tolerance, problem.max_cycles)
        self._careful = replace(self._quick, max_cycles=2 * problem.max_cycles, careful=True)

    def run(self, targets: Array, start: Array | None) -> tuple[Array, Array]:
        """Search for targets.

        Args:
            targets: (N,3) [m] or (N,4,4).
            start: (n,) or (N,n) [rad or m], or None: the nearest posture of the pool.

        Returns:
            Joint positions (N,n) [rad or m], those of invalid targets 0; figures (N,4): status,
            cycles, errors of position [m] and rotation [rad].
        """
        problem, count = self._problem, len(targets)
        n, scale = problem.chain.num_joints, problem.chain.reach
        q, figures = np.zeros((count, n)), np.zeros((count, 4))
        figures[:, POSITION:] = np.nan
        if start is not None:
            q[:] = start / problem.unit
        which, nearest = np.flatnonzero(are_valid(targets)), int(start is None)
        tried = self._one(q, figures, targets, nearest) if count == which.size == 1 else None
        if tried is None:
            self._first_starts(q, figures, targets, which, start is None)
            tried = nearest
        self._restarts(q, figures, targets, tried, nearest + problem.restarts)
        # The best of a target that stays unsolved is where a quick start was given up: go on there.
        for rows in _chunks(np.flatnonzero(figures[:, STATUS] == SolverStatus.NOT_SOLVED), CHUNK):
            wanted = BatchTargets.from_array(targets[rows], scale)
            here = np.ascontiguousarray(q[rows].T)
            _write(q, figures, rows, self._careful.run(here, wanted, np.arange(rows.size)))
        figures[:, POSITION] *= scale
        return problem.inside(q * problem.unit), figures

    def _first_starts(
        self, q: Array, figures: Array, targets: Array, which: NDArray[np.intp], nearest: bool
    ) -> None:
        problem = self._problem
        for chunk in _chunks(which, CHUNK):
            wanted = BatchTargets.from_array(targets[chunk], problem.chain.reach)
            if nearest:
                q[chunk] = problem.pool.q[:, problem.pool.nearest(wanted, 1)[:, 0]].T
            far = problem.reach.beyond(wanted)
            for here, descent in ((~far, self._quick), (far, self._careful)):
                rows = chunk[here]
                some = wanted.take(np.flatnonzero(here))
                begin = np.ascontiguousarray(q[rows].T)
                if rows.size:
                    ends = descent.run(begin, some, np.arange(rows.size))
                    _write(q, figures, rows, ends)
            far &= figures[chunk, STATUS] != SolverStatus.SOLVED
            figures[chunk[far], STATUS] = SolverStatus.UNREACHABLE

    def _one(self, q: Array, figures: Array, targets: Array, nearest: int) -> int | None:
        """The first starts of the only target, one after the other.

        Returns:
            How many postures of the pool were among them; None: proven to be out of reach, untried.
        """
        problem = self._problem
        wanted = BatchTargets.from_array(targets, problem.chain.reach)
        if problem.reach.beyond(wanted)[0]:
            return None
        descent, begins = DescentOfOne(self._quick, wanted), problem.pool.q.T
        tried, most, ranked = 0, nearest + min(ALONE, problem.restarts), None
        end = best = None if nearest else descent.run(q[0])
        spent = end.cycles if end else 0
        while (best is None or best.size >= 0.0) and tried < most:
            if ranked is None:
                ranked = problem.pool.nearest(wanted, most)[0]
            end = descent.run(begins[ranked[tried]])
            best = end if best is None or end.size < best.size else best
            tried, spent = tried + 1, spent + end.cycles
        if best:
            solved = SolverStatus.SOLVED if best.size < 0.0 else SolverStatus.NOT_SOLVED
            q[0], figures[0] = best.q, (solved, spent, best.distance, best.angle)
        return tried

    def _restarts(self, q: Array, figures: Array, targets: Array, tried: int, last: int) -> None:
        pool, scale, batch = self._problem.pool, self._problem.chain.reach, RESTARTS[0]
        while tried < last:
            batch = min(batch, last - tried)
            unsolved = np.flatnonzero(figures[:, STATUS] == SolverStatus.NOT_SOLVED)
            if not unsolved.size:
                return
            for rows in _chunks(unsolved, max(1, CHUNK // batch)):
                wanted = BatchTargets.from_array(targets[rows], scale)
                owners = np.repeat(np.arange(rows.size), batch)
                begin = pool.q[:, pool.nearest(wanted, batch, tried).ravel()]
                ends = self._quick.run(begin, wanted.take(owners), owners)
                _write(q, figures, rows, ends.best_of(batch))
            tried, batch = tried + batch, min(2 * batch, RESTARTS[1])


class NativeSearch:
    """The same by the native kernel.

    Args:
        problem: what is searched for.
        loaded: the kernel.
    """

    def __init__(self, problem: Problem, loaded: Kernel) -> None:
        chain, pool = problem.normal, problem.pool
        self._problem, self._kernel = problem, loaded
        lower = problem.chain.lower if problem.limits else np.full(chain.num_joints, -np.inf)
        upper = problem.chain.upper if problem.limits else np.full(chain.num_joints, np.inf)
        limits = np.column_stack([lower, upper, problem.unit])
        position, axes = pool.features
        squares = np.sum(position * position, axis=0)
        rows = [position, axes, squares[None], squares[None] + np.sum(axes * axes, axis=0)]
        self._arrays = (
            np.concatenate([chain.packed(), limits.ravel()]),
            np.array(_options(problem)),
            np.ascontiguousarray(pool.q.T),
            np.concatenate(rows),
        )
        self._addresses = [address(array) for array in self._arrays]

    def run(self, targets: Array, start: Array | None) -> tuple[Array, Array]:
        """As `NumpySearch.run`, of contiguous arrays."""
        count, n = len(targets), self._problem.chain.num_joints
        q, figures = np.zeros((count, n)), np.empty((count, 4))
        chain, options, pool, features = self._addresses
        failed = self._kernel.solve(
            *(chain, n, options, pool, features, len(self._arrays[2]), count, address(targets)),
            None if start is None else address(start),
            0 if start is None or start.ndim == 1 else n,
            *(address(q), address(figures)),
        )
        if failed:
            raise MemoryError("the native kernel found no memory")
        return self._problem.inside(q), figures


def make_search(problem: Problem, native: bool = True) -> NumpySearch | NativeSearch:
    """The fastest search that there is, or that of numpy."""
    loaded = kernel() if native else None
    if loaded is None or problem.chain.num_joints > MOST_JOINTS:
        return NumpySearch(problem)
    return NativeSearch(problem, loaded)


def _options(problem: Problem) -> list[float]:
    """The numbers of `native/kernel.c`, in its order."""
    return [
        float(problem.pose),
        *problem.normal_tolerance,
        LENGTH,
        constants.STEP,
        *constants.DAMPING,
        constants.FLOOR,
        constants.BLOCKED,
        constants.AT_LIMIT,
        *constants.EXTRA_DAMPING,
        *constants.EXTRA_FACTORS,
        float(problem.max_cycles),
        float(problem.restarts),
        constants.WINDOWS[0],
        constants.PROGRESS[0],
        constants.WINDOWS[1],
        constants.PROGRESS[1],
        problem.chain.reach,
        ORTHONORMAL,
        FARTHEST,
        *problem.reach.numbers(),
    ]


def _write(q: Array, figures: Array, rows: NDArray[np.intp], ends: Ends) -> None:
    """Enter what is better than before."""
    turn = LENGTH * figures[rows, ROTATION]
    before = np.sqrt(figures[rows, POSITION] ** 2 + turn * turn)
    better = np.isnan(before) | (ends.size < before)
    chosen = rows[better]
    q[chosen] = ends.q[:, better].T
    figures[chosen, POSITION:] = ends.errors[:, better].T
    solved = ends.size < 0.0
    figures[rows, STATUS] = np.where(solved, SolverStatus.SOLVED, SolverStatus.NOT_SOLVED)
    figures[rows, CYCLES] += ends.cycles


def _chunks(rows: NDArray[np.intp], size: int) -> Iterator[NDArray[np.intp]]:
    for start in range(0, rows.size, size):
        yield rows[start : start + size]
