"""Targets out of reach: the arm comes to rest there, and wakes up when it can go on."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

READY = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
SHARP = {
    "task": "pose",
    "law": fd.FuzzyMapping.iterated(),
    "control_rate": 100.0,
}
WANTED = ("commanded_position", "joint_step", "task_error", "status")


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def reversals(steps):
    """How often a joint that moves at all changes its direction."""
    moving = np.where(np.abs(steps) > 1e-8, steps, 0.0)
    return int((moving[1:] * moving[:-1] < 0).sum())


def pose_of(arm, q):
    T = arm.forward_kinematics(q)
    return RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])


@pytest.mark.parametrize(
    ("arm", "target", "nearest"),
    [
        ("planar4", (0.0, 2.0), 0.5),
        ("planar4", (2.0, 0.0), 0.5),
        ("planar2", (0.0, 2.0), 0.5),
        ("arm7", (2.0, 0.0, 0.0), 1.0),
    ],
)
def test_out_of_reach_the_default_controller_rests_at_the_nearest_point(
    arm, target, nearest, plant_with, run, fused
):
    """Within 1 mm for the planar arms; arm7 has 3 mm of its 3 m left where it rests."""
    config = fd.FuzzyIkConfig(fused=fused, task="xy" if len(target) == 2 else "position")
    start = np.zeros(fd.load_arm(arm).num_joints)
    series = run(plant_with(arm), config, start, np.tile(target, (400, 1)), only=WANTED)
    error = lengths(series["task_error"])[-1]
    assert nearest - 1e-9 <= error <= nearest + (1e-3 if len(target) == 2 else 3e-3)
    assert np.abs(series["joint_step"][300:]).max() <= 1e-4
    assert lengths(series["joint_step"]).max() <= config.max_joint_step


def test_without_the_calm_it_goes_on_moving(plant_with, run, fused):
    """As in the paper, section 2.7; so the figures above are the calm's."""
    config = fd.FuzzyIkConfig(
        fused=fused, task="xy", supervisor=fd.GainSupervisorConfig(calming=1.0)
    )
    desired = np.tile((0.0, 2.0), (400, 1))
    series = run(plant_with("planar4"), config, np.zeros(4), desired, only=WANTED)
    assert np.abs(series["joint_step"][300:]).max() > 1e-2
    assert set(series["status"][300:].ravel()) == {Status.OSCILLATING}


@pytest.mark.parametrize("ray", [(0.5, 0.0, 0.4), (0.0, 1.0, 0.3), (0.0, 0.0, 1.0)])
def test_a_pose_out_of_reach(ray, plant_with, run):
    """0.4 m beyond the reach of an iiwa14: after 10 s at most 1 mrad/s, and no joint to and fro."""
    shoulder, reach = np.array([0.0, 0.0, 0.36]), 0.42 + 0.40 + 0.126
    far = shoulder + (reach + 0.4) * np.array(ray) / np.linalg.norm(ray)
    pose = RigidTransform(pose_of(fd.load_arm("iiwa14"), READY).rotation(), far)
    config = fd.FuzzyIkConfig(fused=True, **SHARP)
    series = run(plant_with("iiwa14"), config, READY, [pose] * 1100, only=WANTED)
    motion = np.diff(series["commanded_position"], axis=0)
    speed = 100.0 * motion[-100:]
    assert np.sqrt((speed**2).mean()) <= 1e-3
    assert reversals(motion[-100:]) == 0
    assert lengths(motion).max() <= 0.5
    assert series["status"][-1] == Status.CALMED


