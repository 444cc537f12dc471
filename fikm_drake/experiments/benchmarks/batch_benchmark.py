"""Inverse kinematics of poses, one and many, ours beside roboticstoolbox's (`benchmark batch`)."""

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.native.kernel import kernel, kernel_description
from fikm_drake.solvers.batch.batch_targets import rotation_error
from fikm_drake.solvers.batch.problem import TOLERANCE
from fikm_drake.solvers.solver import Solver

HOME = {
    "iiwa14": (0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0),
    "panda": (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
}
"""Ready postures [rad]; other arms start in the middle of their limits."""
SEEDS = (0, 1, 77)
"""Seeds of the poses, a round each; more rounds go on from the last."""
SINGLES = 100
"""Poses of a round that are timed one by one."""
NATIVE, NUMPY, PEER = "Solver, native", "Solver, numpy", "roboticstoolbox ik_LM"
NEAREST = ", nearest start"
PEER_DAMPING = 0.1
"""Its parameter k, the fastest of 1 (its default), 0.1 and 0.01."""

Solve = Callable[[Array], Array]


@dataclass(frozen=True)
class BatchCost:
    """One solver on the poses of one arm."""

    arm: str
    """Name of the arm."""
    limits: bool
    """Whether solutions must lie inside the joint limits."""
    solver: str
    """`NATIVE`, `NUMPY` or `PEER`; with `NEAREST` it chooses its starts itself, else all start at home."""
    poses: int
    """In a call, of a batch; 1: one by one."""
    success: float
    """Poses reached within 1 mm and 0.5°, checked by `DhArm.forward_kinematics` [%]."""
    microseconds: float
    """CPU time a pose [µs]: of a batch the median over the rounds, one by one over all poses."""
    slowest: float
    """The same of the slowest round, or the 99th percentile of single poses [µs]."""


def batch_benchmark(
    *,
    arms: Sequence[str] = ("iiwa14", "panda", "puma560"),
    poses: int = 1000,
    rounds: int = len(SEEDS),
    progress: Callable[[float], None] | None = None,
) -> list[BatchCost]:
    """Solve random reachable poses of arms, inside their joint limits and without.

    Each round has poses of its own seed, of postures uniform inside the joint limits; the solvers' own
    random numbers are of other streams. All start at the arm's home posture and may restart at random.
    They take turns on the same poses, so that a noisy machine disturbs them alike; CPU time is that of
    all threads together. Where roboticstoolbox can be imported, its compiled `ik_LM` takes part at its
    best: the arm as an elementary transform sequence with merged constants, its default restarts, the
    fastest damping, and a residual that is surely within 1 mm.

    Args:
        arms: names of models; their joints have limits.
        poses: in a round.
        rounds: how many seeds.
        progress: called after each round of each arm with the fraction done.

    Raises:
        ValueError: poses or rounds is not positive.
        FileNotFoundError: there is no such arm.
    """
    for name, value in (("poses", poses), ("rounds", rounds)):
        if value < 1:
            raise ValueError(f"{name} must be positive, got {value}")
    seeds = [*SEEDS, *range(SEEDS[-1] + 1, SEEDS[-1] + rounds)][:rounds]
    costs = []
    for i, name in enumerate(arms):
        arm = load_arm(name)
        home = np.array(HOME.get(name, 0.5 * (arm.lower + arm.upper)))
        solvers = {
            (limits, solver): solve
            for limits in (True, False)
            for solver, solve in _solvers(arm, home, limits).items()
        }
        many: dict[tuple[bool, str], list[tuple[float, float]]] = {key: [] for key in solvers}
        single: dict[tuple[bool, str], list[float]] = {key: [] for key in solvers}
        for solve in solvers.values():  # the first call is slower
            solve(arm.forward_kinematics(home)[None])
        for k, seed in enumerate(seeds):
            rng = np.random.default_rng(seed)
            X = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (poses, arm.num_joints)))
            for key, solve in solvers.items():
                many[key].append(_timed(arm, solve, X, key[0]))
                single[key] += [_seconds(solve, x[None])[0] for x in X[:SINGLES]]
            if progress:
                progress((i * rounds + k + 1) / (len(arms) * rounds))
        for key in solvers:
            reached = float(np.mean([success for _, success in many[key]]))
            each = np.array([seconds for seconds, _ in many[key]]) / poses
            ones = np.array(single[key])
            for count, times, most in ((poses, each, 100.0), (1, ones, 99.0)):
                middle, slow = 1e6 * np.percentile(times, [50.0, most])
                costs.append(BatchCost(name, *key, count, 100.0 * reached, middle, slow))
    return costs


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = batch_benchmark(rounds=rounds, progress=progress)
    lines = [
        f"random reachable poses, within 1 mm and 0.5°, CPU time a pose; {kernel_description()}",
        "(median, and the slowest of the rounds of a batch, or the 99th percentile of single poses)",
    ]
    for cost in costs:
        limits = "inside limits" if cost.limits else "limits ignored"
        lines.append(
            f"  {cost.arm:8s} {limits:15s} {cost.solver:28s} {cost.poses:6d} at once"
            f"  {cost.success:7.3f} %  {cost.microseconds:8.1f} µs  {cost.slowest:8.1f} µs"
        )
    return BenchmarkTable(lines, costs)


