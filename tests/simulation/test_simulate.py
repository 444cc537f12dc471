"""Runs through Drake's Simulator."""

import copy

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake import (
    ControllerStatus,
    FuzzyIkConfig,
    RunLog,
    SimulationStopped,
    TrackingScenario,
    simulate,
)


def line(**changes):
    settings = {"arm": "arm7", "waypoints": [[0.2, -0.6, 0.6], [0.3, -0.55, 0.5]], "duration": 0.5}
    return TrackingScenario(**{**settings, **changes})


@pytest.mark.parametrize("rate, hold", [(50.0, 0.4), (1000.0, 0.1), (33.3, 0.0), (7.0, 1.0)])
def test_a_row_a_cycle_and_one_for_the_end(rate, hold):
    scenario = line(control_rate=rate, hold=hold)
    log = simulate(scenario)
    N = round((0.5 + hold) * rate)
    assert scenario.num_cycles == N
    np.testing.assert_allclose(log.time, np.arange(N + 1) / rate, rtol=0, atol=1e-12)
    shapes = dict.fromkeys(("desired", "actual", "error_before", "error_after"), 3)
    shapes |= dict.fromkeys(("q", "command", "velocity", "joint_step"), 7)
    shapes |= dict.fromkeys(("gain", "oscillating", "status"), 1)
    assert {name: log[name].shape for name in log.names} == {
        name: (N + 1, size) for name, size in shapes.items()
    }
    a, b = np.array(scenario.target.positions)
    share = np.minimum(log.time / 0.5, 1.0)[:, None]
    np.testing.assert_allclose(log.desired, a + share * (b - a), rtol=0, atol=1e-9)


@pytest.mark.parametrize("fused", [False, True])
def test_errors_are_before_and_after_the_step(fused):
    scenario = line()
    scenario.controller = fd.scenario.Fuzzy(FuzzyIkConfig(fused=fused))
    log = simulate(scenario)
    np.testing.assert_array_equal(log.q[0], scenario.start())
    tool = scenario.load_arm().forward_kinematics(log.q)[:, :3, 3]
    np.testing.assert_allclose(log.actual, tool, rtol=0, atol=1e-14)
    np.testing.assert_allclose(log.error_before, log.desired - tool, rtol=0, atol=1e-14)
    after = log.desired[:-1] - tool[1:]
    np.testing.assert_allclose(log.error_after[1:], after, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(log.error_after[0], log.error_before[0])
    np.testing.assert_allclose(np.diff(log.q, axis=0), log.joint_step[:-1], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(log.command, log.q)
    np.testing.assert_allclose(np.diff(log.q, axis=0) * 50.0, log.velocity[1:], atol=1e-9)
    lengths = np.linalg.norm(after, axis=1)
    assert log.metrics().e_max == pytest.approx(lengths.max(), abs=1e-14)
    assert log.metrics().e_mean == pytest.approx(lengths.mean(), abs=1e-14)
    np.testing.assert_array_equal(log.cycles.error, log.error_after[1:])
    np.testing.assert_array_equal(log.cycles.q, log.q[1:])


def test_planar_error_has_two_rows():
    log = simulate(TrackingScenario("planar2", [[1.5, 0.0], [1.3, 0.4]], duration=0.5))
    tool = log.scenario.load_arm().forward_kinematics(log.q)[:, :2, 3]
    np.testing.assert_allclose(log.error_before, log.desired - tool, rtol=0, atol=1e-14)


def test_runs_are_repeatable():
    first, second = simulate(line()), simulate(line())
    for name in first.names:
        np.testing.assert_array_equal(first[name], second[name])


def test_a_target_that_is_reached_ends_converged():
    log = simulate(line(duration=1.0, hold=1.0))
    assert log.status[-1] == ControllerStatus.CONVERGED
    assert log.metrics().e_ss < 1e-3


def test_start_position_is_obeyed():
    start = np.linspace(-0.3, 0.3, 7)
    log = simulate(line(initial_position=start))
    np.testing.assert_array_equal(log.q[0], start)
    np.testing.assert_allclose(log.q[1], start + log.joint_step[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("hold", [0.0, 3.0])
def test_progress_rises_to_one(hold):
    seen = []
    simulate(line(duration=0.1, hold=hold), progress=seen.append)
    assert seen[-1] == 1.0
    assert 0 < seen[0] and (np.diff(seen) > 0).all()
    assert len(seen) <= 100


@pytest.mark.parametrize("reason", [KeyboardInterrupt(), RuntimeError("power cut")])
def test_interruption_leaves_the_log_of_the_cycles_done(reason, tmp_path):
    def stop(fraction):
        if fraction >= 0.5:
            raise reason

    scenario = line()
    with pytest.raises(SimulationStopped) as stopped:
        simulate(scenario, progress=stop)
    log = stopped.value.log
    assert stopped.value.__cause__ is reason
    assert f"of {scenario.num_cycles} cycles" in str(stopped.value)
    assert (str(reason) or "KeyboardInterrupt") in str(stopped.value)
    whole = simulate(scenario)
    N = len(log)
    assert 0.4 * scenario.num_cycles <= N <= 0.7 * scenario.num_cycles
    for name in log.names:
        np.testing.assert_array_equal(log[name], whole[name][:N])
    assert log.info.ended == (str(reason) or "KeyboardInterrupt")
    log.save(tmp_path / "part.npz")
    assert len(RunLog.load(tmp_path / "part.npz").time) == N
    assert log.metrics().e_max > 0


def test_a_scenario_changed_to_something_bad_is_refused():
    scenario = line()
    scenario.target.duration = -1.0
    with pytest.raises(ValueError, match="duration"):
        simulate(scenario)


def test_the_scenario_is_not_changed():
    scenario = line()
    before = copy.deepcopy(scenario)
    log = simulate(scenario)
    assert scenario == before
    assert log.scenario.whole() == before.whole()


def test_panda_stays_inside_its_limits():
    home = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
    scenario = TrackingScenario(
        "panda", [[0.3, 0.0, 0.5], [2.0, 0.0, 0.2]], 1.0, control_rate=100.0, initial_position=home
    )
    log = simulate(scenario)  # the end is out of reach
    arm = scenario.load_arm()
    assert np.isfinite(log.q).all()
    assert (log.q >= arm.lower).all() and (log.q <= arm.upper).all()
