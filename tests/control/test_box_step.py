"""The minimum of a quadratic in a box."""

from itertools import product

import numpy as np
import pytest

from fikm_drake.control.box_step import least_in_box


def problem(rng, n):
    J = rng.normal(size=(min(n, 3), n)) * 10.0 ** rng.uniform(-1, 1, n)
    H = J.T @ J + 10.0 ** rng.uniform(-6, 0) * np.eye(n)
    low = -np.where(rng.random(n) < 0.3, 0.0, rng.random(n))
    high = np.where(rng.random(n) < 0.3, 0.0, rng.random(n))
    return H, J.T @ rng.normal(size=len(J)), low, high


def by_every_choice(H, g, low, high):
    """The least of the minima of all choices of who is free, at the lower or at the upper bound."""
    best, least = None, np.inf
    for sides in product((-1, 0, 1), repeat=len(g)):
        free = np.array(sides) == 0
        x = np.where(np.array(sides) < 0, low, high)
        x[free] = 0.0
        x[free] = np.linalg.solve(H[np.ix_(free, free)], (g - H @ x)[free])
        if (x >= low - 1e-9).all() and (x <= high + 1e-9).all():
            value = 0.5 * x @ H @ x - g @ x
            if value < least:
                best, least = x, value
    return best


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_it_is_the_least_of_all_choices(n):
    rng = np.random.default_rng(n)
    for _ in range(60):
        case = problem(rng, n)
        x, other = least_in_box(*case), by_every_choice(*case)
        H, g, low, high = case
        assert (x >= low).all() and (x <= high).all()
        value, least = (0.5 * y @ H @ y - g @ y for y in (x, other))
        assert value <= least + 1e-9 * max(1.0, abs(least))


@pytest.mark.parametrize("n", [7, 20, 60])
def test_many_joints_meet_the_conditions_of_a_minimum(n):
    rng = np.random.default_rng(n)
    for _ in range(100):
        H, g, low, high = problem(rng, n)
        x = least_in_box(H, g, low, high)
        pull = g - H @ x
        slack = 1e-8 * np.abs(H).max()
        assert (pull[x > low] >= -slack).all() and (pull[x < high] <= slack).all()


def test_a_joint_at_its_bound_lets_go_where_the_others_ask_for_it():
    """Fixed at first, since alone it would pass its bound; with the other at its own it need not."""
    H, g = np.array([[1.0, 1.2], [1.2, 2.0]]), np.array([0.5, 3.0])
    x = least_in_box(H, g, np.array([-1.0, -1.0]), np.array([1.0, 0.1]))
    np.testing.assert_allclose(x, [0.38, 0.1])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_gives_the_shortest_step(bad):
    low, high = np.array([0.1, -1.0]), np.array([0.2, 1.0])
    for H, g in ((np.full((2, 2), bad), np.ones(2)), (np.eye(2), np.array([bad, 0.0]))):
        assert least_in_box(H, g, low, high).tolist() == [0.1, 0.0]
    assert least_in_box(np.zeros((2, 2)), np.ones(2), low, high).tolist() == [0.1, 0.0]
