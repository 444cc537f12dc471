"""The benchmark's rows."""

import pytest

from fikm_drake.experiments.benchmarks.batch_benchmark import NEAREST, NUMPY, batch_benchmark


def test_rows_of_the_benchmark():
    fractions = []
    costs = batch_benchmark(arms=["iiwa14"], poses=10, rounds=2, progress=fractions.append)
    ours = [cost for cost in costs if cost.solver in (NUMPY, NUMPY + NEAREST)]
    assert [(cost.limits, cost.solver, cost.poses) for cost in ours] == [
        (limits, solver, poses)
        for limits in (True, False)
        for solver in (NUMPY, NUMPY + NEAREST)
        for poses in (10, 1)
    ]
    assert all(cost.success == 100.0 for cost in ours)
    assert all(0.0 < cost.microseconds <= cost.slowest for cost in costs)
    assert fractions == [0.5, 1.0]


def test_bad_counts():
    with pytest.raises(ValueError, match="rounds must be positive, got 0"):
        batch_benchmark(rounds=0)
