"""Chapter 3 of the thesis: every part that `fikm-drake reproduce anfis` claims."""

import numpy as np
import pytest

from fikm_drake.experiments.benchmarks import self_motion_benchmark
from fikm_drake.experiments.reproduce.anfis import EXPERIMENTS, open_choices, three_ways
from fikm_drake.experiments.reproduce.anfis.region import A, B, C, stretches
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.simulation.scenario import load_scenario
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table


@pytest.mark.parametrize(
    "key",
    [
        "figure 3.6",
        "figure 3.7",
        "figure 3.8",
        "figure 3.12",
        "figure 3.13",
        "figure 3.16",
        "minimum norm",
        "algorithm 1",
    ],
)
def test_reproduces(key):
    section = EXPERIMENTS[key]()
    assert section.key == key
    assert section.reached, str(section)
    assert any(cell.reached for cell in section.cells)
    for cell in section.cells:
        assert type(cell.reached) in (bool, type(None)), cell
        assert not (isinstance(cell.ours, float) and np.isnan(cell.ours)), cell


def test_exactness_on_a_few_targets(monkeypatch):
    for name, count in (("EXACT_POINTS", 1000), ("TRACED", 20), ("POSES", 1)):
        monkeypatch.setattr(three_ways, name, count)
    section = EXPERIMENTS["exactness"]()
    assert section.reached, str(section)
    assert all(type(cell.reached) in (bool, type(None)) for cell in section.cells)


def test_benchmark_prints_every_method():
    text = self_motion_benchmark.table(20, lambda share: None)
    assert text.count("yes") == 4 and "NO" not in text
    for word in ("scan", "planar 3R", "iiwa14", "panda"):
        assert word in text


@pytest.mark.parametrize("trajectory", [A, B, C], ids=lambda t: t.name)
def test_trajectories_pass_their_corners(trajectory):
    shares = np.linspace(0.0, 100.0, len(trajectory.corners))
    np.testing.assert_allclose(trajectory.at(shares), trajectory.corners)
    np.testing.assert_array_equal(trajectory.at(0.0), trajectory.at(100.0))
    middle = np.mean(trajectory.corners[:2], axis=0)
    np.testing.assert_allclose(trajectory.at(0.5 * shares[1]), middle)


def test_a_and_c_are_feasible_and_b_is_where_table_3_3_leaves_the_workspace():
    percent = np.linspace(0.0, 100.0, 4001)
    arm = load_arm("hassantabar3r")
    for trajectory in (A, C):
        assert feasible_interval_table(arm, trajectory.at(percent)).feasible.all()
    feasible = feasible_interval_table(arm, B.at(percent)).feasible
    assert feasible[(percent > 17.35) & (percent < 96.6)].all()
    assert not feasible[(percent < 2.7) | ((percent > 2.85) & (percent < 17.3))].any()
    assert not feasible[percent > 96.7].any()
    (alone,) = feasible_interval_table(arm, np.array([[-1.5, 1.0]]))[0]
    assert alone.lower == alone.upper == pytest.approx(np.pi / 2)


def test_stretches():
    mask = np.array([True, True, False, True, False, True])
    assert stretches(np.arange(6.0), mask) == "0.00-1.00, 3.00-3.00, 5.00-5.00"


@pytest.mark.parametrize("trajectory", [A, B, C], ids=lambda trajectory: trajectory.name)
def test_the_scenarios_are_the_thesis_s_trajectories(trajectory):
    scenario = load_scenario(f"anfis_{trajectory.name.lower()}")
    percent = np.minimum(10.0 * np.arange(scenario.num_cycles) / scenario.control_rate, 100.0)
    np.testing.assert_allclose(scenario.targets(), trajectory.at(percent), atol=1e-9)


def test_readings_of_what_the_thesis_lost(monkeypatch):
    monkeypatch.setattr(open_choices, "EPOCHS", 2)
    monkeypatch.setattr(open_choices, "WALK_POINTS", 3)
    section = EXPERIMENTS["readings"]()
    assert section.key == "readings" and list(section.pictures) == ["anfis_readings"]
    found = {cell.label: cell.ours for cell in section.cells}
    walks = [found[label] for label in found if label.startswith("algorithm 1")]
    assert len(walks) == len(open_choices.WALKS) and min(walks) > 1e-3  # none finds the bounds
    (mid,) = (found[label] for label in found if "sides" in label and "mid-range" in label)
    assert mid.endswith("75.00-100.00")  # as the thesis's figure has it


def test_per_cents_of_a_length_reach_corners_later_on_longer_sides():
    corners = np.array(open_choices.B.corners)
    assert open_choices.by_length(open_choices.B, np.zeros(1))[0] == pytest.approx(corners[0])
    assert open_choices.by_length(open_choices.B, np.array([100 * 4.5 / 11]))[0] == pytest.approx(
        corners[1]
    )
    assert open_choices.by_length(open_choices.B, np.array([50.0]))[0] == pytest.approx(corners[2])
