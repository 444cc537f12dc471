"""Thousands of poses at once, beside what the kinematics alone would take (`fikm-drake benchmark many`)."""

import resource
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fikm_drake.experiments.benchmarks.batch_benchmark import SEEDS
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.interleaved import jacobian_time
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.native.kernel import kernel_description
from fikm_drake.solvers.solver import Solver

ARMS = ("iiwa14", "panda", "ur5", "puma560", "jaco", "gen3", "xarm7")
MILLION = 50
"""The long call answers so many times as many."""


@dataclass(frozen=True)
class ManyCost:
    """Random reachable poses of one arm in one call."""

    arm: str
    """Name of the arm."""
    poses: int
    """In the call."""
    seed: int
    """Of the postures, uniform inside the limits and within half a turn."""
    missed: int
    """Poses that were not reached within 1 mm and 0.5°, inside the limits."""
    cpu: float
    """CPU time a pose, of all threads [µs]."""
    wall: float
    """Time a pose on the clock [µs]."""
    cycles: float
    """Mean number of cycles a pose, of all starts up to the one that arrived."""
    limit: float
    """CPU time of as many forward kinematics and Jacobians, at once and nothing else [µs]."""
    memory: float
    """What the process grew by, without targets and results [MB]."""


def many_benchmark(
    poses: int = 20_000,
    *,
    arms: Sequence[str] = ARMS,
    progress: Callable[[float], None] | None = None,
) -> list[ManyCost]:
    """Solve many poses of arms on each of three seeds; and of the first arm `MILLION` times as many.

    Args:
        poses: in a call.
        arms: names of models.
        progress: called after each call with the fraction done.

    Raises:
        ValueError: poses is not positive.
        FileNotFoundError: there is no such arm.
    """
    if poses < 1:
        raise ValueError(f"poses must be positive, got {poses}")
    calls = [(name, poses, seed) for name in arms for seed in SEEDS]
    calls += [(arms[0], MILLION * poses, SEEDS[0])]
    costs = []
    for k, (name, count, seed) in enumerate(calls):
        costs.append(_cost(load_arm(name), name, count, seed))
        if progress:
            progress((k + 1) / len(calls))
    return costs


def table(poses: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = many_benchmark(poses, progress=progress)
    lines = [
        f"random reachable poses within 1 mm and 0.5°, inside limits, in one call; {kernel_description()}",
        f"  {'arm':8s} {'poses':>8s} {'seed':>4s} {'missed':>6s} {'CPU µs':>7s} {'wall':>6s} {'cycles':>6s}"
        f" {'limit':>6s} {'MB':>5s}",
    ]
    lines += [
        f"  {c.arm:8s} {c.poses:8d} {c.seed:4d} {c.missed:6d} {c.cpu:7.2f} {c.wall:6.2f} {c.cycles:6.1f}"
        f" {c.limit:6.2f} {c.memory:5.0f}"
        for c in costs
    ]
    return BenchmarkTable(lines, costs)


def _cost(arm: DhArm, name: str, count: int, seed: int) -> ManyCost:
    rng, solver = np.random.default_rng(seed), Solver(arm, task="pose")
    span = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    X = arm.forward_kinematics(rng.uniform(*span, (count, arm.num_joints)))
    solver.solve(X[0])  # the first call makes the pool of postures
    before, cpu, wall = _peak(), time.process_time(), time.perf_counter()
    solution = solver.solve_batch(X)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    arrays = (solution.q, solution.success, solution.status, solution.cycles)
    kept = sum(a.nbytes for a in (*arrays, solution.position_error, solution.rotation_error))
    cycles = float(solution.cycles.mean())
    return ManyCost(
        name,
        count,
        seed,
        int((~solution.success).sum()),
        1e6 * cpu / count,
        1e6 * wall / count,
        cycles,
        1e6 * (cycles + 1.0) * jacobian_time(arm, solution.q),
        max(_peak() - before - kept, 0) / 1e6,
    )


def _peak() -> int:
    """The most memory that the process has had [bytes]."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most
