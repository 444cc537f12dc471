"""Costs of training and of bounds (`fikm-drake benchmark anfis`)."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from statistics import median

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.reproduce.anfis.region import ARM
from fikm_drake.experiments.reproduce.anfis.samples import (
    exact,
    fresh_points,
    fresh_values,
    rms_and_max,
    training_points,
)
from fikm_drake.fuzzy.anfis.anfis import RIDGE, Anfis
from fikm_drake.fuzzy.anfis.inputs import InputScale
from fikm_drake.fuzzy.anfis.membership_kinds import KINDS
from fikm_drake.fuzzy.anfis.network import even_network
from fikm_drake.fuzzy.anfis.one_blas_thread import one_blas_thread
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table

OURS, PEER = "fd.Anfis", "anfis-toolbox"
EPOCHS = 3
"""Epochs of a round: training costs the same in each."""
REPEATS = 5
"""Repeats of a batch of bounds in a round."""


@dataclass(frozen=True)
class TrainingCost:
    """One learner on the upper bound, 8 x 8 Gaussian memberships of x and y, hybrid rule."""

    learner: str
    """`OURS` or `PEER`."""
    milliseconds: float
    """CPU time of an epoch, median over the rounds [ms]."""
    rms: float
    """Root mean square error over fresh points after `EPOCHS` epochs [rad]."""


def training_costs(
    rounds: int, progress: Callable[[float], None] | None = None
) -> list[TrainingCost]:
    """Train the learners in turns; anfis-toolbox takes part where it can be imported."""
    X, Y = training_points(), exact(training_points())["upper"]
    learners: dict[str, Callable[[], Callable[[Array], Array]]] = {
        OURS: lambda: Anfis((8, 8)).fit(X, Y, epochs=EPOCHS).predict
    }
    if find_spec("anfis_toolbox"):
        regressor = import_module("anfis_toolbox").ANFISRegressor
        options = {"n_mfs": 8, "mf_type": "gaussian", "optimizer": "hybrid", "epochs": EPOCHS}
        learners[PEER] = lambda: regressor(**options, random_state=0).fit(X, Y).predict
    seconds: dict[str, list[float]] = {name: [] for name in learners}
    rms = {}
    for k in range(rounds):
        for name, learn in learners.items():
            start = time.process_time()
            predict = learn()
            seconds[name].append(time.process_time() - start)
            error = np.ravel(predict(fresh_points())) - fresh_values()["upper"]
            rms[name] = rms_and_max(error)[0]
        if progress:
            progress((k + 1) / rounds)
    return [
        TrainingCost(name, 1e3 * median(times) / EPOCHS, rms[name])
        for name, times in seconds.items()
    ]


def normal_equations_cost(rounds: int) -> float:
    """CPU time of the normal equations by the book, median [ms].

    The regressors of the even partition, one product of matrices, the solution; one thread of the BLAS.
    """
    X, Y = training_points(), exact(training_points())["upper"]
    x = InputScale(X.min(axis=0), X.max(axis=0)).scaled(X)
    network, seconds = even_network(KINDS["gaussian"], (8, 8), 1), []
    with one_blas_thread():
        for _ in range(REPEATS * rounds):
            start = time.process_time()
            A = network.regressors(x)
            np.linalg.solve(A @ A.T + RIDGE * len(Y) * np.eye(len(A)), A @ Y)
            seconds.append(time.process_time() - start)
    return 1e3 * median(seconds)


def bounds_costs(rounds: int) -> dict[str, float]:
    """CPU time a point [µs] of a batch of fresh points, medians, in turns."""
    arm, points = load_arm(ARM), fresh_points()
    bounds, resolver = LearnedBounds.load(ARM), RedundancyResolver(arm)
    ways: dict[str, Callable[[], object]] = {
        "learned bounds": lambda: bounds.predict(points),
        "exact bounds": lambda: feasible_interval_table(arm, points),
        "resolved postures": lambda: resolver.resolve(points),
    }
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(REPEATS * rounds):
        for name, way in ways.items():
            start = time.process_time()
            way()
            seconds[name].append(time.process_time() - start)
    return {name: 1e6 * median(times) / len(points) for name, times in seconds.items()}


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = training_costs(rounds, progress)
    lines = [
        f"training of 64 rules from {len(training_points())} points, CPU time an epoch, error over "
        f"{len(fresh_points())} fresh points after {EPOCHS} epochs"
    ]
    lines += [f"  {c.learner:14s} {c.milliseconds:8.1f} ms  {1e3 * c.rms:6.2f} mrad" for c in costs]
    if len(costs) > 1:
        lines.append(f"  {costs[1].milliseconds / costs[0].milliseconds:.1f} times faster")
    else:
        lines.append(f"  ({PEER} is not installed)")
    limit = normal_equations_cost(rounds)
    lines.append(
        f"  normal equations, made and solved once: {limit:.1f} ms; an epoch takes "
        f"{costs[0].milliseconds / limit:.2f} of that"
    )
    bounds = bounds_costs(rounds)
    lines.append(f"batch of {len(fresh_points())} points, CPU time a point")
    lines += [f"  {name:18s} {cost:6.2f} µs" for name, cost in bounds.items()]
    ratio = bounds["exact bounds"] / bounds["learned bounds"]
    lines.append(f"  learned bounds {ratio:.1f} times faster than exact ones")
    return BenchmarkTable(lines, [*costs, {"normal equations [ms]": limit}, bounds])