def _solvers(arm: DhArm, home: Array, limits: bool) -> dict[str, Solve]:
    found: dict[str, Solve] = {}
    for name, native in ((NATIVE, True), (NUMPY, False)):
        if native and kernel() is None:
            continue
        solver = Solver(arm, task="pose", limits=limits, native=native)
        found[name] = _ours(solver, home)
        found[name + NEAREST] = _ours(solver, None)
    if find_spec("roboticstoolbox"):
        found[PEER] = _peer(arm, home, limits)
    return found


def _ours(solver: Solver, start: Array | None) -> Solve:
    def solve(X: Array) -> Array:
        if len(X) == 1:
            return solver.solve(X[0], start).q[None]
        return solver.solve_batch(X, start).q

    return solve


def _peer(arm: DhArm, home: Array, limits: bool) -> Solve:
    sequence = _sequence(arm)
    tol = 0.5 * TOLERANCE[0] ** 2  # of ½ |e|², e in m and rad

    def solve(X: Array) -> Array:
        return np.array(
            [sequence.ik_LM(x, q0=home, tol=tol, joint_limits=limits, k=PEER_DAMPING)[0] for x in X]
        )

    return solve


def _seconds(solve: Solve, X: Array) -> tuple[float, Array]:
    """CPU seconds, and the joint positions (N,n)."""
    start = time.process_time()
    q = solve(X)
    return time.process_time() - start, q


def _timed(arm: DhArm, solve: Solve, X: Array, limits: bool) -> tuple[float, float]:
    """CPU seconds, and the fraction of the poses that are reached."""
    gc.collect()
    seconds, q = _seconds(solve, X)
    Y = arm.forward_kinematics(q)
    R, S = (np.moveaxis(Z[:, :3, :3], 0, -1).swapaxes(0, 1) for Z in (Y, X))
    reached = np.linalg.norm(Y[:, :3, 3] - X[:, :3, 3], axis=1) <= TOLERANCE[0] * (1 + 1e-9)
    reached &= rotation_error(R, S)[1] <= TOLERANCE[1] * (1 + 1e-9)
    if limits:
        reached &= ((q >= arm.lower) & (q <= arm.upper)).all(axis=1)
    return seconds, float(np.mean(reached))


def _sequence(arm: DhArm) -> Any:
    """The arm as roboticstoolbox's ETS."""
    rtb = import_module("roboticstoolbox")
    elements = []
    for i, joint in enumerate(arm.table.joints):
        moving = rtb.ET.Rz if joint.is_revolute else rtb.ET.tz
        elements += [rtb.ET.SE3(arm.joint_origin(i)), moving(qlim=list(joint.limits))]
    return rtb.ETS([*elements, rtb.ET.SE3(arm.tool_pose)])
