"""The small steps of a control cycle against the paper's equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.arrays import all_finite
from fikm_drake.control.restart_state import RestartState
from fikm_drake.control.status import ControllerStatus, controller_status
from fikm_drake.control.steps import amplify, length, low_pass

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
    """Invalid, converged, what the detour does, oscillating, calmed, limited, tracking."""
    everything = dict(
        valid=False,
        error=0.0,
        tolerance=1e-3,
        limited=True,
        oscillating=True,
        calmed=True,
        restart_search=RestartState.UNDERWAY,
        following=False,
    )
    changes = [
        {"valid": True},
        {"following": True},
        {"error": 1.0},
        {"restart_search": RestartState.NONE},
        {"oscillating": False},
        {"calmed": False},
        {"limited": False},
        {},
    ]
    order = []
    for change in changes:
        order.append(controller_status(**everything).name)
        everything |= change
    expected = "INVALID_INPUT NOT_FOLLOWING CONVERGED RESTART_SEARCH OSCILLATING CALMED LIMITED"
    assert order == [*expected.split(), "TRACKING"]
    assert len({int(status) for status in ControllerStatus}) == len(ControllerStatus)
    everything |= {"error": 1e-3}
    assert controller_status(**everything) == ControllerStatus.CONVERGED


@pytest.mark.parametrize(
    ("state", "status"),
    [
        (RestartState.NONE, ControllerStatus.TRACKING),
        (RestartState.SEARCHING, ControllerStatus.RESTART_SEARCH),
        (RestartState.UNDERWAY, ControllerStatus.RESTART_SEARCH),
        (RestartState.STUCK, ControllerStatus.STUCK),
    ],
)
def test_status_of_each_state_of_a_restart(state, status):
    quiet = dict(valid=True, error=1.0, tolerance=1e-3, limited=False, oscillating=False)
    assert controller_status(**quiet, restart_search=state) == status
    assert controller_status(**quiet) == ControllerStatus.TRACKING
    lost = quiet | {"valid": False}
    assert controller_status(**lost, restart_search=state) == ControllerStatus.INVALID_INPUT
