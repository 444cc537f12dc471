"""What `fikm-drake benchmark cycle` and `hard` measure."""

import pytest

from fikm_drake.experiments.benchmarks.cycle_benchmark import DRAKE, FUZZY, cycle_benchmark, laws
from fikm_drake.experiments.benchmarks.hard_benchmark import hard_benchmark


def test_cycle_compares_each_law_alone_and_with_its_jacobian():
    costs = {(cost.rows, cost.whole, cost.name): cost for cost in cycle_benchmark(rounds=2)}
    names = {(rows, whole, name) for rows in (3, 6) for whole in (False, True) for name in laws()}
    assert set(costs) == names | {(3, True, DRAKE), (6, True, DRAKE)}
    assert all(cost.microseconds > 0 and cost.ratio > 0 for cost in costs.values())
    assert costs[3, False, FUZZY].ratio == 1.0


def test_out_of_reach_the_default_rests_and_the_others_do_not():
    results = {result.name: result for result in hard_benchmark(seconds=8)}
    ours = results["fuzzy, calm (default)"]
    for error, speed in ours.beyond.values():
        assert error < 1e-3 and speed < 5e-3
    assert ours.step[0] < 1.0 and ours.step[1] < 0.5
    assert ours.line == pytest.approx(results["fuzzy, as in the paper"].line, rel=1e-3)
    for name in ("pseudo-inverse", "damped least squares 0.05", DRAKE):
        assert all(speed > 1.0 for _, speed in results[name].beyond.values())
    sharp = results["fuzzy, 3 iterations, unfiltered"]
    assert sharp.line[0] < 1e-4 and all(speed < 1e-3 for _, speed in sharp.beyond.values())


@pytest.mark.parametrize(
    ("benchmark", "name"), [(cycle_benchmark, "rounds"), (hard_benchmark, "seconds")]
)
def test_bad_counts(benchmark, name):
    with pytest.raises(ValueError, match=name):
        benchmark(**{name: 0})
