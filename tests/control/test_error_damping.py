"""Damping that grows with the error: calm out of reach, and nothing lost inside it."""

import dataclasses

import numpy as np
import pytest
from pydrake.math import RigidTransform

import fikm_drake as fd
from fikm_drake.control.rollout import rollout
from fikm_drake.kinematics.tasks import make_task

GROWS = fd.FuzzyMapping.iterated()
STAYS = dataclasses.replace(GROWS, error_damping=0.0)
SETTLED = 4.0
"""The way out to the border is over [s]."""


def motion(name, task, law, targets, start):
    """Joint positions (N,n) and errors (N,) of a run of `for_tracking` with a law, at 50 Hz."""
    arm = fd.load_arm(name)
    config = dataclasses.replace(fd.FuzzyIkConfig(task=task).for_tracking(), law=law)
    plant_arm = fd.PlantArm(fd.MakeDhArmPlant(arm), "tool")
    run = rollout(fd.ControlCycle(make_task(plant_arm, task), config), list(targets), start)
    return run.q, np.linalg.norm(run.error, axis=1)


def circle(radius, speed, phase, rows):
    """A circle about the base, 12 s."""
    angle = phase + speed / radius * np.arange(600) / 50.0
    flat = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return flat if rows == 2 else np.column_stack([flat, np.full(len(flat), 0.1)])


def jerkiness(q):
    """Largest change of the joint step from cycle to cycle, once the arm is out there [rad]."""
    return np.linalg.norm(np.diff(q, n=2, axis=0), axis=1)[round(50 * SETTLED) :].max()


@pytest.mark.parametrize(
    ("name", "task", "radius", "speed", "phase"),
    [
        ("planar4", "xy", 2.0, 0.3, 0.0),
        ("planar4", "xy", 1.7, 0.6, 1.0),
        ("arm7", "position", 1.7, 0.3, 0.0),
        ("iiwa14", "position", 1.3, 0.2, 1.0),
        ("panda", "position", 1.3, 0.2, 1.0),
    ],
)
def test_round_a_circle_out_of_reach_the_arm_does_not_flail(name, task, radius, speed, phase):
    targets = circle(radius, speed, phase, 2 if task == "xy" else 3)
    start = np.full(fd.load_arm(name).num_joints, 0.1)
    calm, _ = motion(name, task, GROWS, targets, start)
    flailing, _ = motion(name, task, STAYS, targets, start)
    assert jerkiness(calm) < 0.02
    assert jerkiness(flailing) > 0.1


@pytest.mark.parametrize("name", ["iiwa14", "ur5", "gen3"])
@pytest.mark.parametrize("seed", range(3))
def test_inside_the_reach_it_follows_as_closely(name, seed):
    arm, rng = fd.load_arm(name), np.random.default_rng(seed)
    low, high = np.maximum(arm.lower, -3.1), np.minimum(arm.upper, 3.1)
    start, end = rng.uniform(0.8 * low + 0.2 * high, 0.2 * low + 0.8 * high, (2, arm.num_joints))
    share = 0.15 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 400)))
    poses = arm.forward_kinematics(start + share[:, None] * (end - start))
    targets = [RigidTransform(T) for T in poses]
    _, grows = motion(name, "pose", GROWS, targets, start)
    _, stays = motion(name, "pose", STAYS, targets, start)
    assert grows.mean() <= 1.05 * stays.mean() + 1e-6
    assert grows.max() <= 1.1 * stays.max() + 1e-6


STRETCHED = {
    "iiwa14": [0.3, 0.7, 0.2, -0.01, 0.4, 0.8, 0.3],
    "ur5": [0.4, -1.2, 0.01, -1.5, 0.8, 0.6],
    "gen3": [0.3, 0.7, 0.2, -0.01, 0.4, 0.8, 0.3],
    "xarm7": [0.3, 0.7, 0.2, 0.01, 0.4, 0.8, 0.3],
}
"""Postures with an elbow that is nearly stretched [rad]."""


@pytest.mark.parametrize("name", STRETCHED)
@pytest.mark.parametrize("seed", range(3))
def test_before_a_target_that_is_nearly_out_of_reach_the_arm_comes_to_rest(name, seed):
    """No damping is left there with which it would creep along the direction in which it hardly moves."""
    arm, rng = fd.load_arm(name), np.random.default_rng(seed)
    goal = np.array(STRETCHED[name])
    start = np.clip(goal + rng.normal(0.0, 0.3, len(goal)), arm.lower, arm.upper)
    pose = RigidTransform(arm.forward_kinematics(goal))
    config = fd.FuzzyIkConfig(task="pose", law=GROWS, control_rate=100.0)
    plant_arm = fd.PlantArm(fd.MakeDhArmPlant(arm), "tool")
    cycle = fd.ControlCycle(make_task(plant_arm, "pose"), config)
    run = rollout(cycle, [pose] * 1200, start)
    assert np.abs(np.diff(run.q[-20:], axis=0)).max() < 1e-7
    assert np.linalg.norm(run.error[-1]) < 1e-7
