"""Inverse kinematics at the level of positions: made once for a chain, then one target or millions."""

import contextlib
import functools
import os
import pickle
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.executors import completed
from fikm_drake.kinematics.serial_chain import HasChain, SerialChain, as_chain
from fikm_drake.solvers.batch.batch_solution import BatchSolution, SolverStatus
from fikm_drake.solvers.batch.batch_targets import SHAPES, shaped_targets
from fikm_drake.solvers.batch.problem import TOLERANCE, Problem, checked_tolerance
from fikm_drake.solvers.batch.search import CYCLES, POSITION, ROTATION, STATUS, make_search

BLOCK = 8192
"""Targets that are answered together, by one thread; more of them bring nothing."""
LEAST_BLOCK = 512
"""Fewer are not worth a thread."""
REMOTE = 8
"""Workers that an executor is taken to have."""


@dataclass(frozen=True)
class Solution:
    """Joint positions for one target, and how good they are."""

    q: Array
    """(n,) joint positions [rad or m]; of a failed target the best ones found, never NaN."""
    success: bool
    """Within the tolerance."""
    status: SolverStatus
    """How the search ended."""
    position_error: float
    """[m]; NaN for an invalid target."""
    rotation_error: float
    """[rad]; 0 for a position, NaN for an invalid target."""
    cycles: int
    """Control cycles of all starts up to the one that is the answer."""


class Solver:
    """Joint positions that bring a chain's tool to targets.

    Each cycle is the fuzzy inverse kinematic mapping in its scaled, damped form (`batch.descent`), of at
    most a fifth of the chain's reach, with rotations scaled by a quarter of it. A joint at a limit that is
    pushed outward hardly counts, and no joint crosses a limit. A start without progress is given up; its
    target is then tried from the seeded random postures whose tool is nearest to it, and the first of them
    that arrives is the answer. What is left is followed to the nearest posture there; so is a target that
    is proven to be out of reach, from its first start only. Targets do not influence each other.

        solver = fd.Solver(fd.load_arm("panda"), task="pose")     # or a SerialChain, of a plant too
        solution = solver.solve(X_WE, start=q)                    # (4,4), (n,)
        if solution.success: q = solution.q
        many = solver.solve_batch(poses)                          # (N,4,4)

    With the native kernel a target takes microseconds, without it about half a millisecond; the answers are
    the same to rounding. A solver may be used by several threads.

    Args:
        arm: a `SerialChain`, or what has one.
        task: `position` or `pose` of the tool frame in the chain's base frame.
        tolerance: of the position [m], or of position [m] and rotation [rad].
        limits: False ignores the joints' limits.
        restarts: how many random postures a target is tried from.
        max_cycles: of each start; twice as many for the last search for the nearest posture.
        seed: of the random postures; it shares no stream with `numpy.random.default_rng(seed)`.
        native: False leaves the native kernel out, where there is one.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        arm: SerialChain | HasChain,
        *,
        task: str = "position",
        tolerance: float | tuple[float, float] = TOLERANCE,
        limits: bool = True,
        restarts: int = 250,
        max_cycles: int = 60,
        seed: int = 0,
        native: bool = True,
    ) -> None:
        self.chain = as_chain(arm)
        pair = checked_tolerance(tolerance)
        self._problem = Problem(self.chain, task, pair, limits, restarts, max_cycles, seed)
        self._search, self._native = make_search(self._problem, native), native
        self._shape = SHAPES[task]

    def __reduce__(self) -> tuple:
        """Pickled as its arguments: what is computed of them is computed again."""
        p = self._problem
        return functools.partial(
            Solver,
            task=p.task,
            tolerance=p.tolerance,
            limits=p.limits,
            restarts=p.restarts,
            max_cycles=p.max_cycles,
            seed=p.seed,
            native=self._native,
        ), (self.chain,)

    @property
    def task(self) -> str:
        """`position` or `pose`."""
        return self._problem.task

    def solve(self, target: ArrayLike, start: ArrayLike | None = None) -> Solution:
        """Answer one target.

        Args:
            target: a position (3,) [m] or a pose (4,4).
            start: (n,) [rad or m]; None: the nearest of the random postures.

        Returns:
            The solution. An invalid target (NaN, infinite, not a pose) has status `INVALID_INPUT` and
            keeps the start (if None: the middle of the limits).

        Raises:
            ValueError: a shape that does not fit, a start that is not finite or outside the limits.
        """
        array = np.array(target, dtype=float)
        if array.shape != self._shape:
            raise ValueError(
                f"target of task {self.task!r} must have shape {self._shape}, got {array.shape}"
            )
        if start is not None:
            start = self._problem.checked_start(start, ((self.chain.num_joints,),))
        q, figures = self._answers(array[None], start)
        status, cycles, position_error, rotation_error = figures[0].tolist()
        solved = status == SolverStatus.SOLVED
        return Solution(
            q[0], solved, SolverStatus(int(status)), position_error, rotation_error, int(cycles)
        )

    def solve_batch(
        self,
        targets: ArrayLike,
        initial_position: ArrayLike | None = None,
        *,
        threads: int | None = None,
        executor: Executor | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> BatchSolution:
        """Answer N targets.

        Beside its arguments and results it needs the memory of some thousand targets only.

            with ProcessPoolExecutor() as executor:
                solution = solver.solve_batch(poses, executor=executor)

        Args:
            targets: positions (N,3) [m] or poses (N,4,4).
            initial_position: where every target starts (n,), or one start a target (N,n) [rad or m].
                None: each starts at the nearest of the random postures, which is the fastest; give one
                where neighbouring targets should get neighbouring postures.
            threads: how many to use; None: one a processor. numpy uses one.
            executor: of any kind, such as ProcessPoolExecutor or Dask's, in place of threads; the answers
                are the same, to rounding where a worker has no native kernel and this process has.
            progress: called now and then with the fraction done, by the calling thread.

        Returns:
            One row a target. An invalid target keeps its initial position (if None: the middle of the
            limits).

        Raises:
            ValueError: naming the bad value and the valid ones.
        """
        array = shaped_targets(targets, self.task)
        n, count = self.chain.num_joints, len(array)
        if threads is not None:
            check_counts(threads=threads)
            if executor is not None:
                raise ValueError(f"threads {threads} is not used with an executor")
        start = initial_position
        if start is not None:
            start = self._problem.checked_start(start, ((n,), (count, n)))
        q, figures = np.empty((count, n)), np.empty((count, 4))
        workers = REMOTE if executor is not None else threads or _processors()
        size = min(BLOCK, max(LEAST_BLOCK, -(-count // (4 * workers))))
        blocks = [slice(i, min(i + size, count)) for i in range(0, count, size)]
        done = 0
        with _of_this_process(executor, min(workers, len(blocks))) as chosen:
            first = self if executor is None else pickle.dumps(self)
            jobs = [
                (
                    first,
                    array[rows],
                    start[rows] if start is not None and start.ndim == 2 else start,
                )
                for rows in blocks
            ]
            for number, answers in completed(chosen, _answer, jobs):
                rows = blocks[number]
                q[rows], figures[rows] = answers
                done += rows.stop - rows.start
                if progress:
                    progress(done / count)
        status = figures[:, STATUS].astype(int)
        return BatchSolution(
            q,
            status == SolverStatus.SOLVED,
            status,
            figures[:, CYCLES].astype(int),
            figures[:, POSITION].copy(),
            figures[:, ROTATION].copy(),
        )

    def _answers(self, targets: Array, start: Array | None) -> tuple[Array, Array]:
        """Joint positions (N,n) and figures (N,4)."""
        q, figures = self._search.run(np.ascontiguousarray(targets), start)
        invalid = figures[:, STATUS] == SolverStatus.INVALID_INPUT
        if invalid.any():
            keep = self._problem.middle if start is None else start
            q[invalid] = np.broadcast_to(keep, q.shape)[invalid]
        return q, figures


def _answer(solver: Solver | bytes, targets: Array, start: Array | None) -> tuple[Array, Array]:
    """A block's answers; a pickled solver comes from another process."""
    known = _unpickled(solver) if isinstance(solver, bytes) else solver
    return known._answers(targets, start)


