"""Motion that leaves the task alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.null_space import (
    null_space_step,
    toward_manipulability,
    toward_middle,
    toward_posture,
)

IIWA = fd.load_arm("iiwa14")


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([1e-3, 1.0, 1e3]))
def test_the_task_is_undisturbed_at_any_rank_and_scale(seed, scale):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 7), rng.integers(1, 9)
    J = scale * rng.normal(size=(m, n))
    if seed % 3 == 0:
        J[-1] = J[0]  # singular
    if seed % 5 == 0:
        J[:, 0] = 0.0
    motion = rng.normal(size=n)
    free = null_space_step(J, motion)
    assert np.abs(J @ free).max() <= 1e-9 * scale * np.linalg.norm(motion)
    if seed % 5 == 0:
        assert free[0] == pytest.approx(motion[0], abs=1e-6)  # nothing of the task's


def test_what_the_law_does_is_not_free():
    """A step of the paper's law has no part that the projector of its own metric would keep."""
    J = IIWA.jacobian(np.array([0.2, 0.6, 0.1, -1.4, 0.3, 1.0, 0.0]))[3:, :6]
    step = fd.FuzzyMapping()(J, np.array([0.1, -0.2, 0.05]))
    assert np.abs(null_space_step(J, step)).max() < 1e-12


def test_not_finite_is_no_motion():
    J = np.ones((2, 3))
    assert not null_space_step(J * np.nan, np.ones(3)).any()
    for bad in (np.nan, np.inf, 1e156):  # whose square is not finite: no motion that anybody means
        assert not null_space_step(J, np.array([bad, 0.0, 0.0])).any()
    np.testing.assert_array_equal(null_space_step(np.zeros((2, 3)), np.ones(3)), np.ones(3))


def wander(objective, q, cycles=400):
    for _ in range(cycles):
        J = IIWA.jacobian(q)[3:]
        q = q + null_space_step(J, 0.01 * objective(q))
    return q


def test_posture_and_middle_are_approached_with_the_tool_in_place():
    start = np.array([0.5, 0.8, 1.2, -1.6, 0.5, 1.9, 2.5])
    tool = IIWA.forward_kinematics(start)[:3, 3]
    posture = np.zeros(7)
    nearer = wander(toward_posture(posture, 1.0), start)
    assert np.linalg.norm(nearer - posture) < 0.9 * np.linalg.norm(start - posture)
    middle = wander(toward_middle(IIWA.lower, IIWA.upper, 4.0), start)
    cost = [np.sum((q / IIWA.upper) ** 4) for q in (start, middle)]
    assert cost[1] < 0.7 * cost[0]
    for q in (nearer, middle):
        assert np.linalg.norm(IIWA.forward_kinematics(q)[:3, 3] - tool) < 2e-3


def test_manipulability_rises():
    def jacobian(q):
        return IIWA.jacobian(q)[3:]

    def size(q):
        return np.sqrt(np.linalg.det(jacobian(q) @ jacobian(q).T))

    rng, gains = np.random.default_rng(0), []
    for start in rng.uniform(0.6 * IIWA.lower, 0.6 * IIWA.upper, (5, 7)):
        end = wander(toward_manipulability(jacobian, 0.5), start, cycles=60)
        gains.append(size(end) / size(start))
    assert min(gains) > 0.999 and np.mean(gains) > 1.02


def test_a_joint_without_limits_is_left_alone():
    wish = toward_middle(np.array([-np.inf, -1.0]), np.array([np.inf, 3.0]), 1.0)
    np.testing.assert_allclose(wish(np.array([5.0, 3.0])), [0.0, -2.0])
