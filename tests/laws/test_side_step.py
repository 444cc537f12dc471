"""The way out of a dead point."""

import dataclasses

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.laws.side_step import is_dead_point, leave_dead_point


def escape(arm, q, error, largest=0.1):
    arm, rows = fd.load_arm(arm), slice(3, 3 + len(error))
    q, error = np.array(q, dtype=float), np.array(error)
    return leave_dead_point(lambda q: arm.jacobian(q)[rows], q, error, largest)


def test_a_stretched_arm_bends_so_that_the_tool_stays_on_its_line():
    """To first order the bend moves only inward: joint 2 turns three times against joint 1."""
    step = escape("planar2", [0.0, 0.0], [-0.5, 0.0])
    np.testing.assert_allclose(step, [-0.1 / 3, 0.1], atol=1e-9)


@pytest.mark.parametrize("arm", ["planar2", "planar4"])
@pytest.mark.parametrize("direction", [0.0, 0.7, 2.5])
def test_the_step_brings_the_tool_nearer(arm, direction):
    n = fd.load_arm(arm).num_joints
    q = np.zeros(n)
    q[0] = direction
    inward = -0.5 * np.array([np.cos(direction), np.sin(direction)])
    tool = lambda q: fd.load_arm(arm).forward_kinematics(q)[:2, 3]  # noqa: E731
    step = escape(arm, q, inward)
    assert np.abs(step).max() == pytest.approx(0.1)
    target = tool(q) + inward
    assert np.linalg.norm(target - tool(q + step)) < np.linalg.norm(inward) - 1e-4
    np.testing.assert_array_equal(step, escape(arm, q, inward))  # the same each time


@pytest.mark.parametrize("arm", ["planar2", "planar4"])
def test_there_is_no_way_out_of_the_nearest_posture(arm):
    n = fd.load_arm(arm).num_joints
    assert not escape(arm, np.zeros(n), [0.5, 0.0]).any()


def test_an_arm_that_sees_all_directions_has_nowhere_to_go():
    assert not escape("planar2", [0.3, 1.0], [0.1, 0.2]).any()


@pytest.mark.parametrize(
    ("step", "error", "dead"),
    [
        ([0.0, 0.0], [0.5, 0.0], True),
        ([0.0, 0.0], [1e-6, 0.0], False),  # arrived
        ([0.1, 0.0], [0.5, 0.0], False),
        ([1e-5, 0.0], [0.5, 0.0], True),
    ],
)
def test_what_a_dead_point_is(step, error, dead):
    assert is_dead_point(np.dot(step, step), np.dot(error, error)) == dead


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize(
    ("arm", "target"), [("planar2", [1.0, 0.0]), ("planar4", [1.0, 0.0]), ("planar4", [0.3, 0.0])]
)
def test_the_stretched_arm_reaches_a_target_straight_inward_within_2_s(arm, target, fused):
    scenario = fd.TrackingScenario(arm=arm, waypoints=[target], hold=2.0)
    config = fd.FuzzyIkConfig(fused=fused, side_step=0.1)
    log = fd.simulate(dataclasses.replace(scenario, config=config))
    assert log.metrics().e_ss < 1e-3
    stays = dataclasses.replace(scenario, config=dataclasses.replace(config, side_step=0.0))
    assert fd.simulate(stays).metrics().e_ss == pytest.approx(1.5 - target[0])


@pytest.mark.parametrize(
    ("arm", "target", "optimum"),
    [("planar4", [0.0, 2.0], 0.5), ("planar4", [2.0, 0.0], 0.5), ("arm7", [2.0, 0.0, 0.0], 1.0)],
)
def test_out_of_reach_the_calm_controller_stops_at_the_nearest_point(arm, target, optimum):
    config = fd.FuzzyIkConfig(row_floor=0.05, error_limit=0.1, side_step=0.1)
    log = fd.simulate(fd.TrackingScenario(arm=arm, waypoints=[target], hold=8.0, config=config))
    assert log.metrics().e_ss == pytest.approx(optimum, abs=1e-3)
    assert np.abs(log.joint_step[300:]).max() <= 1e-4
    assert np.abs(log.joint_step).max() <= 0.5


def test_bad_side_step():
    for value in (-0.1, np.nan, np.inf):
        with pytest.raises(ValueError, match="side_step"):
            fd.FuzzyIkConfig(side_step=value).validate()


@pytest.mark.parametrize("fused", [False, True])
def test_no_cycle_moves_further_than_the_longest_step(fused):
    """Two iterations at a stretched arm ask for far more."""
    config = fd.FuzzyIkConfig(iterations=2, fused=fused)
    scenario = fd.TrackingScenario(arm="planar2", waypoints=[[0.0, 2.5]], hold=2.0)
    bounded = fd.simulate(dataclasses.replace(scenario, config=config))
    assert np.linalg.norm(bounded.joint_step, axis=1).max() <= 0.5 + 1e-12
    config = dataclasses.replace(config, longest_step=np.inf)
    free = fd.simulate(dataclasses.replace(scenario, config=config))
    assert np.linalg.norm(free.joint_step, axis=1).max() > 2.0


def test_the_longest_step_does_not_touch_the_papers_runs():
    for name in ("table6_2s", "large_step_2", "large_step_4"):
        scenario = fd.load_scenario(name)
        free = dataclasses.replace(scenario, config=fd.FuzzyIkConfig(longest_step=np.inf))
        np.testing.assert_array_equal(fd.simulate(scenario).q, fd.simulate(free).q)
