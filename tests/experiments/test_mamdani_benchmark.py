"""The benchmark's rows."""

from importlib.util import find_spec

import pytest

from fikm_drake.experiments.benchmarks.mamdani_benchmark import (
    CASES,
    OURS,
    PEER,
    mamdani_benchmark,
    sampling_error,
)


def test_rows_of_the_benchmark():
    fractions = []
    costs = mamdani_benchmark(rounds=2, singles=2, points=20, progress=fractions.append)
    ours = [cost for cost in costs if cost.engine == OURS]
    assert [(cost.aggregation, cost.defuzzification) for cost in ours] == list(CASES)
    assert all(cost.difference == 0.0 for cost in ours)
    assert fractions == [0.5, 1.0]


@pytest.mark.skipif(not find_spec("skfuzzy"), reason="scikit-fuzzy is not installed")
def test_scikit_fuzzy_infers_the_same():
    costs = mamdani_benchmark(rounds=1, singles=1, points=200)
    apart = {cost.defuzzification: cost.difference for cost in costs if cost.engine == PEER}
    # Its mean of maximum is a mean of samples, which are 1/200 of the range apart.
    assert apart["centroid"] < 1e-4 and apart["mean_of_maximum"] < 2.5e-3


def test_error_of_the_sampled_centroid():
    """What the README says of the default of 201 samples."""
    middle, greatest = sampling_error(points=500)
    assert middle < 3e-5 and greatest < 1e-3


def test_bad_counts():
    with pytest.raises(ValueError, match="points must be positive, got 0"):
        mamdani_benchmark(points=0)
