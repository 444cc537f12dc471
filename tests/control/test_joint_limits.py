"""Limits of position, speed and acceleration: what a command may never do, whatever is asked."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.control.joint_limits import JointLimits

PERIOD = 0.02
LOWER, UPPER = np.array([-1.0, -np.inf, -0.3]), np.array([2.0, 0.5, 0.4])
NONE, REST = np.full(3, np.inf), np.zeros(3)

vectors = hnp.arrays(float, 3, elements=st.floats(-3, 3))
steps = st.lists(
    st.one_of(vectors, hnp.arrays(float, 3, elements=st.floats(-0.1, 0.1))), min_size=1, max_size=40
)
speeds = hnp.arrays(float, 3, elements=st.one_of(st.floats(0.05, 20.0), st.just(np.inf)))
accelerations = hnp.arrays(float, 3, elements=st.one_of(st.floats(0.1, 500.0), st.just(np.inf)))


def make(velocity=np.inf, acceleration=np.inf, lower=LOWER, upper=UPPER):
    return JointLimits(
        lower, upper, period=PERIOD, velocity_limits=velocity, acceleration_limits=acceleration
    )


def follow(limits, asked, position):
    """Positions of every cycle (N,3) from rest, the first included."""
    positions, velocity = [position], REST
    for step in asked:
        after = limits.integrate(positions[-1], step, velocity)
        velocity = (after - positions[-1]) / PERIOD
        positions.append(after)
    return np.array(positions)


@given(vectors, vectors, vectors, vectors)
def test_without_rates_the_command_is_cut_off_and_loses_nothing_inside(a, b, fraction, step):
    lower, upper = np.minimum(a, b) - 0.1, np.maximum(a, b) + 0.1
    limits = make(lower=lower, upper=upper)
    position = lower + np.abs(fraction) / 3 * (upper - lower)
    after = limits.integrate(position, step, REST)
    np.testing.assert_array_equal(after, np.clip(position + step, lower, upper))
    inside = (position + step >= lower) & (position + step <= upper)
    assert limits.limits(position, step, REST) == (not inside.all())


def test_without_any_limit_it_is_addition():
    limits = make(lower=-NONE, upper=NONE)
    after = limits.integrate(np.ones(3), np.full(3, 1e8), REST)
    np.testing.assert_array_equal(after, np.full(3, 1 + 1e8))
    assert not limits.limits(np.ones(3), np.full(3, 1e8), REST)


@settings(max_examples=200)
@given(speeds, accelerations, steps, hnp.arrays(float, 3, elements=st.floats(0, 1)))
def test_no_limit_is_passed_in_a_run_nor_in_the_stop_after_it(speed, acceleration, asked, where):
    low = np.maximum(LOWER, -2.0)
    start = np.minimum(low + where * (UPPER - low), UPPER)
    stop = [REST] * (len(asked) + 2)
    positions = follow(make(speed, acceleration), [*asked, *stop], start)
    assert (positions >= LOWER).all() and (positions <= UPPER).all()
    taken = np.diff(positions, axis=0)
    assert (np.abs(taken) <= speed * PERIOD + 1e-12).all()
    changes = np.diff(taken, axis=0, prepend=0.0)
    assert (np.abs(changes) <= acceleration * PERIOD**2 + 1e-12).all()
    assert np.abs(taken[-1]).max() <= 1e-12


@settings(max_examples=200)
@given(speeds, accelerations, steps)
def test_limits_says_whether_integrate_takes_something_away(speed, acceleration, asked):
    limits, position, velocity = make(speed, acceleration), REST, REST
    for step in asked:
        said = limits.limits(position, step, velocity)
        after = limits.integrate(position, step, velocity)
        assert said or (after == position + step).all()
        if not position.any():  # then the sum does not round
            assert said == (after != step).any()
        position, velocity = after, (after - position) / PERIOD


@given(vectors, speeds)
def test_a_limit_of_speed_alone_keeps_the_direction(step, speed):
    limits = make(speed, lower=-NONE, upper=NONE)
    taken = limits.integrate(REST, step, REST)
    share = min(1.0, (speed * PERIOD / np.maximum(np.abs(step), 1e-300)).min())
    np.testing.assert_allclose(taken, share * step, rtol=1e-12, atol=1e-300)
    assert limits.limits(REST, step, REST) == (share < 1.0)


@pytest.mark.parametrize("speed", [np.inf, 1.0])
def test_a_constant_wish_gives_a_ramp(speed):
    """From rest the step grows by a·T² a cycle, up to the fastest."""
    limits = make(speed, 2.0, lower=-NONE, upper=NONE)
    positions = follow(limits, np.full((40, 3), 3.0), REST)
    expected = np.minimum(2.0 * PERIOD**2 * np.arange(1, 41), speed * PERIOD)
    taken = np.diff(positions, axis=0)
    np.testing.assert_allclose(taken, np.tile(expected[:, None], 3), rtol=1e-9)


@pytest.mark.parametrize("acceleration", [0.7, 5.0, 60.0])
def test_it_drives_up_to_a_position_limit_and_no_slower_than_it_must(acceleration):
    """The last stop is at the limit, within a few cycles of the least time: √(2 · way / a) twice."""
    limits = make(np.inf, acceleration)
    cycles = 2 * np.sqrt(2.0 / acceleration) / PERIOD  # joint 1 has 2 rad to go
    positions = follow(limits, np.full((round(cycles) + 4, 3), 3.0), REST)
    np.testing.assert_allclose(positions[-1], UPPER, rtol=0, atol=1e-6)


@pytest.mark.parametrize("way", [1e-5, 0.01, 0.3])
def test_a_law_that_asks_for_what_is_left_arrives_without_overshoot(way):
    """`AHEAD` of a step is braked: a law without filters asks for all that is left."""
    limits, position, velocity = make(np.inf, 3.0, lower=-NONE, upper=NONE), REST, REST
    target, reached = np.array([way, -way, 0.5 * way]), []
    for _ in range(300):
        after = limits.integrate(position, target - position, velocity)
        position, velocity = after, (after - position) / PERIOD
        reached.append(after)
    np.testing.assert_allclose(position, target, atol=1e-9)
    assert (np.array(reached) / target).max() <= 1 + 1e-9


@pytest.mark.parametrize("name", ["velocity_limits", "acceleration_limits"])
@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.0, ["positive", "0.0"]),
        (-1.0, ["positive", "-1.0"]),
        (np.nan, ["positive", "nan"]),
        ([1.0, 2.0], ["3", "[1.0, 2.0]"]),
        ([1.0, 2.0, 0.0], ["positive", "[1.0, 2.0, 0.0]"]),
    ],
)
def test_errors_name_the_bad_value(name, value, words):
    with pytest.raises(ValueError, match=name) as error:
        JointLimits(LOWER, UPPER, period=PERIOD, **{name: value})
    for word in words:
        assert word in str(error.value)


@settings(max_examples=200)
@given(
    speeds,
    accelerations,
    st.lists(hnp.arrays(float, 3, elements=st.floats(0, 1)), min_size=1, max_size=40),
)
def test_any_step_inside_the_bounds_keeps_the_limits_for_good(speed, acceleration, choices):
    """The box is never empty; whatever is chosen in it, each cycle and the stop after are inside."""
    limits, position, last = make(speed, acceleration), REST, REST
    for share in [*choices, *[None] * 3000]:
        low, high = limits.step_bounds(position, last / PERIOD)
        assert (low <= high).all() and np.isfinite([low, high]).all()
        assert (np.maximum(low, -high) <= np.abs(last) + 1e-12).all()  # the shortest is no longer
        far_low, far_high = np.maximum(low, -3.0), np.minimum(high, 3.0)
        if share is None:
            step = np.clip(0.0, low, high)
        else:
            step = far_low + share * (far_high - far_low)
        after = position + step
        assert (after >= LOWER - 1e-12).all() and (after <= UPPER + 1e-12).all()
        assert (np.abs(step) <= speed * PERIOD + 1e-12).all()
        assert (np.abs(step - last) <= acceleration * PERIOD**2 + 1e-12).all()
        position, last = after, step
        if share is None and not last.any():
            break
    assert not last.any()


def test_a_command_that_is_too_fast_is_slowed_at_once():
    """As after limits were lowered in mid-motion: limits of position and speed come first."""
    low, high = make(1.0, 2.0).step_bounds(REST, np.array([9.0, 9.0, -9.0]))
    assert (low <= high).all()
    assert (np.abs([low, high]) <= PERIOD + 1e-12).all()


def test_without_position_limits_a_command_keeps_its_digits():
    limits = make(lower=-NONE, upper=NONE)
    position = limits.integrate(REST, np.array([1e99, -1e99, 1.0]), REST)
    np.testing.assert_array_equal(position, [1e9, -1e9, 1.0])
