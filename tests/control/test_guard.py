"""The last word of a cycle: finite, inside the bounds, not too long, whatever is asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.control.guard import Guard, shortest

anything = st.floats(allow_nan=True, allow_infinity=True)
unit = st.floats(-1.0, 1.0)
sizes = st.one_of(st.floats(1e-9, 1e6), st.just(np.inf))


@st.composite
def cases(draw, asked=anything, last=unit):
    """A step, bounds that hold a last step shortened toward zero, and a length that it keeps."""
    n = draw(st.integers(1, 60))
    vector = hnp.arrays(float, n, elements=last)
    a, b = draw(vector), draw(vector)
    low, high = np.minimum(a, b), np.maximum(a, b)
    step = draw(hnp.arrays(float, n, elements=asked))
    longest = draw(sizes)
    return step, low, high, max(longest, float(np.linalg.norm(shortest(low, high))))


@pytest.mark.filterwarnings("ignore:overflow")
@given(cases())
def test_whatever_is_asked_the_step_is_finite_inside_and_not_too_long(case):
    step, low, high, longest = case
    taken = Guard(longest or 1.0)(step, low, high)
    assert np.isfinite(taken).all()
    assert (taken >= low).all() and (taken <= high).all()
    assert np.linalg.norm(taken) <= (longest or 1.0) * (1 + 1e-12)


@given(cases(asked=unit))
def test_a_step_that_keeps_all_comes_out_to_the_bit(case):
    step, low, high, _ = case
    step = np.clip(step, low, high)
    guard = Guard(float(np.linalg.norm(step)) * (1 + 1e-9) + 1e-300)
    np.testing.assert_array_equal(guard(step, low, high), step)


@given(cases(asked=st.floats(-1e6, 1e6)))
def test_it_takes_no_step_twice(case):
    """What it lets through it lets through again."""
    step, low, high, longest = case
    guard = Guard(longest or 1.0)
    once = guard(step, low, high)
    np.testing.assert_allclose(guard(once, low, high), once, rtol=1e-12, atol=1e-300)


@given(st.floats(0.01, 0.9), st.integers(1, 9), st.integers(0, 10**6))
def test_where_joints_may_stand_still_the_direction_is_kept(longest, n, seed):
    step = np.random.default_rng(seed).normal(size=n)
    step *= 2.0 / np.linalg.norm(step)
    taken = Guard(longest)(step, np.full(n, -2.0), np.full(n, 2.0))
    np.testing.assert_allclose(taken, step * (0.5 * longest), rtol=1e-12)


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e101, 1e200])
def test_what_is_not_finite_is_no_step_or_a_brake(bad):
    guard = Guard(0.5)
    free, brake = np.array([-0.1, -0.1]), np.array([0.05, -0.1])
    step = np.array([0.01, bad])
    np.testing.assert_array_equal(guard(step, free, -free), [0.0, 0.0])
    np.testing.assert_array_equal(guard(step, brake, -free), [0.05, 0.0])


def test_limits_of_acceleration_come_before_the_length():
    low, high = np.array([0.3, 0.4]), np.array([1.0, 1.0])
    np.testing.assert_array_equal(Guard(0.2)(np.array([0.5, 0.5]), low, high), low)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, "0.5"])
def test_errors_name_the_bad_length(bad):
    with pytest.raises(ValueError, match="max_joint_step.*positive.*" + str(bad)):
        Guard(bad)
