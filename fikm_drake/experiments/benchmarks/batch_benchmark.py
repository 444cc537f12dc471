"""Inverse kinematics of many poses, ours beside roboticstoolbox's (`fikm-drake benchmark batch`)."""

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from statistics import median
from typing import Any

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.batch.batch_targets import rotation_error
from fikm_drake.solvers.batch.problem import TOLERANCE
from fikm_drake.solvers.solver import solve_batch

HOME = {
    "iiwa14": (0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0),
    "panda": (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
}
"""Ready postures [rad]; other arms start in the middle of their limits."""
OURS = "fikm_drake solve_batch"
PEER = "roboticstoolbox ik_LM"
PEER_DAMPING = 0.1
"""Its parameter k, the fastest of 1 (its default), 0.1 and 0.01."""

Solver = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class BatchCost:
    """One solver on the poses of one arm."""

    arm: str
    """Name of the arm."""
    limits: bool
    """Whether solutions must lie inside the joint limits."""
    solver: str
    """`OURS` or `PEER`."""
    success: float
    """Poses reached within 1 mm and 0.5°, checked by `DhArm.forward_kinematics` [%]."""
    cycles: float
    """Median cycles (ours) or iterations over all searches (roboticstoolbox's) a pose [-]."""
    microseconds: float
    """Median over the rounds of the time a pose [µs]."""


def batch_benchmark(
    *,
    arms: Sequence[str] = ("iiwa14", "panda"),
    targets: int = 1000,
    rounds: int = 5,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> list[BatchCost]:
    """Solve random reachable poses of arms, with their joint limits and without.

    Each round has poses of its own, of postures uniform inside the joint limits. All solvers start at
    the arm's home posture and may restart at random. They take turns on the same poses, so that a
    noisy machine disturbs them alike; time is of the wall clock. Where roboticstoolbox can be
    imported, its compiled `ik_LM` takes part at its best: the arm as an elementary transform
    sequence with merged constants, its default restarts, the fastest damping, and a residual that is
    surely within 1 mm.

    Args:
        arms: names of models; their joints have limits.
        targets: poses in a round.
        rounds: how often.
        seed: of the poses.
        progress: called after each round of each arm with the fraction done.

    Raises:
        ValueError: targets or rounds is not positive.
        FileNotFoundError: there is no such arm.
    """
    for name, value in (("targets", targets), ("rounds", rounds)):
        if value < 1:
            raise ValueError(f"{name} must be positive, got {value}")
    costs = []
    for i, name in enumerate(arms):
        arm = load_arm(name)
        home = np.array(HOME.get(name, 0.5 * (arm.lower + arm.upper)))
        solvers = {
            (limits, solver): make(arm, home, limits)
            for limits in (False, True)
            for solver, make in _makers().items()
        }
        runs: dict[tuple[bool, str], list[tuple[float, float, Array]]] = {
            key: [] for key in solvers
        }
        rng = np.random.default_rng(seed)
        for solve in solvers.values():  # the first call is slower
            solve(arm.forward_kinematics(home)[None])
        for k in range(rounds):
            X = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (targets, arm.num_joints)))
            for key, solve in solvers.items():
                runs[key].append(_timed(arm, solve, X, key[0]))
            if progress:
                progress((i * rounds + k + 1) / (len(arms) * rounds))
        costs += [
            BatchCost(
                name,
                limits,
                solver,
                100.0 * float(np.mean([success for _, success, _ in done])),
                float(np.median(np.concatenate([cycles for _, _, cycles in done]))),
                1e6 * median(seconds for seconds, _, _ in done) / targets,
            )
            for (limits, solver), done in runs.items()
        ]
    return costs


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = batch_benchmark(rounds=rounds, progress=progress)
    lines = [
        "random reachable poses from a home posture, within 1 mm and 0.5°, time a pose (median)"
    ]
    for cost in costs:
        limits = "inside limits" if cost.limits else "limits ignored"
        lines.append(
            f"  {cost.arm:8s} {limits:15s} {cost.solver:24s} {cost.success:7.2f} %"
            f"  {cost.microseconds:6.1f} µs  {cost.cycles:4.0f} cycles"
        )
    return BenchmarkTable(lines, costs)


def _timed(arm: DhArm, solve: Solver, X: Array, limits: bool) -> tuple[float, float, Array]:
    """Seconds, fraction of the poses that are reached, cycles of each."""
    gc.collect()
    start = time.perf_counter()
    q, cycles = solve(X)
    seconds = time.perf_counter() - start
    Y = arm.forward_kinematics(q)
    R, S = (np.moveaxis(Z[:, :3, :3], 0, -1).swapaxes(0, 1) for Z in (Y, X))
    reached = np.linalg.norm(Y[:, :3, 3] - X[:, :3, 3], axis=1) <= TOLERANCE[0] * (1 + 1e-9)
    reached &= rotation_error(R, S)[1] <= TOLERANCE[1] * (1 + 1e-9)
    if limits:
        reached &= ((q >= arm.lower) & (q <= arm.upper)).all(axis=1)
    return seconds, float(np.mean(reached)), cycles


def _makers() -> dict[str, Callable[[DhArm, Array, bool], Solver]]:
    makers: dict[str, Callable[[DhArm, Array, bool], Solver]] = {OURS: _ours}
    if find_spec("roboticstoolbox"):
        makers[PEER] = _peer
    return makers


def _ours(arm: DhArm, home: Array, limits: bool) -> Solver:
    def solve(X: Array) -> tuple[Array, Array]:
        solution = solve_batch(arm, X, task="pose", initial_position=home, limits=limits)
        return solution.q, solution.cycles.astype(float)

    return solve


def _peer(arm: DhArm, home: Array, limits: bool) -> Solver:
    sequence = _sequence(arm)
    tol = 0.5 * TOLERANCE[0] ** 2  # of ½ |e|², e in m and rad

    def solve(X: Array) -> tuple[Array, Array]:
        found = [
            sequence.ik_LM(x, q0=home, tol=tol, joint_limits=limits, k=PEER_DAMPING) for x in X
        ]
        return np.array([s.q for s in found]), np.array([s.iterations for s in found], dtype=float)

    return solve


def _sequence(arm: DhArm) -> Any:
    """The arm as roboticstoolbox's ETS."""
    rtb = import_module("roboticstoolbox")
    elements = []
    for i, joint in enumerate(arm.table.joints):
        moving = rtb.ET.Rz if joint.is_revolute else rtb.ET.tz
        elements += [rtb.ET.SE3(arm.joint_origin(i)), moving(qlim=list(joint.limits))]
    return rtb.ETS([*elements, rtb.ET.SE3(arm.tool_pose)])
