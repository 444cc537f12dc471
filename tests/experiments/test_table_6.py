"""Table VI and the large steps of Xu & Nechyba 1993, through the whole library."""

from dataclasses import replace

import numpy as np
import pytest

import fikm_drake as fd

TABLE_6 = {  # e_max, e_mean, e_ss [m]
    "table6_10s": (0.0110, 0.0059, 0.0009),
    "table6_5s": (0.0157, 0.0082, 0.0009),
    "table6_2s": (0.0307, 0.0105, 0.0009),
}


def simulate(name, **changes):
    scenario = fd.load_scenario(name)
    config = replace(scenario.controller_config(), **{"fused": True} | changes)
    return fd.simulate(scenario.with_config(config))


@pytest.fixture(scope="module")
def lines():
    """The three lines by both methods."""
    return {
        (name, method): simulate(name, law=fd.FuzzyMapping(method))
        for name in TABLE_6
        for method in ("indirect", "direct")
    }


@pytest.mark.parametrize("method", ["indirect", "direct"])
@pytest.mark.parametrize("name", TABLE_6)
def test_table_6_speed_versus_error(name, method, lines):
    metrics = lines[name, method].metrics()
    e_max, e_mean, e_ss = TABLE_6[name]
    assert metrics.e_max <= e_max
    assert metrics.e_mean <= e_mean
    assert metrics.e_ss <= e_ss


def test_table_6_faster_is_less_exact(lines):
    for cell in ("e_max", "e_mean"):
        errors = [getattr(lines[name, "indirect"].metrics(), cell) for name in TABLE_6]
        assert errors == sorted(errors)


@pytest.mark.parametrize("name", TABLE_6)
def test_direct_and_indirect_mapping_track_alike(name, lines):
    direct, indirect = (lines[name, method].metrics().e_mean for method in ("direct", "indirect"))
    assert direct == pytest.approx(indirect, rel=0.15)


@pytest.mark.parametrize("name", TABLE_6)
def test_the_scenario_is_that_of_the_paper(name):
    """From the tool's place at q = 0 along a straight line of 93.5 cm, at 50 Hz, then a hold."""
    scenario = fd.load_scenario(name)
    start, end = np.array(scenario.target.positions)
    tool = scenario.load_arm().forward_kinematics(np.zeros(7))[:3, 3]
    np.testing.assert_allclose(tool, start, atol=1e-12)
    assert np.linalg.norm(end - start) == pytest.approx(0.935, abs=5e-4)
    assert scenario.control_rate == 50.0
    assert f"{scenario.target.duration:g}s" in name
    assert scenario.target.hold == 0.4


@pytest.mark.parametrize("name", [*TABLE_6, "large_step_2"])
def test_metrics_are_those_of_the_joints_and_the_path(name, lines):
    """From the joint positions and the waypoints only."""
    log = lines[name, "indirect"] if name in TABLE_6 else simulate(name)
    scenario = log.scenario
    points, m = np.array(scenario.target.positions), len(scenario.target.positions[0])
    tool = scenario.load_arm().forward_kinematics(log.cycles.q)[:, :m, 3]
    k = np.arange(round((scenario.target.duration + scenario.target.hold) * scenario.control_rate))
    assert len(tool) == len(k)
    if scenario.target.duration:
        fraction = np.minimum(k / scenario.control_rate / scenario.target.duration, 1.0)[:, None]
        desired = (1 - fraction) * points[0] + fraction * points[-1]
        fine = points[0] + np.linspace(0, 1, 2001)[:, None] * (points[-1] - points[0])
        away = np.array([np.sqrt(((fine - p) ** 2).sum(-1).min()) for p in tool])
    else:
        desired = np.tile(points[-1], (len(k), 1))
        away = np.linalg.norm(tool - points[-1], axis=1)
    error = np.sqrt(((desired - tool) ** 2).sum(-1))
    metrics = log.metrics()
    assert metrics.e_max == pytest.approx(error.max(), abs=1e-12)
    assert metrics.e_mean == pytest.approx(error.mean(), abs=1e-12)
    assert metrics.e_ss == pytest.approx(error[-1], abs=1e-12)
    # A point of the path is at most 0.24 mm from the nearest of the 2001.
    assert metrics.path_max == pytest.approx(away.max(), abs=2.4e-4)
    assert metrics.path_mean == pytest.approx(away.mean(), abs=2.4e-4)


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize(("name", "bound"), [("large_step_2", 1e-3), ("large_step_4", 1e-4)])
def test_large_step_of_a_stretched_arm(name, bound, fused):
    log = simulate(name, fused=fused)
    arm = log.scenario.load_arm()
    start = arm.forward_kinematics(log.scenario.start())[:2, 3]
    np.testing.assert_allclose(start, [1.5, 0.0], atol=1e-12)
    assert log.time[-1] == 1.0
    assert np.linalg.norm(log.cycles.error[-1]) < bound
