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
    assert yaml_load_typed(schema=fd.TrackingScenario, data=text) == SCENARIO


@pytest.mark.parametrize("measured", [False, True])
def test_errors_are_near_the_kinematic_ones(measured):
    config = replace(SCENARIO.config, measured_position=measured)
    ideal = fd.simulate(replace(SCENARIO, servo_bandwidth=None)).metrics()
    real = fd.simulate(replace(SCENARIO, config=config)).metrics()
    for name in ("e_max", "e_mean"):
        assert getattr(real, name) == pytest.approx(getattr(ideal, name), rel=0.1)
    assert real.e_max != ideal.e_max


def test_the_log_is_of_the_plants_joints():
    """They lag behind the command while it speeds up and are with it at rest."""
    log = fd.simulate(SCENARIO)
    command = np.cumsum(log.joint_step, axis=0) + SCENARIO.start()
    lag = np.abs(log.q - command).max(axis=1)
    assert 1e-4 < lag.max() < 0.05
    assert lag[-1] < 1e-4
    assert len(log.time) == SCENARIO.num_cycles


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, np.nan, np.inf])
def test_bad_bandwidth_is_named(bandwidth):
    with pytest.raises(ValueError, match="bandwidth must be positive and finite"):
        replace(SCENARIO, servo_bandwidth=bandwidth)
