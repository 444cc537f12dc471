"""Inference against equations 4.2-4.5 of Hassantabar (2021) taken literally; derivatives by differences."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy.anfis.membership_kinds import KINDS
from fikm_drake.fuzzy.anfis.network import Network
from fikm_drake.fuzzy.anfis.projection import LeastSquares

CASES = list(itertools.product(KINDS, (0, 1), ((3,), (3, 4), (2, 3, 2))))


def random_network(kind, order, counts, rng):
    start = [KINDS[kind].start(m) for m in counts]
    premises = tuple(p + rng.normal(0.0, 0.2, p.shape) for p in start)
    return Network(KINDS[kind], premises, order)


def grade(kind, x, parameters):
    """A membership as the papers write it."""
    center, width = parameters[0], np.exp(parameters[1])
    if kind == "gaussian":
        return np.exp(-((x - center) ** 2) / (2.0 * width**2))
    return 1.0 / (1.0 + abs((x - center) / width) ** (2.0 * np.exp(parameters[2])))


def output_by_rules(kind, network, x, coefficients):
    """The weighted average of all rules, one rule after the other."""
    terms = [1.0, *x][: network.num_terms]
    table = coefficients.reshape(*network.shape, network.num_terms)
    above = below = 0.0
    for rule in np.ndindex(network.shape):
        truth = 1.0
        for value, premise, i in zip(x, network.premises, rule):
            truth *= grade(kind, value, premise[:, i])
        above += truth * float(table[rule] @ terms)
        below += truth
    return above / below


@pytest.mark.parametrize(("kind", "order", "counts"), CASES)
def test_output_is_the_weighted_average_of_all_rules(kind, order, counts):
    rng = np.random.default_rng(0)
    network = random_network(kind, order, counts, rng)
    x = rng.uniform(-1, 1, (len(counts), 20))
    coefficients = rng.normal(size=network.num_coefficients)
    expected = [output_by_rules(kind, network, column, coefficients) for column in x.T]
    np.testing.assert_allclose(network.output(x, coefficients), expected, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(coefficients @ network.regressors(x), expected, atol=1e-10)
    np.testing.assert_allclose(network.output_and_slopes(x, coefficients)[0], expected, atol=1e-10)


@pytest.mark.parametrize(("kind", "order", "counts"), CASES)
def test_slopes_are_finite_differences(kind, order, counts):
    rng = np.random.default_rng(1)
    network = random_network(kind, order, counts, rng)
    x = rng.uniform(-1, 1, (len(counts), 15))
    coefficients = rng.normal(size=network.num_coefficients)
    slopes = network.output_and_slopes(x, coefficients)[1]
    h = 1e-6
    for slope, step in zip(slopes, h * np.eye(network.parameters.size)):
        ahead = network.with_parameters(network.parameters + step).output(x, coefficients)
        behind = network.with_parameters(network.parameters - step).output(x, coefficients)
        np.testing.assert_allclose(slope, (ahead - behind) / (2 * h), rtol=1e-6, atol=1e-8)


@given(st.sampled_from(list(KINDS)), st.integers(1, 9), st.floats(-1.1, 1.1))
def test_shares_sum_to_one_however_narrow_the_memberships_are(kind, count, value):
    parameters = KINDS[kind].start(count)
    parameters[1] -= 8.0  # a hundred thousand times narrower: each grade alone underflows
    network = Network(KINDS[kind], (parameters,), 0)
    (shares,) = network.shares(np.array([[value]]))
    assert np.isfinite(shares).all()
    assert shares.sum() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_neighbours_cross_at_one_half_at_the_start(kind):
    parameters = KINDS[kind].start(5)
    np.testing.assert_allclose(parameters[0], [-1.0, -0.5, 0.0, 0.5, 1.0])
    between = KINDS[kind].log_grades(np.array([-0.75, 0.25]), parameters)
    np.testing.assert_allclose(np.exp(between)[[0, 1], 0], 0.5)
    np.testing.assert_allclose(np.exp(between)[[2, 3], 1], 0.5)


@pytest.mark.parametrize(
    "count, shape, order, ridge",
    [
        (150, (3, 3), 1, 1e-8),
        (50_000, (3, 3), 1, 1e-8),
        (900, (8, 8), 1, 1e-12),
        (900, (4, 2, 3), 1, 1e-10),
        (300, (5,), 0, 1e-8),
        (900, (8, 8), 1, 1e-17),
    ],
)
def test_project_is_ridge_regression(count, shape, order, ridge):
    """Against numpy's own least squares, in one block of rows and in many; squared, and where that fails."""
    rng = np.random.default_rng(2)
    network = random_network("gaussian", order, shape, rng)
    x = rng.uniform(-1, 1, (len(shape), count))
    y = np.sin(3 * x[0]) * x[-1]
    found = LeastSquares(x, y, ridge).project(network)
    assert (found.inverse is None) == (ridge < 1e-15)
    A = np.concatenate(
        [network.regressors(x).T, np.sqrt(ridge * count) * np.eye(network.num_coefficients)]
    )
    b = np.concatenate([y, np.zeros(network.num_coefficients)])
    expected, squares, *_ = np.linalg.lstsq(A, b, rcond=None)
    np.testing.assert_allclose(found.coefficients, expected, rtol=1e-6, atol=1e-8)
    assert found.objective == pytest.approx(float(squares[0]), rel=1e-9)


@pytest.mark.parametrize("ridge", [1e-10, 1e-16])
def test_linearise_predicts_the_objective_and_its_gradient(ridge):
    """To first order, the projected objective falls as |b|² − |b − A δ|² says."""
    rng = np.random.default_rng(3)
    network = random_network("gaussian", 1, (3, 3), rng)
    x = rng.uniform(-1, 1, (2, 400))
    data = LeastSquares(x, np.exp(-3 * x[0] ** 2) + x[1] ** 3, ridge)
    best = data.project(network)
    A, b = data.linearise(network, best)
    gradient = data.gradient(network, best.coefficients)
    np.testing.assert_allclose(-A.T @ b, gradient, rtol=1e-5, atol=1e-9)
    h = 1e-5
    for direction in np.eye(network.parameters.size)[::3]:
        ends = [
            data.project(network.with_parameters(network.parameters + s * h * direction)).objective
            for s in (1.0, -1.0)
        ]
        slope = (ends[0] - ends[1]) / (2 * h)
        assert slope == pytest.approx(2 * float(gradient @ direction), rel=1e-4, abs=1e-7)
