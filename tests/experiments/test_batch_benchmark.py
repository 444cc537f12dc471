"""The benchmark's rows."""

import pytest

from fikm_drake.experiments.benchmarks.batch_benchmark import OURS, batch_benchmark


def test_rows_of_the_benchmark():
    fractions = []
    costs = batch_benchmark(arms=["iiwa14"], targets=30, rounds=2, progress=fractions.append)
    ours = [cost for cost in costs if cost.solver == OURS]
    assert [(cost.arm, cost.limits) for cost in ours] == [("iiwa14", False), ("iiwa14", True)]
    assert all(cost.success == 100.0 and cost.cycles > 0 for cost in ours)
    assert all(cost.microseconds > 0 for cost in costs)
    assert fractions == [0.5, 1.0]


def test_bad_counts():
    with pytest.raises(ValueError, match="rounds must be positive, got 0"):
        batch_benchmark(rounds=0)
