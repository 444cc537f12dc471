"""Paper 4: what `fikm-drake reproduce labvolt` and `fikm-drake benchmark labvolt` claim, on fewer targets."""

import numpy as np
import pytest

from fikm_drake.experiments.benchmarks import labvolt_benchmark as benchmark
from fikm_drake.experiments.reproduce.labvolt import (
    EXPERIMENTS,
    figures,
    findings,
    open_choices,
    runs,
    tables,
)
from fikm_drake.experiments.reproduce.labvolt.runs import PAPER


@pytest.fixture(scope="module", autouse=True)
def fewer_targets():
    """In every module that counts them."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (runs, tables, figures, findings, open_choices):
            patch.setattr(module, "FEW", 40, raising=False)
            patch.setattr(module, "MANY", 400, raising=False)
        for name, count in (("REACHABLE", 500), ("ANYWHERE", 600), ("CHECKED", 30)):
            patch.setattr(findings, name, count)
        for cached in (runs.targets, runs.many, runs.few, runs.bare):
            cached.cache_clear()
        yield
    for cached in (runs.targets, runs.many, runs.few, runs.bare):
        cached.cache_clear()


@pytest.mark.parametrize("key", EXPERIMENTS)
def test_reproduces(key):
    section = EXPERIMENTS[key]()
    assert section.key == key
    assert section.reached, str(section)
    for cell in section.cells:
        assert not (isinstance(cell.ours, float) and np.isnan(cell.ours)), cell


def test_every_method_of_tables_3_and_4_has_a_row():
    for section in (tables.table_3(), tables.table_4()):
        labels = " ".join(cell.label for cell in section.cells)
        assert all(f"{name}:" in labels for name in PAPER)


def test_only_the_sqp_from_a_random_start_has_spikes():
    """Figures 7 and 8: local minima, which a good start avoids."""
    spikes = {name: int((run.error > 1e-3).sum()) for name, run in runs.many().items()}
    assert spikes.pop(runs.RANDOM_START) > 10
    assert max(spikes.values()) <= 1


def test_benchmark_finds_ours_at_least_as_often_as_the_others(monkeypatch):
    monkeypatch.setattr(benchmark, "SINGLE", 40)
    monkeypatch.setattr(benchmark, "BATCH", 200)
    costs = {(cost.name, cost.start): cost for cost in benchmark.solver_costs(rounds=1)}
    assert costs[benchmark.BATCHED, "-"].success == 100.0
    for start in ("zero", "middle", "fuzzy"):
        ours = costs[benchmark.OURS, start]
        assert ours.success > 95.0 and ours.ratio == 1.0
        for peer in (benchmark.CALLBACK, benchmark.DRAKE):
            assert costs[peer, start].success <= ours.success
            assert costs[peer, start].microseconds > 0.0


def test_benchmark_path_has_no_jumps_from_the_last_solution(monkeypatch):
    monkeypatch.setattr(benchmark, "STEPS", 600)
    warm, fuzzy = benchmark.path_costs(rounds=1)
    assert (warm.start, fuzzy.start) == ("last solution", "fuzzy")
    assert warm.jumps == 0 and warm.largest < 5.0 < fuzzy.largest


@pytest.mark.parametrize("measure", [benchmark.solver_costs, benchmark.path_costs])
def test_bad_number_of_rounds(measure):
    with pytest.raises(ValueError, match="rounds must be positive, got 0"):
        measure(rounds=0)


def test_table_names_every_solver(monkeypatch):
    monkeypatch.setattr(benchmark, "SINGLE", 5)
    monkeypatch.setattr(benchmark, "BATCH", 20)
    monkeypatch.setattr(benchmark, "STEPS", 20)
    text = benchmark.table(1, lambda fraction: None)
    for name in (benchmark.OURS, benchmark.CALLBACK, benchmark.DRAKE, benchmark.BATCHED):
        assert name in text
    assert "jumps above 5°" in text
