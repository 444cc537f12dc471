"""Cost of fuzzy rate control beside the pseudo-inverse (`fikm-drake benchmark frmrc`)."""

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.task import Task
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.jacobian_transpose import JacobianTranspose
from fikm_drake.laws.law import Law
from fikm_drake.laws.pseudo_inverse import PseudoInverse

TASKS = (("kim_lee3r", "xy"), ("iiwa14", "position"), ("iiwa14", "pose"))
CASES, STEPS = 10_000, 200
"""Jacobians in a batch, and one by one."""
PINV, DAMPED = "pseudo-inverse", "damped least squares"


@dataclass(frozen=True)
class RateCost:
    """One law on the Jacobians of one arm's task."""

    arm: str
    """Name of the arm."""
    task: str
    """The rows of its Jacobian that count."""
    law: str
    """Name of the law in `laws`."""
    batch: float
    """CPU time of a case in a batch, median over the rounds [µs]."""
    speedup: float
    """How many times faster than the pseudo-inverse's batch, median over the rounds [-]."""
    over_damped: float
    """How many times faster than the batch of damped least squares, median over the rounds [-]."""
    step: float
    """CPU time of a case alone, `law.step`, median over the rounds [µs]."""


def laws() -> dict[str, Law]:
    """What is compared."""
    return {
        "smooth": FuzzyRateControl(),
        "smooth, 3 sweeps": FuzzyRateControl(sweeps=3),
        "paper": FuzzyRateControl("paper"),
        PINV: PseudoInverse(),
        DAMPED: DampedLeastSquares(),
        "Jacobian transpose": JacobianTranspose(),  # two products, and hardly less can be done
    }


def rate_benchmark(
    *, rounds: int = 10, cases: int = CASES, progress: Callable[[float], None] | None = None
) -> list[RateCost]:
    """Time the laws on the Jacobians of random postures, in a batch and one by one.

    They take turns, so that a noisy machine disturbs them alike. The pseudo-inverse is numpy's
    `linalg.pinv` of the whole batch.

    Args:
        rounds: how often.
        cases: Jacobians in a batch.
        progress: called after each round with the fraction done.

    Raises:
        ValueError: rounds or cases is not positive.
    """
    for name, value in (("rounds", rounds), ("cases", cases)):
        if value < 1:
            raise ValueError(f"{name} must be positive, got {value}")
    costs = []
    for i, (arm, task) in enumerate(TASKS):
        J, dr = _cases(arm, task, cases)
        times: dict[str, list[tuple[float, float]]] = {name: [] for name in laws()}
        for k in range(rounds):
            for name, law in laws().items():
                times[name].append((_batch_time(law, J, dr), _step_time(law, J, dr)))
            if progress:
                progress((i * rounds + k + 1) / (len(TASKS) * rounds))
        batches = {name: np.array([batch for batch, _ in done]) for name, done in times.items()}
        costs += [
            RateCost(
                arm,
                task,
                name,
                1e6 * float(np.median(batch)),
                float(np.median(batches[PINV] / batch)),
                float(np.median(batches[DAMPED] / batch)),
                1e6 * median(step for _, step in times[name]),
            )
            for name, batch in batches.items()
        ]
    return costs


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    results = rate_benchmark(rounds=rounds, progress=progress)
    lines = [f"CPU time of a joint step, {CASES} Jacobians in a batch and one by one (median)"]
    lines += [
        f"  {cost.arm:9s} {cost.task:8s} {cost.law:20s} batch {cost.batch:6.3f} µs,"
        f" {cost.speedup:5.1f} times faster than {PINV}, {cost.over_damped:4.1f} than {DAMPED};"
        f" one by one {cost.step:5.1f} µs"
        for cost in results
    ]
    return BenchmarkTable(lines, results)


def _cases(arm: str, task: str, count: int) -> tuple[Array, Array]:
    """Task Jacobians (N,m,n) of random postures and errors (N,m) [m]."""
    rng, loaded, rows = np.random.default_rng(0), load_arm(arm), Task(task)
    J = loaded.jacobian(rng.uniform(-np.pi, np.pi, (count, loaded.num_joints)))
    J[:, :3] *= rows.characteristic_length
    return np.ascontiguousarray(J[:, rows.rows]), 0.02 * rng.normal(size=(count, rows.size))


def _batch_time(law: Law, J: Array, dr: Array) -> float:
    """CPU time of a case [s]."""
    gc.collect()
    start = time.process_time()
    law(J, dr)
    return (time.process_time() - start) / len(J)


def _step_time(law: Law, J: Array, dr: Array) -> float:
    pairs = list(zip(J[:STEPS], dr[:STEPS]))
    start = time.process_time()
    for one, error in pairs:
        law.step(one, error)
    return (time.process_time() - start) / len(pairs)
