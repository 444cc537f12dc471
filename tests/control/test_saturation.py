"""A joint at its bound is fixed, and the others do what it may not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.saturation import brake, resolve

LAWS = {
    "fuzzy": fd.FuzzyMapping(),
    "conjugate gradients": fd.FuzzyMapping(iterations=6, damping=1e-3),
    "damped": fd.DampedLeastSquares(0.02),
    "pinv": fd.PseudoInverse(),
    "rate": fd.FuzzyRateControl(),
    "transpose": fd.JacobianTranspose(),
}


def problem(seed, m=3, n=7, slow=0.3):
    """J, error and bounds; a share `slow` of the joints may move a hundredth only."""
    rng = np.random.default_rng(seed)
    J, error = rng.normal(size=(m, n)), 0.1 * rng.normal(size=m)
    most = np.where(rng.random(n) < slow, 1e-4, 1e-2) * rng.uniform(0.5, 2.0, n)
    return J, error, -most, most


def shortened(step, high):
    return step / max(1.0, float((np.abs(step) / high).max()))


def left(J, error, step):
    return np.linalg.norm(error - J @ step)


@pytest.mark.parametrize("name", LAWS)
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), m=st.integers(1, 6), n=st.integers(1, 60))
def test_it_is_inside_and_no_farther_than_the_shortened_step(name, seed, m, n):
    law = LAWS[name]
    J, error, low, high = problem(seed, m, n)
    step = law.step(J, error)
    short = shortened(step, high)
    taken = resolve(law.step, J, error, step, low, high, shortened=short)
    assert (taken >= low).all() and (taken <= high).all()
    asked = J @ step
    assert left(J, asked, taken) <= left(J, asked, short) * (1 + 1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_a_step_inside_is_the_law_s(name):
    J, error, low, high = problem(3)
    step = LAWS[name].step(J, 1e-4 * error)
    assert resolve(LAWS[name].step, J, error, step, 1e3 * low, 1e3 * high) is step


def test_one_slow_joint_takes_nothing_from_the_tool():
    """Six joints can do three rows without the seventh: the error is solved as if it had no limit."""
    law = LAWS["pinv"]
    for seed in range(20):
        J, error, _, _ = problem(seed)
        high = np.full(7, 1e3)
        high[2] = 1e-5
        step = law.step(J, error)
        assert left(J, error, shortened(step, high)) > 0.5 * np.linalg.norm(error)
        taken = resolve(law.step, J, error, step, -high, high, shortened=shortened(step, high))
        assert left(J, error, taken) < 1e-9 and abs(taken[2]) == 1e-5


def test_it_comes_near_the_best_that_bounds_allow():
    """Of what projected gradients gain, run to the end: 80 % on average at the least."""
    ratios = []
    for seed in range(20):
        J, error, low, high = problem(seed)
        step = LAWS["pinv"].step(J, error)
        short = shortened(step, high)
        taken = resolve(LAWS["pinv"].step, J, error, step, low, high, shortened=short)
        best, rate = np.zeros(7), 1.0 / np.linalg.norm(J, 2) ** 2
        for _ in range(1000):
            best = np.clip(best + rate * J.T @ (error - J @ best), low, high)
        size = np.linalg.norm(error)
        ratios.append((size - left(J, error, taken)) / (size - left(J, error, best)))
    assert np.mean(ratios) > 0.8


def test_where_nothing_is_gained_the_direction_is_kept():
    """Two joints for two rows, both too slow in proportion: fixing one gains nothing for the other."""
    J, error = np.eye(2), np.array([0.1, 0.1])
    high = np.array([0.02, 0.02])
    step = LAWS["pinv"].step(J, error)
    taken = resolve(LAWS["pinv"].step, J, error, step, -high, high, shortened=shortened(step, high))
    np.testing.assert_allclose(taken, [0.02, 0.02])


def test_bounds_that_leave_no_rest_are_kept():
    """With limits of acceleration a joint may have to go on."""
    J, error, _, _ = problem(1)
    low, high = np.full(7, -1.0), np.full(7, 1.0)
    low[3] = high[3] = 0.05
    step = LAWS["pinv"].step(J, error)
    taken = resolve(LAWS["pinv"].step, J, error, step, low, high)
    assert taken[3] == 0.05 and left(J, error, taken) < 1e-9


def braking(hard):
    """Limits of acceleration only: `hard` (n,) is how much a step may change in a cycle."""
    free = np.full(len(hard), np.inf)
    return JointLimits(-free, free, period=1.0, acceleration_limits=hard)


def test_a_joint_that_brakes_slowly_leaves_the_motion_to_the_others():
    """Six joints do three rows without it; it gets what it can brake in the cycle that they take."""
    law = LAWS["pinv"]
    for seed in range(20):
        J, error, _, _ = problem(seed)
        limits = braking(np.where(np.arange(7) == 2, 1e-6, np.inf))
        step = law.step(J, error)
        assert left(J, error, limits.brakeable(step)) > 0.5 * np.linalg.norm(error)
        taken = brake(law.step, J, error, step, limits)
        assert left(J, error, taken) < 1e-9
        assert abs(taken[2]) <= 1e-6 and taken[2] * step[2] > 0.0


@pytest.mark.parametrize("name", LAWS)
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 20))
def test_what_is_to_be_braked_can_be_and_is_no_farther_than_the_shortened_step(name, seed, n):
    rng, law = np.random.default_rng(seed), LAWS[name]
    J, error, _, _ = problem(seed, 3, n)
    limits = braking(10.0 ** rng.uniform(-6.0, -2.0, n))
    step = law.step(J, error)
    taken, kept = brake(law.step, J, error, step, limits), limits.brakeable(step)
    assert np.isfinite(taken).all()
    assert left(J, J @ step, taken) <= left(J, J @ step, kept) * (1 + 1e-12)
    if limits.brakeable(step) is step:
        assert taken is step


def test_free_joints_keep_their_null_space_motion():
    J, error, _, _ = problem(5)
    law, high = LAWS["pinv"], np.full(7, 10.0)
    high[0] = 1e-4
    secondary = np.random.default_rng(5).normal(size=7)
    secondary -= np.linalg.pinv(J) @ J @ secondary
    step = law.step(J, error) + secondary
    taken = resolve(law.step, J, error, step, -high, high, secondary=secondary)
    assert left(J, error, taken) < 1e-9
    rest = taken - secondary
    rest[0] = 0.0  # what is left is the law's shortest for the free joints
    free = J[:, 1:]
    np.testing.assert_allclose(np.linalg.pinv(free) @ free @ rest[1:], rest[1:], atol=1e-9)


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid")
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
def test_a_law_that_fails_the_second_time_leaves_the_first_answer(bad):
    J, error, low, high = problem(2)
    step = LAWS["pinv"].step(J, error)
    short = shortened(step, high)
    taken = resolve(lambda *_: np.full(7, bad), J, error, step, low, high, shortened=short)
    np.testing.assert_array_equal(taken, short)
