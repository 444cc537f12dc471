"""Limits of a cycle's motion in whole runs: length, speed, acceleration, of the config and the plant."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointIndex

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
CENTER = np.array([0.3, -0.45, 0.3])
RATE = 50.0
WANTED = ("commanded_position", "commanded_velocity", "task_error", "status")


@pytest.mark.parametrize("calming", [0.8, 1.0])
def test_no_cycle_moves_further_than_the_longest_step(calming, plant_with, run, fused):
    """Two iterations at a stretched arm ask for far more."""
    supervisor = fd.GainSupervisorConfig(calming=calming)
    config = fd.FuzzyIkConfig(
        law=fd.FuzzyMapping(iterations=2),
        fused=fused,
        task="xy",
        supervisor=supervisor,
        default_velocity_limit=np.inf,
    )
    moved = {}
    for longest in (0.5, np.inf):
        each = replace(config, max_joint_step=longest)
        desired = np.tile((0.0, 2.5), (100, 1))
        q = run(plant_with("planar2"), each, np.zeros(2), desired, only=WANTED)
        moved[longest] = np.linalg.norm(np.diff(q["commanded_position"], axis=0), axis=1).max()
    assert moved[0.5] <= 0.5 + 1e-12
    assert moved[np.inf] > 2.0


@pytest.mark.parametrize("name", ["table6_2s", "large_step_2", "large_step_4"])
def test_the_longest_step_does_not_touch_the_papers_runs(name, scenario_inputs, plant_with, run):
    runs = []
    for longest in (0.5, np.inf):
        arm, config, start, desired = scenario_inputs(name, fused=True, max_joint_step=longest)
        runs.append(run(plant_with(arm), config, start, desired, only=WANTED))
    np.testing.assert_array_equal(*(series["commanded_position"] for series in runs))


def chase(seconds=4.0, rest=3.0, lost=None):
    """A target on a circle of 0.3 m, twice round a second, that then stops."""
    t = np.minimum(np.arange(0.0, seconds + rest, 1 / RATE), seconds)[:, None]
    angle = 4 * np.pi * t
    desired = CENTER + 0.3 * np.hstack([np.cos(angle), np.sin(angle), 0 * angle])
    if lost:
        desired[lost[0] : lost[1]] = np.nan
    return desired


def largest(series):
    """Largest speed and acceleration of the command, which starts from rest, of each joint."""
    q = series["commanded_position"]
    velocity = np.diff(q, axis=0) * RATE
    np.testing.assert_allclose(series["commanded_velocity"][1:], velocity, atol=1e-9)
    acceleration = np.diff(velocity, axis=0, prepend=np.zeros((1, q.shape[1]))) * RATE
    return np.abs(velocity).max(axis=0), np.abs(acceleration).max(axis=0)


@pytest.mark.parametrize(
    ("velocity", "acceleration"), [(0.8, np.inf), (np.inf, 4.0), (0.8, 4.0), (3.0, 30.0)]
)
def test_a_fast_target_is_chased_within_the_limits(velocity, acceleration, plant, run, fused):
    config = fd.FuzzyIkConfig(
        fused=fused, velocity_limits=[velocity], acceleration_limits=[acceleration]
    )
    free = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, chase(), only=WANTED)
    assert (largest(free) > np.array([[velocity], [acceleration]])).any()
    series = run(plant, config, Q0, chase(), only=WANTED)
    speeds, accelerations = largest(series)
    assert speeds.max() <= velocity + 1e-9
    assert accelerations.max() <= acceleration + 1e-6
    assert Status.LIMITED in series["status"]
    assert series["status"][-1] == Status.CONVERGED


@pytest.mark.parametrize(
    "options", [{}, {"law": fd.FuzzyMapping(iterations=3, damping=0.05)}, {"restart_search": True}]
)
def test_the_arm_brakes_before_its_joint_limits(options, plant_with, run):
    """A panda, driven round behind itself, where joints reach their limits."""
    arm = fd.load_arm("panda")
    angle = np.linspace(0, 2 * np.pi, 400)[:, None]
    desired = np.array([0.2, 0.0, 0.5]) + 0.9 * np.hstack([np.cos(angle), np.sin(angle), 0 * angle])
    config = fd.FuzzyIkConfig(
        fused=True, velocity_limits=[1.0], acceleration_limits=[5.0], limit_margin=0.0, **options
    )
    start = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    series = run(plant_with("panda"), config, start, desired, only=WANTED)
    speeds, accelerations = largest(series)
    assert speeds.max() <= 1.0 + 1e-9 and accelerations.max() <= 5.0 + 1e-6
    q = series["commanded_position"]
    assert (q >= arm.lower).all() and (q <= arm.upper).all()
    gap = np.minimum(arm.upper - q, q - arm.lower).min(axis=0)
    assert gap.min() < 1e-3  # some joint was there


def limited_plant():
    """arm7 with a speed and an acceleration of its own for each joint."""
    plant = MultibodyPlant(0.0)
    fd.AddDhArm(plant, fd.load_arm("arm7"))
    velocity, acceleration = np.linspace(0.5, 1.1, 7), np.linspace(6.0, 3.0, 7)
    joints = [plant.get_joint(JointIndex(i)) for i in range(plant.num_joints())]
    for joint, v, a in zip([j for j in joints if j.num_positions()], velocity, acceleration):
        joint.set_velocity_limits([-v], [2 * v])
        joint.set_acceleration_limits([-2 * a], [a])
    plant.Finalize()
    return plant, velocity, acceleration


def test_the_plant_s_own_limits_count(run, fused):
    """Where those of the two directions differ, the smaller; the config's where that is smaller."""
    plant, velocity, acceleration = limited_plant()
    series = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, chase(), only=WANTED)
    speeds, accelerations = largest(series)
    assert (speeds <= velocity + 1e-9).all() and (accelerations <= acceleration + 1e-6).all()
    assert (accelerations > 0.9 * acceleration).any()
    config = fd.FuzzyIkConfig(fused=fused, velocity_limits=[0.7], acceleration_limits=[4.0])
    speeds, accelerations = largest(run(plant, config, Q0, chase(), only=WANTED))
    assert (speeds <= np.minimum(velocity, 0.7) + 1e-9).all()
    assert (accelerations <= np.minimum(acceleration, 4.0) + 1e-6).all()


