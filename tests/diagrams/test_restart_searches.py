"""Dead points and local minima in the loop: without a restart search the arm rests there."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

READY = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
WANTED = ("commanded_position", "joint_step", "task_error", "status")


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def to(run, plant, config, start, target, seconds):
    desired = [target] * round(seconds * config.control_rate)
    return run(plant, config, start, desired, only=WANTED)


@pytest.mark.parametrize(
    ("arm", "target", "seconds"),
    [("planar2", (1.0, 0.0), 2.0), ("planar4", (1.0, 0.0), 3.0), ("planar4", (0.3, 0.0), 3.0)],
)
def test_the_stretched_arm_reaches_a_target_straight_inward(
    arm, target, seconds, plant_with, run, fused
):
    """By a step aside, which is the default; by a restart search; and as in the paper it stays."""
    start, plant = np.zeros(fd.load_arm(arm).num_joints), plant_with(arm)
    config = fd.FuzzyIkConfig(fused=fused, task="xy", singularity_nudge=0.0)
    for way_out in (
        {"singularity_nudge": 0.01},
        {"restart_search": True},
        {"singularity_nudge": 0.01, "restart_search": True},
    ):
        series = to(run, plant, replace(config, **way_out), start, target, seconds)
        assert lengths(series["task_error"])[-1] < 1e-3
        assert series["status"][-1] == Status.CONVERGED
        assert (Status.RESTART_SEARCH in series["status"]) == (way_out == {"restart_search": True})
        if way_out == {"restart_search": True}:
            led = series["status"][:-1, 0] == Status.RESTART_SEARCH
            speed = 50.0 * np.abs(np.diff(series["commanded_position"], axis=0))[led]
            assert speed.max() == pytest.approx(config.restart_speed)
    stays = to(run, plant, config, start, target, 1.0)
    assert lengths(stays["task_error"])[-1] == pytest.approx(1.5 - target[0])
    assert not stays["joint_step"].any()


NEAR_LIMITS = [
    (0.3317, 0.1104, 0.4463),
    (-0.1867, 0.041, 0.3267),
    (-0.405, 0.3175, 0.4091),
    (-0.651, 0.0664, 0.0883),
]
"""Points that a Puma reaches with several joints 0.02 rad from their limits only, or nearly."""


@pytest.mark.parametrize("target", NEAR_LIMITS)
def test_a_target_near_joint_limits_ends_calm_and_is_reached_with_a_restart(
    target, plant_with, run
):
    arm, plant = fd.load_arm("puma560"), plant_with("puma560")
    start = arm.default_position
    # They swing from 0.9 to 1.6 s on; the last rests after 4.2 s, the first did after 7.2 s once.
    calm = to(run, plant, fd.FuzzyIkConfig(fused=True), start, target, 5.5)
    assert lengths(calm["task_error"])[-1] > 0.1
    assert np.abs(calm["joint_step"][-50:]).max() < 1e-4
    reached = to(run, plant, fd.FuzzyIkConfig(fused=True, restart_search=True), start, target, 6.0)
    assert lengths(reached["task_error"])[-1] < 1e-3
    assert reached["status"][-1] == Status.CONVERGED
    for series in (calm, reached):
        q = series["commanded_position"]
        assert (q >= arm.lower).all() and (q <= arm.upper).all()
    tool = arm.forward_kinematics(reached["after"])[:3, 3]
    np.testing.assert_allclose(tool, target, atol=1e-3)


# Of the 60 of `fikm-drake benchmark poses`: three that need no restart search, one that does.
@pytest.mark.parametrize(("index", "local"), [(2, True), (5, True), (28, True), (36, False)])
def test_random_poses_of_an_iiwa_are_reached(index, local, plant_with, run):
    arm = fd.load_arm("iiwa14")
    postures = np.random.default_rng(0).uniform(arm.lower, arm.upper, (60, 7))
    T = arm.forward_kinematics(postures[index])
    pose = RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])
    config = fd.FuzzyIkConfig(
        task="pose",
        law=fd.FuzzyMapping.iterated(),
        control_rate=100.0,
        fused=True,
        restart_search=True,
        restart_speed=3.0,
    )
    series = to(run, plant_with("iiwa14"), config, READY, pose, 6.0)
    reached = arm.forward_kinematics(series["after"])
    assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-3
    assert np.arccos(np.clip((np.trace(reached[:3, :3].T @ T[:3, :3]) - 1) / 2, -1, 1)) < 0.01
    assert (Status.RESTART_SEARCH not in series["status"]) is local
    q = series["commanded_position"]
    assert (q >= arm.lower).all() and (q <= arm.upper).all()
    assert (np.abs(np.diff(q, axis=0)) * 100.0 <= arm.velocity_limits * (1 + 1e-9)).all()


def test_out_of_reach_it_ends_stuck_at_rest_and_wakes_up(plant_with, run, fused):
    config = fd.FuzzyIkConfig(fused=fused, task="xy", restart_search=True)
    desired = np.concatenate([np.tile((0.0, 2.0), (300, 1)), np.tile((0.5, 0.8), (150, 1))])
    series = run(plant_with("planar4"), config, np.full(4, 0.1), desired, only=WANTED)
    assert series["status"][299] == Status.STUCK
    assert lengths(series["task_error"])[299] == pytest.approx(0.5, abs=1e-3)
    assert np.abs(series["joint_step"][250:300]).max() <= 1e-4
    assert series["status"][-1] == Status.CONVERGED


def test_a_run_that_needs_no_restart_search_is_the_same_with_one(
    scenario_inputs, plant_with, run, fused
):
    results = []
    for restart_search in (False, True):
        arm, config, start, desired = scenario_inputs(
            "table6_2s", fused=fused, restart_search=restart_search
        )
        results.append(run(plant_with(arm), config, start, desired))
    for name in results[0]:
        np.testing.assert_array_equal(results[0][name], results[1][name], err_msg=name)


def test_a_robot_that_follows_its_command_is_led_out(plant_with, run, fused):
    """The restart search is of the measured joints: here the command of the cycle before, filtered."""
    measured = [np.zeros(2)]

    def lag(k, commanded):
        measured[0] = measured[0] + 0.6 * (commanded - measured[0])
        return measured[0]

    config = fd.FuzzyIkConfig(
        fused=fused, task="xy", singularity_nudge=0.0, restart_search=True, measured_position=True
    )
    desired = np.tile((1.0, 0.0), (250, 1))
    plant = plant_with("planar2")
    series = run(plant, config, np.zeros(2), desired, lag, only=WANTED)
    assert lengths(series["task_error"])[-1] < 1e-3


@pytest.mark.parametrize("lost", [20, 60])
def test_a_target_lost_on_the_way_holds_the_command(lost, plant_with, run, fused):
    """While the arm searches and while it is under way; then it begins anew."""
    desired = np.tile((1.0, 0.0), (250, 1))
    desired[lost : lost + 10] = np.nan
    config = fd.FuzzyIkConfig(fused=fused, task="xy", singularity_nudge=0.0, restart_search=True)
    series = run(plant_with("planar2"), config, np.zeros(2), desired)
    assert series["status"][lost - 1] == Status.RESTART_SEARCH
    assert (series["status"][lost : lost + 10] == Status.INVALID_INPUT).all()
    held = series["commanded_position"][lost : lost + 11]
    np.testing.assert_array_equal(held, np.tile(held[0], (11, 1)))
    assert all(np.isfinite(values).all() for values in series.values())
    assert lengths(series["task_error"])[-1] < 1e-3


def test_a_target_near_joint_limits_that_saturated_joints_leave_to_the_others(plant_with, run):
    arm, plant = fd.load_arm("puma560"), plant_with("puma560")
    target = (-0.1596, 0.2226, 1.2693)
    series = to(run, plant, fd.FuzzyIkConfig(fused=True), arm.default_position, target, 4.0)
    assert lengths(series["task_error"])[-1] < 1e-3
