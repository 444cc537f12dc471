"""Paper 3: what `fikm-drake reproduce frmrc` claims, and the paths it is claimed on."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.experiments.benchmarks.rate_benchmark import rate_benchmark
from fikm_drake.experiments.reproduce.conventions import errors_before
from fikm_drake.experiments.reproduce.frmrc import EXPERIMENTS, past, random_lines, tracking


@pytest.fixture
def small(monkeypatch):
    """The same claims at two of the three rates, on fewer lines and cases."""
    monkeypatch.setattr(tracking, "RATES", (50.0, 100.0))
    monkeypatch.setattr(random_lines, "LINES", 200)
    monkeypatch.setattr(past, "CASES", 4000)


@pytest.mark.parametrize("key", EXPERIMENTS)
def test_reproduces(key, small):
    section = EXPERIMENTS[key]()
    assert section.key == key
    assert section.reached, str(section)
    for cell in section.cells:
        assert not (isinstance(cell.ours, float) and np.isnan(cell.ours)), cell


@pytest.mark.parametrize("name", ["frmrc_line", "frmrc_circle"])
def test_scenarios_start_at_the_tool_as_a_plain_rate_loop(name):
    scenario = fd.load_scenario(name)
    tool = scenario.load_arm().forward_kinematics(scenario.start())[:2, 3]
    assert scenario.target.positions[0] == pytest.approx(tool, abs=1e-12)
    plain = fd.FuzzyIkConfig(task="xy").resolved_rate()
    assert scenario.controller_config() == plain and isinstance(
        scenario.controller, fd.scenario.Frmrc
    )


def test_line_has_the_cubic_profile_of_equation_16():
    scenario = fd.load_scenario("frmrc_line")
    a, b = np.array(scenario.target.positions)
    t = np.linspace(0.0, 1.0, 9)
    expected = a + (b - a) * (3 * t**2 - 2 * t**3)[:, None]
    values = np.array([scenario.target_motion().position(scenario.target.duration * s) for s in t])
    np.testing.assert_allclose(values, expected, atol=1e-12)
    lines = random_lines.cubic_lines(a[None], b[None], 8)
    np.testing.assert_allclose(lines[:, 0], expected, atol=1e-12)


def test_circle_is_three_cycles_of_one_radius():
    points = np.array(fd.load_scenario("frmrc_circle").target.positions)
    radius = np.linalg.norm(points - points[:120].mean(axis=0), axis=1)
    np.testing.assert_allclose(radius, 0.25, atol=1e-6)
    np.testing.assert_allclose(points[::120], np.tile(points[0], (4, 1)), atol=1e-9)


def test_batch_loop_is_the_simulators():
    """The loop of the random lines against the Diagram, cycle by cycle."""
    scenario = fd.load_scenario("frmrc_line")
    law = fd.FuzzyRateControl(sweeps=2)
    log = fd.simulate(scenario, law=law)
    run = random_lines.track(
        law, scenario.load_arm(), [scenario.start()], log.cycles.desired[:, None, :], hold=0
    )
    expected = np.linalg.norm(errors_before(log), axis=1)
    np.testing.assert_allclose(run.error[:, 0], expected, atol=1e-9)
    travel = np.linalg.norm(log.cycles.joint_step, axis=1).sum()
    assert run.travel[0] == pytest.approx(travel, rel=1e-9)


def test_paper_variant_does_step_the_wrong_way():
    """So that the count of zero for `smooth` means something."""
    assert 0 < past.longer("paper", 1.4, None) < 0.2 * past.CASES


def test_benchmark_measures_every_law():
    costs = rate_benchmark(rounds=1, cases=20)
    assert {(cost.arm, cost.task) for cost in costs} >= {("kim_lee3r", "xy"), ("iiwa14", "pose")}
    assert all(cost.batch > 0 and cost.step > 0 for cost in costs)
    with pytest.raises(ValueError, match="rounds"):
        rate_benchmark(rounds=0)