@pytest.mark.parametrize(
    ("name", "far", "near"),
    [
        ("planar4", (0.0, 2.0), (0.6, 0.7)),
        ("planar2", (0.0, 2.0), (0.8, -0.6)),
        ("arm7", (2.0, 0.0, 0.0), (0.5, -0.45, 0.3)),
    ],
)
def test_a_calmed_arm_wakes_up(name, far, near, plant_with, run, fused):
    """After 8 s at a target out of reach a new one is reached within 3 s."""
    config = fd.FuzzyIkConfig(fused=fused, task="xy" if len(far) == 2 else "position")
    start = np.full(fd.load_arm(name).num_joints, 0.1)
    desired = np.concatenate([np.tile(far, (400, 1)), np.tile(near, (151, 1))])
    series = run(plant_with(name), config, start, desired, only=WANTED)
    assert series["status"][399] in (Status.CALMED, Status.OSCILLATING)
    assert lengths(series["task_error"])[-1] < config.tolerance
    assert series["status"][-1] == Status.CONVERGED


def test_a_calmed_arm_wakes_up_for_a_pose(plant_with, run):
    arm = fd.load_arm("iiwa14")
    near = pose_of(arm, READY + np.array([0.4, -0.2, 0.3, 0.2, -0.3, 0.2, 0.5]))
    far = RigidTransform(pose_of(arm, READY).rotation(), [0.8, 0.6, 1.2])
    config = fd.FuzzyIkConfig(fused=True, **SHARP)
    series = run(plant_with("iiwa14"), config, READY, [far] * 800 + [near] * 301, only=WANTED)
    assert series["status"][799] == Status.CALMED
    assert series["status"][-1] == Status.CONVERGED


def come_back(run, plant, config, far, near, speed):
    """8 s at `far`, on a straight line to `near` at `speed` [m/s], and 3 s there."""
    far, near = np.array(far), np.array(near)
    cycles = max(1, round(np.linalg.norm(far - near) / speed * config.control_rate))
    way = far + np.linspace(0, 1, cycles + 1)[1:, None] * (near - far)
    desired = np.concatenate([np.tile(far, (400, 1)), way, np.tile(near, (150, 1))])
    n = plant.num_positions()
    series = run(plant, config, np.full(n, 0.1), desired, only=WANTED)
    assert series["status"][399] in (Status.CALMED, Status.OSCILLATING, Status.STUCK)
    return lengths(series["task_error"])[-1]


@pytest.mark.parametrize("speed", [0.1, 0.25, 1.0])
@pytest.mark.parametrize("near", [(0.3, 0.9), (0.6, 0.7)])
def test_a_target_that_comes_back_slowly_wakes_the_arm(near, speed, plant_with, run):
    config = fd.FuzzyIkConfig(fused=True, task="xy")
    assert come_back(run, plant_with("planar4"), config, (0.0, 2.0), near, speed) < 1e-3


@pytest.mark.parametrize("speed", [0.25, np.inf])
@pytest.mark.parametrize("restart_search", [False, True])
@pytest.mark.parametrize(
    ("arm", "far", "near"),
    [("planar4", (0.0, 2.0), (0.0, 0.9)), ("arm7", (2.0, 0.0, 0.0), (0.7, 0.0, 0.0))],
)
def test_a_target_that_comes_straight_back_wakes_the_arm(
    arm, far, near, restart_search, speed, plant_with, run
):
    """Along the stretched arm, as the paper's controller can, which never rests."""
    task = "xy" if len(far) == 2 else "position"
    config = fd.FuzzyIkConfig(fused=True, task=task, restart_search=restart_search)
    assert come_back(run, plant_with(arm), config, far, near, speed) < 1e-3


def test_a_line_is_tracked_as_before(scenario_inputs, plant_with, run):
    """Nothing oscillates on the way of Table 6: the calm takes no part."""
    results = []
    for calming in (0.8, 1.0):
        supervisor = fd.GainSupervisorConfig(calming=calming)
        arm, config, start, desired = scenario_inputs(
            "table6_5s", fused=True, supervisor=supervisor
        )
        series = run(plant_with(arm), config, start, desired, only=WANTED)
        results.append(series["commanded_position"])
    np.testing.assert_array_equal(*results)
