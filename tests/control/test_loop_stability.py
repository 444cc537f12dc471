"""The bounds of the gain with a frozen Jacobian, against the loop itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import fikm_drake as fd
from fikm_drake.control.loop_stability import (
    convergence_factor,
    largest_stable_gain,
    loop_matrix,
    task_matrix,
)

SMOOTHING = [0.0, 0.3, 2.0 / 3.0, 0.9]
JACOBIANS = st.tuples(st.integers(1, 6), st.integers(1, 9)).flatmap(
    lambda shape: hnp.arrays(float, shape, elements=st.floats(-10, 10, allow_subnormal=False))
)


def run(J, gain, smoothing, cycles, error):
    """The error after each cycle of the loop as it is in the controller, J frozen."""
    law, filtered, errors = fd.FuzzyMapping(), np.zeros(len(J)), []
    for _ in range(cycles):
        filtered = smoothing * filtered + (1.0 - smoothing) * gain * error
        error = error - J @ law(J, filtered)
        errors.append(np.linalg.norm(error))
    return np.array(errors)


def radius(matrix):
    return np.abs(np.linalg.eigvals(matrix)).max()


@given(J=JACOBIANS)
def test_eigenvalues_are_between_0_and_1(J):
    """The Schur test: ‖R^-½ J C^-½‖₂ ≤ 1 for the absolute row and column sums R and C."""
    values = np.linalg.eigvals(task_matrix(fd.FuzzyMapping(), J))
    assert np.abs(values.imag).max() < 1e-7
    assert -1e-7 < values.real.min() and values.real.max() < 1.0 + 1e-7


def test_bounds_of_the_paper():
    """K < 2 without the filter; 10 with the filter of 2/3; 1 if the joints are a cycle late."""
    assert largest_stable_gain(0.0) == pytest.approx(2.0)
    assert largest_stable_gain(2.0 / 3.0) == pytest.approx(10.0)
    assert [largest_stable_gain(s, delay=1) for s in SMOOTHING] == pytest.approx([1.0] * 4)
    # Without a filter e' = e − x e delayed by two is stable below the golden ratio's inverse.
    assert largest_stable_gain(0.0, delay=2) == pytest.approx(0.5 * (np.sqrt(5.0) - 1.0))


@given(loop_gain=st.floats(0.01, 15.0), smoothing=st.sampled_from(SMOOTHING))
def test_roots_are_the_loops_eigenvalues(loop_gain, smoothing):
    """For a task of one row λ = 1, so that λK = K."""
    factor = float(convergence_factor(loop_gain, smoothing))
    assert radius(loop_matrix([[1.0]], loop_gain, smoothing)) == pytest.approx(factor, rel=1e-6)


def test_the_paper_s_filter_converges_no_faster_than_the_root_of_two_thirds():
    """z² − (5/3 − λK/3) z + 2/3: the roots' product is 2/3, and a pair of one size is best."""
    factors = convergence_factor(np.linspace(0.01, 9.99, 500), 2.0 / 3.0)
    assert factors.min() == pytest.approx(np.sqrt(2.0 / 3.0))
    assert (factors < 1.0).all()
    assert factors[0] > 0.98 and factors[-1] > 0.98


@pytest.mark.parametrize("smoothing", SMOOTHING)
@pytest.mark.parametrize("rows", [2, 3, 6])
def test_random_arms_are_stable_below_the_bound_and_not_above(smoothing, rows):
    rng = np.random.default_rng(rows)
    bound = largest_stable_gain(smoothing)
    for _ in range(50):
        J = rng.normal(size=(rows, rng.integers(rows, 10)))
        A = task_matrix(fd.FuzzyMapping(), J)
        largest = np.linalg.eigvals(A).real.max()
        assert radius(loop_matrix(A, 0.999 * bound / largest, smoothing)) < 1.0
        assert radius(loop_matrix(A, 1.001 * bound / largest, smoothing)) > 1.0


@pytest.mark.parametrize(("smoothing", "gain"), [(0.0, 1.99), (2.0 / 3.0, 2.6), (2.0 / 3.0, 9.9)])
def test_these_gains_converge_for_every_arm(smoothing, gain):
    """Table I's largest, 2.6, needs the filter; with it there is room to spare."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        J = rng.normal(size=(3, 7))
        errors = run(J, gain, smoothing, 3000, rng.normal(size=3))
        assert errors[-1] < 1e-2 * errors[0]


def test_table_1_s_largest_gain_diverges_without_the_filter():
    J = fd.load_arm("arm7").jacobian(np.full(7, 0.3))[3:]
    assert np.linalg.eigvals(task_matrix(fd.FuzzyMapping(), J)).real.max() > 2.0 / 2.6
    assert run(J, 2.6, 0.0, 200, np.full(3, 0.01))[-1] > 1e3
    assert run(J, 2.6, 2.0 / 3.0, 200, np.full(3, 0.01))[-1] < 1e-6


@pytest.mark.parametrize("smoothing", SMOOTHING)
def test_the_error_falls_by_the_convergence_factor(smoothing):
    """Over many cycles, for λ = 1."""
    loop_gain = 0.5
    errors = run(np.array([[1.0, 2.0]]), loop_gain, smoothing, 400, np.ones(1))
    errors = errors[errors > 1e-12]
    rate = (errors[-1] / errors[0]) ** (1.0 / (len(errors) - 1))
    assert rate == pytest.approx(float(convergence_factor(loop_gain, smoothing)), abs=0.02)
