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


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, np.nan, np.inf])
def test_bad_bandwidth_is_named(bandwidth):
    with pytest.raises(ValueError, match="bandwidth must be positive and finite"):
        SCENARIO.but(plant=fd.scenario.TorqueDriven(bandwidth))
