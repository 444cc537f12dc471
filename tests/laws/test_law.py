"""What every law shares: shapes that fit, and no motion where nothing can be done."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.laws.law import as_arrays

LAWS = {
    "indirect": fd.FuzzyMapping(),
    "direct": fd.FuzzyMapping("direct", jacobian_range=5.0),
    "iterations": fd.FuzzyMapping(iterations=3, damping=0.1),
    "damped least squares": fd.DampedLeastSquares(),
    "pseudo-inverse": fd.PseudoInverse(),
    "transpose": fd.JacobianTranspose(),
    "smooth": fd.FuzzyRateControl(),
    "paper": fd.FuzzyRateControl("paper", sweeps=2),
}
J = np.random.default_rng(0).normal(size=(3, 7))
DR = np.array([0.01, 0.02, -0.03])


@pytest.fixture(params=LAWS)
def law(request):
    return LAWS[request.param]


@pytest.mark.parametrize(
    ("J", "dr"),
    [(J.T, DR), (J[0], DR), (J, DR[:2]), (J, 1.0), (J[:0], DR[:0]), (J[:, :0], DR), (None, None)],
)
def test_shapes_that_do_not_fit_are_named(law, J, dr):
    with pytest.raises(ValueError) as error:
        law(J, dr)
    assert str(np.shape(J)) in str(error.value) and str(np.shape(dr)) in str(error.value)


def test_lists_integers_and_read_only_arrays_are_taken(law):
    np.testing.assert_array_equal(law(J.tolist(), DR.tolist()), law(J, DR))
    ones = np.ones((3, 7), dtype=np.int32)
    np.testing.assert_array_equal(law(ones, [1, 0, 0]), law(1.0 * ones, [1.0, 0.0, 0.0]))
    fixed_J, fixed_dr = J.copy(), DR.copy()
    fixed_J.flags.writeable = fixed_dr.flags.writeable = False
    np.testing.assert_allclose(law.step(fixed_J, fixed_dr), law(J, DR), rtol=0, atol=1e-15)


def test_batches_broadcast_and_may_be_empty(law):
    both = law(np.stack([J, 2 * J]), DR)
    np.testing.assert_allclose(both, [law(J, DR), law(2 * J, DR)], rtol=1e-12)
    assert law(np.empty((0, 3, 7)), np.empty((0, 3))).shape == (0, 7)


def test_an_arm_that_cannot_move_does_not(law):
    for step in (law, law.step):
        np.testing.assert_array_equal(step(0.0 * J, DR), np.zeros(7))


def test_arrays_that_fit_are_not_copied():
    found = as_arrays(J, DR)
    assert found[0] is J and found[1] is DR
