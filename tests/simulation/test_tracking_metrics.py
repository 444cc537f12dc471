"""Metrics by hand, distances by geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.simulation.tracking_metrics import distance_from_path, tracking_metrics

coordinates = st.floats(-5, 5).map(lambda x: round(x, 6))


def points(least, most):
    return hnp.arrays(float, st.tuples(st.integers(least, most), st.just(3)), elements=coordinates)


def test_metrics_by_hand():
    error = np.array([[0.03, 0.04], [0.0, 0.02], [0.0, -0.01]])  # 0.05, 0.02, 0.01
    actual = np.array([[-0.3, 0.4], [0.5, 0.1], [1.0, -0.2]])  # 0.5, 0.1, 0.2 from the edge
    metrics = tracking_metrics(error, actual, np.array([[0.0, 0.0], [1.0, 0.0]]))
    assert metrics.e_max == pytest.approx(0.05, abs=1e-15)
    assert metrics.e_mean == pytest.approx(0.08 / 3, abs=1e-15)
    assert metrics.e_ss == pytest.approx(0.01, abs=1e-15)
    assert metrics.path_max == pytest.approx(0.5, abs=1e-15)
    assert metrics.path_mean == pytest.approx(0.8 / 3, abs=1e-15)
    text = str(metrics)
    for word in ("e_max 5.000 cm", "e_mean 2.667 cm", "e_ss 1.0000 cm", "max 50.000 cm"):
        assert word in text


@given(points(1, 6), points(1, 5))
def test_distance_is_that_to_the_densely_sampled_path(where, waypoints):
    samples = np.linspace(0, 1, 201)[:, None, None]
    path = waypoints if len(waypoints) == 1 else waypoints[:-1]
    if len(waypoints) > 1:
        path = (path + samples * np.diff(waypoints, axis=0)).reshape(-1, 3)
    nearest = np.linalg.norm(where[:, None] - path, axis=-1).min(axis=1)
    spacing = 18.0 / 200
    distance = distance_from_path(where, waypoints)
    assert (distance <= nearest + 1e-12).all()
    assert (distance >= nearest - spacing).all()


@given(points(2, 5), st.floats(0, 1), st.data())
def test_points_of_the_path_are_at_no_distance(waypoints, along, data):
    edge = data.draw(st.integers(0, len(waypoints) - 2))
    on = waypoints[edge] + along * (waypoints[edge + 1] - waypoints[edge])
    assert distance_from_path(on[None], waypoints)[0] <= 1e-9
    np.testing.assert_allclose(distance_from_path(waypoints, waypoints), 0, atol=1e-9)


@given(points(1, 5), points(1, 5), hnp.arrays(float, 3, elements=coordinates))
def test_distance_does_not_depend_on_place_or_direction(where, waypoints, shift):
    distance = distance_from_path(where, waypoints)
    moved = distance_from_path(where + shift, waypoints + shift)
    np.testing.assert_allclose(moved, distance, atol=1e-6)
    np.testing.assert_allclose(distance_from_path(where, waypoints[::-1]), distance, atol=1e-9)


def test_a_repeated_waypoint_is_a_point():
    waypoints = np.array([[1.0, 1.0], [1.0, 1.0]])
    np.testing.assert_allclose(distance_from_path(np.array([[4.0, 5.0]]), waypoints), 5.0)
