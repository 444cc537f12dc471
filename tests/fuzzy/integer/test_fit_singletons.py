"""Singletons by least squares."""

import numpy as np
import pytest

from fikm_drake.fuzzy.integer import IntegerPartition, cell_weights, fit_singletons, interpolate
from fikm_drake.fuzzy.integer.integer_rule_base import CONJUNCTIONS

FIRST, SECOND = IntegerPartition([0, 90, 400]), IntegerPartition([0, 100, 200, 300])
POINTS = np.random.default_rng(0).uniform(0, [400, 300], (500, 2))


@pytest.mark.parametrize("conjunction", CONJUNCTIONS)
def test_finds_the_singletons_that_made_the_data(conjunction):
    singletons = np.random.default_rng(1).normal(size=(3, 4, 2))
    data = interpolate(FIRST, SECOND, singletons, POINTS, conjunction)
    fitted = fit_singletons(FIRST, SECOND, POINTS, data, conjunction)
    np.testing.assert_allclose(fitted, singletons, atol=1e-9)


@pytest.mark.parametrize("conjunction", CONJUNCTIONS)
def test_is_the_dense_least_squares_solution(conjunction):
    data = np.sin(POINTS / 100)
    rules, weights = cell_weights(FIRST, SECOND, POINTS, conjunction)
    A = np.zeros((len(POINTS), 12))
    np.put_along_axis(A, rules, weights, axis=1)
    expected = np.linalg.lstsq(A, data, rcond=None)[0].reshape(3, 4, 2)
    fitted = fit_singletons(FIRST, SECOND, POINTS, data, conjunction)
    np.testing.assert_allclose(fitted, expected, atol=1e-9)


def test_product_interpolates_bilinear_functions_exactly():
    knots = np.stack(np.meshgrid(FIRST.knots, SECOND.knots, indexing="ij"), axis=-1)

    def f(p):
        return (1 + 2 * p[..., :1]) * (3 - p[..., 1:])

    values = interpolate(FIRST, SECOND, f(knots), POINTS, "product")
    np.testing.assert_allclose(values, f(POINTS), rtol=1e-12, atol=1e-9)


def test_data_that_leave_singletons_open():
    corner = POINTS[POINTS[:, 0] < 90]
    with pytest.raises(ValueError, match="of the 12 singletons; take fewer labels or more points"):
        fit_singletons(FIRST, SECOND, corner, corner, "product")
