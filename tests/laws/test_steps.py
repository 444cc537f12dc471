"""The small steps of a control cycle against the paper's equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.laws.controller_status import ControllerStatus, controller_status
from fikm_drake.laws.steps import all_finite, amplify, integrate, is_limited, length, low_pass

vectors = hnp.arrays(float, 4, elements=st.floats(-10, 10))


@given(vectors, vectors)
def test_low_pass_is_equations_30_and_31(value, previous):
    expected = value / 3 + 2 / 3 * previous
    np.testing.assert_allclose(low_pass(value, previous, 2 / 3), expected, atol=1e-14)
    scalar = low_pass(float(value[0]), float(previous[0]), 2 / 3)
    assert scalar == pytest.approx(expected[0], abs=1e-14)


def test_low_pass_answers_a_step_geometrically():
    y, answers = 0.0, []
    for _ in range(30):
        y = low_pass(1.0, y, 2 / 3)
        answers.append(y)
    np.testing.assert_allclose(answers, 1 - (2 / 3) ** np.arange(1, 31), atol=1e-15)
    assert low_pass(5.0, 1.0, 0.0) == 5.0


@given(vectors, st.floats(0, 5), st.floats(0.01, 20))
def test_amplify_keeps_the_direction_and_bounds_the_length(error, gain, limit):
    size = length(error)
    amplified = amplify(gain, error, size, limit)
    expected = gain * error * min(1.0, limit / size if size else 1.0)
    np.testing.assert_allclose(amplified, expected, rtol=1e-12, atol=1e-12)
    assert length(amplified) <= gain * limit * (1 + 1e-12)


def test_amplify_without_a_limit_is_the_gain():
    np.testing.assert_allclose(amplify(2.6, np.array([3.0, 4.0]), 5.0, np.inf), [7.8, 10.4])


@given(vectors, vectors, vectors, vectors)
def test_integrate_keeps_the_limits_and_loses_nothing_inside(a, b, fraction, step):
    lower, upper = np.minimum(a, b) - 0.1, np.maximum(a, b) + 0.1
    position = lower + np.abs(fraction) / 10 * (upper - lower)
    after = integrate(position, step, lower, upper)
    assert (after >= lower).all() and (after <= upper).all()
    inside = (position + step >= lower) & (position + step <= upper)
    np.testing.assert_array_equal(after[inside], (position + step)[inside])
    assert is_limited(position, step, lower, upper) == (not inside.all())


def test_integrate_without_limits_is_addition():
    infinite = np.full(2, np.inf)
    np.testing.assert_array_equal(
        integrate(np.ones(2), 1e9 * np.ones(2), -infinite, infinite), 1 + 1e9
    )


@given(vectors)
def test_length_is_the_euclidean_norm(vector):
    assert length(vector) == pytest.approx(np.linalg.norm(vector), abs=1e-150, rel=1e-12)
    assert all_finite(vector)


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_what_is_not_finite_is_seen(bad):
    vector = np.array([1.0, bad, 0.0])
    assert not all_finite(vector)
    assert not np.isfinite(length(vector))


def test_status_is_the_first_that_holds():
    """Invalid before converged before limited before oscillating before tracking."""
    everything = dict(valid=False, error=0.0, tolerance=1e-3, limited=True, oscillating=True)
    order = []
    for change in ({"valid": True}, {"error": 1.0}, {"limited": False}, {"oscillating": False}, {}):
        order.append(controller_status(**everything).name)
        everything |= change
    assert order == ["INVALID_INPUT", "CONVERGED", "LIMITED", "OSCILLATING", "TRACKING"]
    assert len({int(status) for status in ControllerStatus}) == 5
    assert (
        controller_status(valid=True, error=1e-3, tolerance=1e-3, limited=False, oscillating=False)
        == ControllerStatus.CONVERGED
    )