@functools.lru_cache(maxsize=4)
def _unpickled(solver: bytes) -> Solver:
    """Kept, so that a worker makes a solver once for many blocks."""
    return pickle.loads(solver)


def _of_this_process(
    executor: Executor | None, workers: int
) -> contextlib.AbstractContextManager[Executor | None]:
    """The executor that was given, or threads, or nothing where one does it all."""
    if executor is not None or workers < 2:
        return contextlib.nullcontext(executor)
    return ThreadPoolExecutor(workers)


def solve(
    arm: SerialChain | HasChain,
    target: ArrayLike,
    start: ArrayLike | None = None,
    *,
    task: str = "position",
    tolerance: float | tuple[float, float] = TOLERANCE,
    limits: bool = True,
) -> Solution:
    """Answer one target, once; for more make a `Solver` and keep it.

        solution = fd.solve(fd.load_arm("iiwa14"), [0.5, 0.0, 0.5])

    Args:
        arm: a `SerialChain`, or what has one.
        target: a position (3,) [m] or a pose (4,4).
        start: (n,) [rad or m]; None: the nearest of the solver's random postures.
        task: `position` or `pose`.
        tolerance: of the position [m], or of position [m] and rotation [rad].
        limits: False ignores the joints' limits.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    return Solver(arm, task=task, tolerance=tolerance, limits=limits).solve(target, start)


def solve_batch(
    arm: SerialChain | HasChain,
    targets: ArrayLike,
    *,
    task: str = "position",
    initial_position: ArrayLike | None = None,
    tolerance: float | tuple[float, float] = TOLERANCE,
    limits: bool = True,
    restarts: int = 250,
    max_cycles: int = 60,
    seed: int = 0,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> BatchSolution:
    """Answer N targets: `Solver(arm, …).solve_batch(targets, …)`, which tell the arguments.

        solution = fd.solve_batch(arm, poses, task="pose", initial_position=home)
        solution.q[solution.success]

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    solver = Solver(
        arm,
        task=task,
        tolerance=tolerance,
        limits=limits,
        restarts=restarts,
        max_cycles=max_cycles,
        seed=seed,
    )
    return solver.solve_batch(
        targets, initial_position, threads=threads, executor=executor, progress=progress
    )


def _processors() -> int:
    """Those that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