def test_limits_are_of_each_joint(plant, run, fused):
    """Vectors in the config; inf is no limit of its joint, but the default bound of speed stays."""
    velocity = np.array([0.3, 2.0, 0.5, np.inf, 1.0, 0.05, 3.0])
    acceleration = np.array([9.0, np.inf, 2.0, 20.0, 1.0, np.inf, 5.0])
    config = fd.FuzzyIkConfig(
        fused=fused,
        velocity_limits=velocity.tolist(),
        acceleration_limits=acceleration.tolist(),
        jerk_limits=[np.inf, 300.0, *[np.inf] * 5],
        default_velocity_limit=4.0,
    )
    speeds, accelerations = largest(run(plant, config, Q0, chase(), only=WANTED))
    bound = np.minimum(velocity, 4.0)
    assert (speeds <= bound + 1e-9).all() and (accelerations <= acceleration + 1e-6).all()
    assert (speeds > 0.9 * bound).any() and (accelerations > 0.9 * acceleration).any()


def test_a_lost_target_is_no_reason_to_break_them(plant, run, fused):
    """The arm brakes, stands, and goes on; the position is held once it stands."""
    config = fd.FuzzyIkConfig(fused=fused, velocity_limits=[0.8], acceleration_limits=[4.0])
    series = run(plant, config, Q0, chase(lost=(60, 100)), only=WANTED)
    speeds, accelerations = largest(series)
    assert speeds.max() <= 0.8 + 1e-9 and accelerations.max() <= 4.0 + 1e-6
    assert (series["status"][60:100] == Status.INVALID_INPUT).all()
    stop = 60 + int(np.ceil(0.8 / 4.0 * RATE))
    held = series["commanded_position"][stop:101]
    np.testing.assert_array_equal(held, np.tile(held[0], (len(held), 1)))


@pytest.mark.parametrize("acceleration", [2.0, 10.0, 50.0])
@pytest.mark.parametrize("step", [(0.1, 0.1, -0.1), (0.1, 0.0, 0.0), (0.3, 0.1, -0.2)])
def test_a_target_that_jumps_is_reached_as_without_a_limit(acceleration, step, plant, run):
    """The law overshoots by up to 43 % of the way, from its filters; a limit adds less than 10 %."""
    tool = fd.load_arm("arm7").forward_kinematics(Q0)[:3, 3]
    desired, most = np.tile(tool + step, (250, 1)), {}
    for limit in (np.inf, acceleration):
        config = fd.FuzzyIkConfig(fused=True, acceleration_limits=[limit])
        series = run(plant, config, Q0, desired, only=WANTED)
        most[limit] = (1 - series["task_error"] @ step / np.dot(step, step)).max()
        assert series["status"][-1] == Status.CONVERGED
    assert most[acceleration] <= most[np.inf] + 0.1


def test_set_positions_starts_from_rest(plant, fused):
    controller = fd.MakeFuzzyIkController(
        plant, config=fd.FuzzyIkConfig(fused=fused, acceleration_limits=[4.0])
    )
    context = controller.CreateDefaultContext()
    controller.GetInputPort("desired_position").FixValue(context, CENTER)
    command = controller.GetOutputPort("commanded_position")
    for start in (Q0, -Q0):
        controller.SetPositions(context, start)
        for _ in range(10):
            before = command.Eval(context).copy()
            context.SetDiscreteState(controller.EvalUniquePeriodicDiscreteUpdate(context))
            if (before == start).all():
                assert np.abs(command.Eval(context) - start).max() <= 4.0 / RATE**2 + 1e-9
