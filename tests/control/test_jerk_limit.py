"""Limits of jerk: kept together with those of position, speed and acceleration, whatever is asked."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.control.jerk_limit import MOST_CYCLES, JerkLimit
from fikm_drake.control.joint_limits import JointLimits

PERIOD = 0.01
LOWER, UPPER = np.array([-0.2, -np.inf, -0.3]), np.array([0.5, 0.5, 0.4])
REST = np.zeros(3)

speeds = hnp.arrays(float, 3, elements=st.floats(0.05, 10.0))
accelerations = hnp.arrays(float, 3, elements=st.one_of(st.floats(0.5, 200.0), st.just(np.inf)))
jerks = hnp.arrays(float, 3, elements=st.one_of(st.floats(20.0, 1e5), st.just(np.inf)))
choices = st.lists(hnp.arrays(float, 3, elements=st.floats(0, 1)), min_size=1, max_size=40)


def make(speed, acceleration, jerk, lower=LOWER, upper=UPPER):
    """The limits that a loop keeps to, and what smooths its command."""
    jerk_limit = JerkLimit(
        jerk,
        period=PERIOD,
        velocity_limits=speed,
        acceleration_limits=acceleration,
        num_joints=3,
    )
    limits = JointLimits(
        lower,
        upper,
        period=PERIOD,
        velocity_limits=speed,
        acceleration_limits=jerk_limit.accelerations,
    )
    return limits, jerk_limit


def sent(limits, jerk_limit, shares, stop=3000):
    """What goes out (N,3) and its velocity: steps inside the bounds as the shares say, then the stop."""
    position, last, memory = REST.copy(), REST, jerk_limit.start(REST)
    out = [(jerk_limit.command(memory, position), jerk_limit.velocity(memory, position))]
    for share in [*shares, *[None] * stop]:
        low, high = limits.step_bounds(position, last / PERIOD)
        near, far = np.maximum(low, -3.0), np.minimum(high, 3.0)
        step = np.clip(0.0, low, high) if share is None else near + share * (far - near)
        jerk_limit.remember(memory, position)
        position, last = limits.add(position, step), step
        out.append((jerk_limit.command(memory, position), jerk_limit.velocity(memory, position)))
        if share is None and not (memory - position).any():
            break
    assert not (memory - position).any()  # it has come to rest
    return tuple(np.array(part) for part in zip(*out))


@settings(max_examples=200, deadline=None)
@given(speeds, accelerations, jerks, choices)
def test_all_limits_are_kept_together_and_a_stop_before_a_limit_of_position_stays_possible(
    speed, acceleration, jerk, shares
):
    """Any steps inside the loop's bounds, the fastest toward a limit among them, then the shortest stop."""
    limits, jerk_limit = make(speed, acceleration, jerk)
    q, v = sent(limits, jerk_limit, [*shares, *[np.ones(3)] * 30])
    assert (q >= LOWER).all() and (q <= UPPER).all()
    v_q = np.diff(q, axis=0) / PERIOD
    np.testing.assert_allclose(v[1:], v_q, atol=1e-10)
    a_q = np.diff(v, axis=0, prepend=np.zeros((1, 3))) / PERIOD
    j_q = np.diff(a_q, axis=0, prepend=np.zeros((1, 3))) / PERIOD
    assert (np.abs(v) <= speed * (1 + 1e-9) + 1e-11).all()
    assert (np.abs(a_q) <= acceleration * (1 + 1e-9) + 1e-9).all()
    assert (np.abs(j_q) <= jerk * (1 + 1e-9) + 1e-6).all()
    np.testing.assert_allclose(v[-1], 0.0, atol=1e-12)


@pytest.mark.parametrize("jerk", [50.0, 500.0, 5000.0])
def test_to_full_speed_it_takes_little_longer_than_the_least(jerk):
    """2.83 √(v / j) and two cycles; the least is 2 √(v / j)."""
    free = np.full(3, np.inf)
    limits, jerk_limit = make(2.0, np.inf, jerk, -free, free)
    _, v = sent(limits, jerk_limit, [np.ones(3)] * 200)
    reached = np.flatnonzero(v[:, 0] >= 2.0 * (1 - 1e-9))[0] * PERIOD
    assert reached <= 2.83 * np.sqrt(2.0 / jerk) + 2.0 * PERIOD
    assert v[:, 0].max() <= 2.0 * (1 + 1e-12)


def test_a_stretch_of_path_keeps_its_shape():
    """All joints are smoothed alike: along a straight line what goes out stays on it."""
    limits, jerk_limit = make(2.0, 5.0, [100.0, 3000.0, np.inf], -np.full(3, 9.0), np.full(3, 9.0))
    way = np.array([1.0, -0.5, 0.25])
    position, memory, out = REST.copy(), jerk_limit.start(REST), []
    for size in np.clip(np.arange(100) * 4e-4, 0.0, 0.015):
        jerk_limit.remember(memory, position)
        position = position + size * way
        out.append(jerk_limit.command(memory, position))
    out = np.array(out)
    np.testing.assert_allclose(out, np.outer(out @ way / (way @ way), way), atol=1e-12)


def test_without_a_limit_of_jerk_the_newest_command_goes_out():
    _, jerk_limit = make(2.0, 5.0, np.inf)
    assert (jerk_limit.cycles, jerk_limit.late) == (1, 0.0)
    memory, command = jerk_limit.start(REST), np.array([0.3, -0.1, 7.0])
    np.testing.assert_array_equal(jerk_limit.command(memory, command), command)
    np.testing.assert_allclose(jerk_limit.velocity(memory, command), command / PERIOD)
    np.testing.assert_array_equal(jerk_limit.accelerations, np.full(3, 5.0))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"jerk_limits": 0.0}, ["jerk_limits", "positive"]),
        ({"jerk_limits": [1.0, 2.0]}, ["jerk_limits", "3"]),
        ({"jerk_limits": [9e4, np.nan, 9e4]}, ["jerk_limits", "nan"]),
        ({"velocity_limits": [2.0, np.inf, 2.0]}, ["joint 1", "velocity_limits"]),
        ({"jerk_limits": 1e-9}, ["jerk_limits", str(MOST_CYCLES), "raise"]),
    ],
)
def test_errors_name_the_bad_value_and_the_remedy(arguments, words):
    good = {"jerk_limits": 500.0, "velocity_limits": 2.0, "acceleration_limits": np.inf}
    with pytest.raises(ValueError) as error:
        JerkLimit(**(good | arguments), period=PERIOD, num_joints=3)
    for word in words:
        assert word in str(error.value)
