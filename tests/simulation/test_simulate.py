"""Runs through Drake's Simulator."""

import dataclasses

import numpy as np
import pytest

from fikm_drake import ControllerStatus, SimulationStopped, TrackingLog, TrackingScenario, simulate
from fikm_drake.simulation.tracking_log import series_names


def line(**changes):
    settings = {"arm": "arm7", "waypoints": [[0.2, -0.6, 0.6], [0.3, -0.55, 0.5]], "duration": 0.5}
    return TrackingScenario(**{**settings, **changes})


@pytest.mark.parametrize("rate, hold", [(50.0, 0.4), (1000.0, 0.1), (33.3, 0.0), (7.0, 1.0)])
def test_a_row_a_cycle(rate, hold):
    scenario = line(control_rate=rate, hold=hold)
    log = simulate(scenario)
    N = round((0.5 + hold) * rate)
    assert scenario.num_cycles == N
    np.testing.assert_allclose(log.time, np.arange(N) / rate, rtol=0, atol=1e-12)
    shapes = {"desired": 3, "actual": 3, "error": 3, "q": 7, "joint_step": 7}
    for name in series_names():
        expected = (N, shapes[name]) if name in shapes else (N,)
        assert getattr(log, name).shape == expected
    desired = [scenario.trajectory().value(t)[:, 0] for t in log.time]
    np.testing.assert_allclose(log.desired, desired, rtol=0, atol=1e-9)


@pytest.mark.parametrize("fused", [False, True])
def test_error_is_desired_minus_forward_kinematics_after_the_update(fused):
    scenario = line()
    scenario.config.fused = fused
    log = simulate(scenario)
    tool = scenario.load_arm().forward_kinematics(log.q)[:, :3, 3]
    np.testing.assert_array_equal(log.actual, tool)
    np.testing.assert_array_equal(log.error, log.desired - tool)
    before = np.vstack([scenario.start(), log.q[:-1]])
    np.testing.assert_allclose(log.q, before + log.joint_step, rtol=0, atol=1e-12)


def test_planar_error_has_two_rows():
    log = simulate(TrackingScenario("planar2", [[1.5, 0.0], [1.3, 0.4]], duration=0.5))
    tool = log.scenario.load_arm().forward_kinematics(log.q)[:, :2, 3]
    np.testing.assert_array_equal(log.error, log.desired - tool)


def test_runs_are_repeatable():
    first, second = simulate(line()), simulate(line())
    for name in series_names():
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_a_target_that_is_reached_ends_converged():
    log = simulate(line(duration=1.0, hold=1.0))
    assert log.status[-1] == ControllerStatus.CONVERGED
    assert log.metrics().e_ss < 1e-3


def test_start_position_is_obeyed():
    start = np.linspace(-0.3, 0.3, 7)
    log = simulate(line(initial_position=start))
    np.testing.assert_allclose(log.q[0], start + log.joint_step[0], rtol=0, atol=1e-12)


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
    N = len(log.time)
    assert 0.4 * scenario.num_cycles <= N <= 0.6 * scenario.num_cycles
    for name in series_names():
        np.testing.assert_array_equal(getattr(log, name), getattr(whole, name)[:N])
    log.save(tmp_path / "part.npz")
    assert len(TrackingLog.load(tmp_path / "part.npz").time) == N
    assert log.metrics().e_max > 0


def test_a_scenario_changed_to_something_bad_is_refused():
    scenario = line()
    scenario.duration = -1.0
    with pytest.raises(ValueError, match="duration"):
        simulate(scenario)


def test_the_scenario_is_not_changed():
    scenario = line()
    before = dataclasses.replace(scenario)
    assert simulate(scenario).scenario == before


def test_panda_stays_inside_its_limits():
    home = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
    scenario = TrackingScenario(
        "panda", [[0.3, 0.0, 0.5], [2.0, 0.0, 0.2]], 1.0, control_rate=100.0, initial_position=home
    )
    log = simulate(scenario)  # the end is out of reach
    arm = scenario.load_arm()
    assert np.isfinite(log.q).all()
    assert (log.q >= arm.lower).all() and (log.q <= arm.upper).all()
