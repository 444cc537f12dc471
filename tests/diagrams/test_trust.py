"""Inputs that once made a controller jump, stick, or say what is not so."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

WANTED = ("commanded_position", "joint_step", "task_error", "status")
PANDA = [0.1, -0.7, 0.2, -2.2, 0.1, 1.6, 0.7]
BALL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def lifted_arm(speed):
    """A 3R arm on a lift with this limit of speed [m/s]."""
    joints = [
        ("prismatic", "0 0 1", "0 0 0.3", "0", "0.35", speed),
        ("revolute", "0 0 1", "0 0 0.3", "-2", "2", 2.0),
        ("revolute", "0 1 0", "0 0 0", "-2", "2", 2.0),
        ("revolute", "0 1 0", "0.4 0 0", "-2", "2", 2.0),
    ]
    text, parent = '<robot name="r"><link name="base"/>', "base"
    for i, (kind, axis, xyz, lower, upper, fast) in enumerate(joints):
        text += (
            f'<link name="l{i}">{BALL}</link><joint name="j{i}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="l{i}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/>'
            f'<limit lower="{lower}" upper="{upper}" velocity="{fast}" effort="9"/></joint>'
        )
        parent = f"l{i}"
    text += (
        f'<link name="tool">{BALL}</link><joint name="t" type="fixed"><parent link="{parent}"/>'
        '<child link="tool"/><origin xyz="0.3 0 0"/></joint></robot>'
    )
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return plant


@pytest.mark.parametrize("iterations", [1, 3])
@pytest.mark.parametrize("speed", [0.002, 0.02, 1.0])
def test_a_slow_lift_does_not_hold_back_the_arm_on_it(speed, iterations, run, fused):
    law = fd.FuzzyMapping(iterations=iterations)
    config = fd.FuzzyIkConfig(control_rate=100.0, law=law, fused=fused)
    series = run(lifted_arm(speed), config, np.zeros(4), np.tile((0.3, 0.3, 0.9), (300, 1)))
    assert series["status"][-1] == Status.CONVERGED
    steps = np.abs(np.diff(series["commanded_position"], axis=0)).max(axis=0)
    assert (steps <= np.array([speed, 2.0, 2.0, 2.0]) / 100.0 + 1e-12).all()
    assert Status.LIMITED in series["status"][:20]


@pytest.mark.parametrize("iterations", [1, 3])
@pytest.mark.parametrize("hardest", [0.01, 0.05, 0.5])
def test_a_lift_that_is_slow_to_brake_does_not_hold_back_the_arm_on_it(
    hardest, iterations, run, fused
):
    """It took 10 s at 0.01 m/s²; without the limit 1 s."""
    law, accelerations = fd.FuzzyMapping(iterations=iterations), [hardest, np.inf, np.inf, np.inf]
    config = fd.FuzzyIkConfig(
        control_rate=100.0, law=law, fused=fused, acceleration_limits=accelerations
    )
    series = run(lifted_arm(1.0), config, np.zeros(4), np.tile((0.3, 0.3, 0.9), (150, 1)))
    assert lengths(series["task_error"])[120:].max() < 1e-3
    steps = np.diff(series["commanded_position"][:, 0], prepend=0.0)
    assert np.abs(np.diff(steps)).max() <= hardest * 1e-4 + 1e-12


@pytest.mark.parametrize(
    ("task", "x"), [("orientation", np.nan), ("pose", 1e200), ("pose", 1e155), ("pose", np.inf)]
)
def test_a_pose_that_is_none_holds_the_arm(task, x, plant_with, run, fused):
    config = fd.FuzzyIkConfig(task=task, fused=fused)
    pose = RigidTransform(RotationMatrix(RollPitchYaw(1, 2, 0.5)), [x, 0, 0])
    with np.errstate(over="ignore"):
        series = run(plant_with("panda"), config, PANDA, [pose] * 3)
    assert (series["status"] == Status.INVALID_INPUT).all()
    assert not series["joint_step"].any() and not series["task_error"].any()
    np.testing.assert_array_equal(series["after"], PANDA)


def test_a_pose_that_is_far_is_not_reached(plant_with, run, fused):
    config = fd.FuzzyIkConfig(task="pose", fused=fused)
    series = run(plant_with("panda"), config, PANDA, [RigidTransform([1e90, 0, 0])] * 3)
    assert not (series["status"] == Status.CONVERGED).any()
    assert np.isfinite(series["after"]).all()


@pytest.mark.parametrize("options", [{"error_limit": np.inf}, {"singularity_nudge": 10.0}, {}])
def test_no_step_is_longer_than_the_longest(options, plant_with, run, fused):
    """A target straight inward, very far: the step aside is in proportion to the error."""
    config = fd.FuzzyIkConfig(task="xy", fused=fused, default_velocity_limit=np.inf, **options)
    series = run(plant_with("planar4"), config, np.zeros(4), np.tile((-1e4, 0.0), (20, 1)))
    q = series["commanded_position"]
    assert np.linalg.norm(np.diff(q, axis=0), axis=1).max() <= 0.5 + 1e-12


def test_the_command_finds_back_from_a_target_at_the_end_of_all_numbers(plant_with, run, fused):
    config = fd.FuzzyIkConfig(
        task="xy", error_limit=np.inf, error_smoothing=0.0, gain_smoothing=0.0, fused=fused
    )
    for far in (config, config.as_in_paper()):
        desired = [[-1.2e154, 0.0]] * 5 + [[-1e99, 0.0]] * 5 + [[1.0, 0.5]] * 300
        with np.errstate(over="ignore"):
            series = run(plant_with("planar4"), far, np.zeros(4), np.array(desired))
        assert all(np.isfinite(values).all() for values in series.values())
        assert series["status"][-1] in (Status.CONVERGED, Status.TRACKING)
        assert np.linalg.norm(series["task_error"][-1]) < 0.05


def test_a_joint_without_a_speed_limit_has_that_of_the_config(plant_with, run, fused):
    plant = plant_with("planar4")
    for options, most in (({}, 10.0), ({"default_velocity_limit": 0.7}, 0.7)):
        config = fd.FuzzyIkConfig(task="xy", control_rate=200.0, fused=fused, **options)
        series = run(plant, config, np.full(4, 0.5), np.tile((-1.0, 0.5), (60, 1)))
        speed = np.abs(np.diff(series["commanded_position"], axis=0)).max() * 200.0
        assert speed <= most + 1e-9 and (most > 1.0 or speed > 0.6)
    config = fd.FuzzyIkConfig(task="xy", velocity_limits=[20.0], default_velocity_limit=1.0)
    arm = fd.PlantArm(plant)
    np.testing.assert_array_equal(config.speeds(arm), np.full(4, 20.0))
    assert (fd.FuzzyIkConfig().as_in_paper().speeds(arm) == np.inf).all()
