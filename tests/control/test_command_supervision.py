"""The gain of each joint of a command that chatters, and of one that does not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

import fikm_drake as fd
from fikm_drake.control.command_supervision import REGROWTH

COMMANDS = hnp.arrays(
    float, st.tuples(st.integers(1, 60), st.just(3)), elements=st.floats(-1e3, 1e3)
)


def gains(commands, config=None):
    """The gain (N,n) that each command of a series meets."""
    supervision = fd.CommandSupervision(len(commands[0]), config)
    memory = supervision.initial_memory()
    series = []
    for command in commands:
        series.append(supervision.gain(memory).copy())
        supervision.remember(memory, np.asarray(command, dtype=float))
    return np.array(series)


def chatter(cycles):
    return np.where(np.arange(cycles) % 2, 1.0, -1.0)


@given(commands=COMMANDS)
def test_gains_stay_between_the_least_and_1(commands):
    series = gains(commands)
    assert (series <= 1.0).all() and (series >= fd.CommandSupervisorConfig().least_gain).all()


@given(commands=COMMANDS)
def test_a_command_that_keeps_its_signs_passes_untouched(commands):
    assert (gains(np.abs(commands)) == 1.0).all()


def test_the_gain_falls_by_its_factor_to_the_least():
    """Four changes are there after five commands; then 0.8 a cycle, as far as 0.01."""
    series = gains(chatter(40)[:, None])[:, 0]
    expected = np.concatenate([np.ones(5), 0.8 ** np.arange(1, 36)])
    np.testing.assert_allclose(series, np.maximum(expected, 0.01), rtol=1e-12)


def test_only_the_joint_that_chatters_is_calmed():
    commands = np.stack([chatter(30), np.ones(30), np.linspace(-1, 1, 30)], axis=1)
    series = gains(commands)
    assert series[-1, 0] < 0.02
    assert (series[:, 1:] == 1.0).all()


def test_the_gain_recovers_when_the_command_keeps_its_sign():
    commands = np.concatenate([chatter(40), np.ones(40)])[:, None]
    series = gains(commands)[:, 0]
    # The window has to empty to three changes first; then half of 0.5 more each cycle.
    start = series.argmin() + np.flatnonzero(np.diff(series[series.argmin() :]) > 0)[0]
    rising = series[start:][series[start:] < 1.0]
    np.testing.assert_allclose(rising[1:] / rising[:-1], 1.25, rtol=1e-12)
    assert series[-1] == 1.0


def test_each_outbreak_makes_the_recovery_slower():
    """Bursts of chatter with rests between: the gain after each rest is lower than the last time."""
    burst, rest = chatter(20), np.ones(18)
    series = gains(np.concatenate([burst, rest] * 5)[:, None])[:, 0]
    after = series[37::38]
    assert (np.diff(after) < 0.0).all()


def test_calm_at_a_gain_of_1_makes_up_for_an_outbreak():
    config = fd.CommandSupervisorConfig()
    calm = int(np.ceil(np.log(2.0) / np.log(REGROWTH)))
    once = np.concatenate([chatter(20), np.ones(40 + calm)])
    supervision = fd.CommandSupervision(1, config)
    memory = supervision.initial_memory()
    for command in once:
        supervision.remember(memory, np.array([command]))
    recovery = memory[1]
    assert recovery == pytest.approx(config.recovery)


def test_commands_inside_the_dead_band_are_no_chatter():
    config = fd.CommandSupervisorConfig(dead_band=2.0)
    assert (gains(chatter(40)[:, None], config) == 1.0).all()


def test_memory_is_all_that_it_remembers():
    rng = np.random.default_rng(0)
    commands = rng.normal(size=(50, 7))
    supervision = fd.CommandSupervision(7)
    first, other = supervision.initial_memory(), supervision.initial_memory()
    for command in commands:
        supervision.remember(first, command)
        supervision.remember(other, -np.abs(command))
    alone = supervision.initial_memory()
    for command in commands:
        supervision.remember(alone, command)
    np.testing.assert_array_equal(first, alone)


def test_config_round_trips_through_typed_yaml():
    config = fd.CommandSupervisorConfig(window=12, least_gain=0.02)
    text = yaml_dump_typed(config)
    assert yaml_load_typed(schema=fd.CommandSupervisorConfig, data=text) == config


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"window": 1}, ["window", "1"]),
        ({"window": 2.5}, ["window", "2.5"]),
        ({"sign_changes": 0}, ["sign_changes", "0", "9"]),
        ({"sign_changes": 10}, ["sign_changes", "10", "9"]),
        ({"dead_band": -1.0}, ["dead_band", "-1.0"]),
        ({"dead_band": np.nan}, ["dead_band", "nan"]),
        ({"fall": 1.0}, ["fall", "1.0"]),
        ({"fall": 0.0}, ["fall", "0.0"]),
        ({"least_gain": 0.0}, ["least_gain", "0.0"]),
        ({"least_gain": np.nan}, ["least_gain", "nan"]),
        ({"recovery": np.inf}, ["recovery", "inf"]),
        ({"recovery": 0.001}, ["recovery", "0.001", "slowest_recovery", "0.008"]),
        ({"slowest_recovery": 0.0}, ["slowest_recovery", "0.0"]),
    ],
)
def test_bad_values_are_named(changes, words):
    config = replace(fd.CommandSupervisorConfig(), **changes)
    with pytest.raises(ValueError) as error:
        fd.CommandSupervision(7, config)
    assert all(word in str(error.value) for word in words)
