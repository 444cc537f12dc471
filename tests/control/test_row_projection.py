"""The projection onto inequalities, against what it is defined by."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fikm_drake.control.row_projection import project, task_metric


def random_case(seed):
    rng = np.random.default_rng(seed)
    k, n = rng.integers(1, 9), rng.integers(2, 8)
    rows = rng.normal(size=(k, n))
    inside = rng.normal(size=n)  # keeps all rows, so that they do not contradict one another
    bounds = rows @ inside - rng.uniform(0.0, 1.0, k)
    return rng.normal(size=n) * 3.0, rows, bounds


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.booleans())
def test_projection_is_the_nearest_vector_that_keeps_the_rows(seed, of_a_task):
    step, rows, bounds = random_case(seed)
    metric = np.eye(len(step))
    if of_a_task:
        metric = task_metric(np.random.default_rng(seed).normal(size=(2, len(step))))
    x, pushes = project(step, rows, bounds, 0.0, metric if of_a_task else None)
    # The conditions of Karush, Kuhn and Tucker, which only the nearest vector fulfils.
    slack = rows @ x - bounds
    assert slack.min() >= -1e-5
    assert pushes.min() >= 0.0
    np.testing.assert_allclose(x, step + metric @ rows.T @ pushes, atol=1e-9)
    np.testing.assert_allclose(pushes * slack, 0.0, atol=1e-4)


def test_a_vector_that_keeps_all_rows_is_returned_as_it_is():
    step = np.array([1.0, 2.0])
    x, pushes = project(step, np.eye(2), np.array([1.0, -np.inf]))
    assert x is step
    assert not pushes.any()


def test_the_same_row_many_times_is_one_row():
    rows = np.tile([[1.0, 1.0]], (5, 1))
    x, _ = project(np.array([-1.0, -1.0]), rows, np.zeros(5))
    np.testing.assert_allclose(x, 0.0, atol=1e-6)


def test_rows_that_contradict_one_another_end_in_a_finite_compromise():
    rows = np.array([[1.0, 0.0], [-1.0, 0.0]])
    x, _ = project(np.array([0.0, 3.0]), rows, np.array([1.0, 1.0]))
    assert np.abs(x).max() <= 4.0
    assert x[1] == pytest.approx(3.0)


def test_no_rows():
    x, pushes = project(np.ones(3), np.zeros((0, 3)), np.zeros(0))
    assert (x == 1.0).all() and pushes.shape == (0,)


def test_in_the_metric_of_a_task_what_the_task_feels_is_dear():
    """Of the ways to keep a row, the one that moves the tool least."""
    rng = np.random.default_rng(1)
    J, row = rng.normal(size=(3, 7)), rng.normal(size=(1, 7))
    step = rng.normal(size=7)
    bounds = row @ step + 1.0
    plain, _ = project(step, row, bounds)
    near, _ = project(step, row, bounds, metric=task_metric(J))
    np.testing.assert_allclose([row[0] @ plain, row[0] @ near], bounds[0], rtol=1e-5)
    assert np.linalg.norm(J @ (near - step)) < 0.3 * np.linalg.norm(J @ (plain - step))
    inverse = np.linalg.inv(task_metric(J))
    lam = 0.05 * np.trace(J @ J.T) / 3
    np.testing.assert_allclose(inverse, np.eye(7) + J.T @ J / lam, atol=1e-9)
