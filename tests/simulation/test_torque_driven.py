"""Scenarios with an arm of mass and gravity."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

import fikm_drake as fd

SCENARIO = fd.TrackingScenario(
    "arm7",
    [[0.2, -0.6, 0.6], [0.3, -0.55, 0.5]],
    duration=0.6,
    hold=0.4,
    servo_bandwidth=100.0,
)


def test_round_trip_through_typed_yaml():
    text = yaml_dump_typed(SCENARIO)
    assert yaml_load_typed(schema=fd.Scenario, data=text) == SCENARIO


@pytest.mark.parametrize("measured", [False, True])
def test_errors_are_near_the_kinematic_ones(measured):
    config = replace(SCENARIO.controller_config(), measured_position=measured)
    ideal = fd.simulate(SCENARIO.but(plant="kinematic")).metrics()
    real = fd.simulate(SCENARIO.with_config(config)).metrics()
    for name in ("e_max", "e_mean"):
        assert getattr(real, name) == pytest.approx(getattr(ideal, name), rel=0.1)
    assert real.e_max != ideal.e_max


def test_the_log_is_of_the_plants_joints():
    """They lag behind the command while it speeds up and are with it at rest."""
    log = fd.simulate(SCENARIO)
    command = np.cumsum(log.joint_step[:-1], axis=0) + SCENARIO.start()
    np.testing.assert_allclose(log.command[1:], command, rtol=0, atol=1e-12)
    lag = np.abs(log.q - log.command).max(axis=1)
    assert 1e-4 < lag.max() < 0.05
    assert lag[-1] < 1e-4
    assert len(log) == SCENARIO.num_cycles + 1


def test_torque_and_velocity_are_those_of_the_plant():
    """At rest the torques bear the arm's weight: the gradient of its potential energy."""
    log = fd.simulate(SCENARIO)
    plant = fd.MakeDhArmPlant(SCENARIO.load_arm())
    context = plant.CreateDefaultContext()
    energy = []
    for q in log.q[-1] + 1e-5 * np.vstack([np.eye(7), -np.eye(7)]):
        plant.SetPositions(context, q)
        energy.append(plant.CalcPotentialEnergy(context))
    weight = (np.array(energy[:7]) - energy[7:]) / 2e-5
    np.testing.assert_allclose(log.torque[-1], weight, atol=0.02 * np.abs(weight).max())
    middle = (log.q[2:] - log.q[:-2]) * 25.0
    np.testing.assert_allclose(log.velocity[5:-1], middle[4:], atol=0.06)  # of 0.5 rad/s


def measured(**options):
    sensor = fd.scenario.Sensor(**options)
    seed = 3 if sensor.noise or sensor.speed_noise else 0
    return SCENARIO.but(sensor=sensor, seed=seed)


def test_inverse_dynamics_and_ik_get_what_the_sensor_measures():
    """Noise shakes the torques, repeatably, and the tool a little; what is late makes them swing."""
    exact = fd.simulate(SCENARIO)
    clean = fd.simulate(measured(rate=1000.0))  # a step of the plant late, as told in Sensor
    noisy, again = (fd.simulate(measured(noise=3e-4, speed_noise=0.01)) for _ in range(2))
    np.testing.assert_array_equal(noisy.q, again.q)
    np.testing.assert_array_equal(noisy.q[0], SCENARIO.start())
    late = fd.simulate(measured(delay=3e-3))
    apart = [np.abs(log.q - exact.q).max() for log in (clean, late)]
    assert 0.0 < apart[0] < 1e-3 < apart[1] < 0.01
    shaken = [np.abs(np.diff(log.torque[-15:], axis=0)).max() for log in (exact, noisy)]
    assert shaken[1] > 10.0 * shaken[0]
    assert noisy.metrics().e_max == pytest.approx(exact.metrics().e_max, rel=0.1)


def test_noise_in_the_speeds_alone_is_used():
    quiet = fd.simulate(measured(rate=1000.0))
    noisy = fd.simulate(measured(rate=1000.0, speed_noise=0.01))
    assert 1e-6 < np.abs(noisy.q - quiet.q).max() < 0.01


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"delay": 6e-3}, ["late by 7.5 ms", "bandwidth 100", "unstable from 6.47 ms"]),
        ({"rate": 80.0}, ["late by 7.25 ms", "unstable"]),
        ({"speed_noise": -1.0}, ["speed_noise", "-1"]),
    ],
)
def test_a_sensor_that_makes_the_inner_loop_unstable_is_refused(changes, words):
    with pytest.raises(ValueError) as error:
        measured(**changes)
    for word in words:
        assert word in str(error.value)
    measured(delay=2e-3).but(plant=fd.scenario.TorqueDriven(bandwidth=50.0))


def test_speed_noise_without_torques_is_not_used():
    config = replace(SCENARIO.controller_config(), measured_position=True)
    with pytest.raises(ValueError, match="speed_noise is not used"):
        SCENARIO.with_config(config).but(
            plant="kinematic", sensor=fd.scenario.Sensor(speed_noise=0.1), seed=1
        )


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, np.nan, np.inf])
def test_bad_bandwidth_is_named(bandwidth):
    with pytest.raises(ValueError, match="bandwidth must be positive and finite"):
        SCENARIO.but(plant=fd.scenario.TorqueDriven(bandwidth))
