"""Laws past the paper: conjugate gradients, damping, floors, and the ordinary alternatives."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.laws.conjugate_gradients import conjugate_gradients

SHARP = fd.FuzzyIkConfig().resolved_rate()
LAWS = [
    fd.FuzzyMapping(),
    fd.FuzzyMapping(iterations=3),
    fd.FuzzyMapping(iterations=2, damping=0.1, row_floor=0.05, column_floor=0.05),
    fd.DampedLeastSquares(),
    fd.PseudoInverse(),
    fd.JacobianTranspose(),
    fd.FuzzyRateControl(),
    fd.FuzzyRateControl("paper", sweeps=2),
]


def matrices(seed, shape=(3, 7)):
    rng = np.random.default_rng(seed)
    return rng.normal(size=shape), rng.normal(size=shape[:-1])


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.01, 0.1, 1.0]))
def test_as_many_iterations_as_rows_solve_damped_least_squares(seed, damping):
    S, b = matrices(seed)
    exact = S.T @ np.linalg.solve(S @ S.T + damping**2 * np.eye(3), b)
    assert conjugate_gradients(S, b, 3, damping) == pytest.approx(exact, rel=1e-6, abs=1e-9)


@given(st.integers(0, 10**6))
def test_each_iteration_lowers_the_residual(seed):
    S, b = matrices(seed, (6, 7))
    residuals = [np.linalg.norm(S @ conjugate_gradients(S, b, k) - b) for k in range(1, 7)]
    assert all(b <= a + 1e-9 for a, b in zip(residuals, residuals[1:]))
    assert residuals[0] < np.linalg.norm(b)


def test_nothing_to_solve_gives_zeros():
    S, b = matrices(0)
    assert not conjugate_gradients(S, np.zeros(3), 5).any()
    assert not conjugate_gradients(np.zeros((3, 7)), b, 5, 0.1).any()


@given(st.integers(0, 10**6))
def test_full_iterations_reach_the_weighted_pseudo_inverse(seed):
    """Least of all exact steps in the norm of the column sums."""
    J, dr = matrices(seed)
    step = fd.FuzzyMapping(iterations=3)(J, dr)
    assert J @ step == pytest.approx(dr, abs=1e-7)
    C = np.diag(np.abs(J).sum(axis=0))
    other = np.linalg.pinv(J @ np.linalg.inv(C) @ J.T)
    assert step == pytest.approx(np.linalg.inv(C) @ J.T @ other @ dr, rel=1e-5, abs=1e-8)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_batch_equals_one_by_one(law):
    rng = np.random.default_rng(1)
    J, dr = rng.normal(size=(4, 5, 3, 7)), rng.normal(size=(4, 5, 3))
    steps = law(J, dr)
    assert steps.shape == (4, 5, 7)
    for i in range(4):
        for k in range(5):
            assert law.step(J[i, k], dr[i, k]) == pytest.approx(steps[i, k], abs=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_every_law_moves_the_arm_to_the_target(law):
    scenario = fd.TrackingScenario(
        arm="arm7", waypoints=[[0.3, -0.5, 0.5]], hold=4.0, initial_position=[0.1] * 7
    )
    for fused in (False, True):
        config = dataclasses.replace(SHARP, fused=fused)
        log = fd.simulate(scenario.with_config(config), law=law)
        assert log.metrics().e_ss < 1e-4


@pytest.mark.parametrize(("seconds", "limit"), [(10, 0.002), (5, 0.006), (2, 0.04)])
def test_three_iterations_reach_the_pseudo_inverses_floor_on_table_6(seconds, limit):
    config = dataclasses.replace(SHARP, law=fd.FuzzyMapping(iterations=3))
    log = fd.simulate(fd.load_scenario(f"table6_{seconds}s").with_config(config))
    assert 100 * log.metrics().e_max <= limit


def column_through_zero(law):
    """Joint steps while the only element of column 1 goes through zero."""
    values = np.linspace(-1e-3, 1e-3, 2001)
    J = np.tile(np.array([[1.0, 0.0], [0.3, 0.0]]), (2001, 1, 1))
    J[:, 0, 1] = values
    return law(J, np.array([0.05, 0.0]))[:, 1]


def test_the_papers_law_jumps_where_a_column_goes_through_zero():
    step = column_through_zero(fd.FuzzyMapping())
    assert np.abs(np.diff(step)).max() > 0.04


@pytest.mark.parametrize("options", [{}, {"iterations": 2, "damping": 0.1}])
def test_a_column_floor_makes_it_smooth(options):
    step = column_through_zero(fd.FuzzyMapping(column_floor=0.05, **options))
    assert np.abs(np.diff(step)).max() < 1e-4
    assert step == pytest.approx(-step[::-1], abs=1e-12)


@settings(max_examples=50)
@given(st.floats(1e-8, 0.05))
def test_a_row_floor_makes_a_vanishing_row_push_in_proportion(size):
    J = np.array([[1.0, 0.8], [size, 0.5 * size]])
    dr = np.array([0.0, 0.1])
    bang = np.abs(fd.FuzzyMapping()(J, dr)).max()
    calm = np.abs(fd.FuzzyMapping(row_floor=0.05)(J, dr)).max()
    assert bang > 0.02  # whatever the size of the row
    assert calm <= 1.2 * size


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.floats(0.1, 5.0), st.sampled_from([2, 6]))
def test_error_damping_is_damping_by_the_turn_that_the_error_asks_for(seed, kappa, iterations):
    rng = np.random.default_rng(seed)
    J, dr = rng.normal(size=(3, 5)), 0.3 * rng.normal(size=3)
    turn = np.linalg.norm(dr / np.abs(J).sum(axis=1))
    damping = float(np.hypot(0.1, min(kappa * turn, 1.0)))
    plain = fd.FuzzyMapping(iterations=iterations, damping=damping)
    grown = fd.FuzzyMapping(iterations=iterations, damping=0.1, error_damping=kappa)
    np.testing.assert_allclose(grown.step(J, dr), plain.step(J, dr), rtol=1e-10, atol=1e-14)
    several = grown(np.stack([J, 2.0 * J]), np.stack([dr, 0.1 * dr]))
    expected = [grown.step(J, dr), grown.step(2.0 * J, 0.1 * dr)]
    np.testing.assert_allclose(several, expected, rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"iterations": 0}, "iterations"),
        ({"iterations": 1.5}, "iterations"),
        ({"damping": -0.1, "iterations": 3}, "damping"),
        ({"damping": 0.1}, "iterations of 2"),
        ({"error_damping": 3.0}, "error_damping needs iterations of 2"),
        ({"error_damping": -1.0, "iterations": 3}, "error_damping"),
        ({"row_floor": float("nan")}, "row_floor"),
        ({"column_floor": -1.0}, "column_floor"),
        ({"method": "direct", "iterations": 2, "jacobian_range": 1.5}, "indirect"),
    ],
)
def test_bad_arguments_of_the_mapping(arguments, words):
    with pytest.raises(ValueError, match=words):
        fd.FuzzyMapping(**arguments)


def test_bad_arguments_of_the_others():
    with pytest.raises(ValueError, match="damping"):
        fd.DampedLeastSquares(0.0)
    with pytest.raises(ValueError, match="cutoff"):
        fd.PseudoInverse(1.0)
