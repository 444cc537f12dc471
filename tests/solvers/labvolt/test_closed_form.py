"""Exact reachability, the exact solution and the nearest reachable point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.kinematics.planar_border import border_arcs, nearest_on_border
from fikm_drake.kinematics.planar_links import two_links
from fikm_drake.solvers.labvolt.feasible_postures import candidates, widest_arc
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.plane_targets import random_targets

GEOMETRY = labvolt()
SHARES = st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3)
POINT = st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9))


def square(count, seed):
    """Points (2,N), reachable or not."""
    return np.random.default_rng(seed).uniform(-0.8, 0.8, (2, count))


def by_grid(points, step):
    """Whether a point is reached with some θ_3 on a grid [deg]: algorithm 1 without an end."""
    theta_3 = np.deg2rad(np.arange(-180.0, 180.0, step))
    reached = np.zeros(points.shape[1], dtype=bool)
    for i, point in enumerate(points.T):
        wrist = point[:, None] - GEOMETRY.lengths[2] * np.array([np.cos(theta_3), np.sin(theta_3)])
        for side in (1.0, -1.0):
            theta_1, elbow = two_links(*GEOMETRY.lengths[:2], wrist, side)
            q = np.array([theta_1, elbow, theta_3 - theta_1 - elbow])
            q = (q + np.pi) % (2.0 * np.pi) - np.pi
            reached[i] |= GEOMETRY.contains(q, 0.0).any()
    return reached


@given(SHARES)
def test_whatever_a_posture_reaches_is_solved(shares):
    """Limits and their corners among them, where the arm can be at the edge of its reach."""
    lower, upper = np.array(GEOMETRY.lower), np.array(GEOMETRY.upper)
    point = GEOMETRY.tool((lower + np.array(shares) * (upper - lower))[:, None])
    q = widest_arc(GEOMETRY, point)
    if np.isnan(q).any():  # a corner, met only to rounding
        q, distance = nearest_on_border(GEOMETRY, point)
        assert distance[0] < 1e-12
    assert GEOMETRY.error(q, point)[0] < 1e-12
    assert GEOMETRY.contains(q, 0.0).all()


@given(POINT)
def test_any_point_is_reached_or_proven_out_of_reach(point):
    point = np.array(point)[:, None]
    q = widest_arc(GEOMETRY, point)
    if np.isnan(q).any():
        q, distance = nearest_on_border(GEOMETRY, point)
        assert GEOMETRY.error(q, point)[0] == pytest.approx(distance[0], abs=1e-12)
    else:
        assert GEOMETRY.error(q, point)[0] < 1e-12
    assert GEOMETRY.contains(q, 0.0).all()


def test_reachability_agrees_with_a_grid_of_theta_3():
    points = square(600, 0)
    exact = ~np.isnan(widest_arc(GEOMETRY, points)[0])
    grid = by_grid(points, 0.25)
    assert not (grid & ~exact).any()
    for point in points[:, exact & ~grid].T:  # a thin arc, between two angles of the grid
        assert by_grid(point[:, None], 0.005)[0]
    assert 0.2 < exact.mean() < 0.6


def test_no_reachable_point_is_nearer_than_the_nearest():
    points = square(300, 1) * 1.2
    points = points[:, np.isnan(widest_arc(GEOMETRY, points)[0])]
    _, distance = nearest_on_border(GEOMETRY, points)
    rng = np.random.default_rng(2)
    angle = rng.uniform(-np.pi, np.pi, (200, points.shape[1]))
    size = distance * np.sqrt(rng.uniform(0.0, 1.0, angle.shape))
    size[:100] = distance * (1.0 - 1e-6)  # on the rim, too
    inside = points[:, None] + size * np.array([np.cos(angle), np.sin(angle)])
    assert np.isnan(widest_arc(GEOMETRY, inside.reshape(2, -1))[0]).all()


def test_nearest_beats_every_posture_of_a_grid():
    axes = [np.linspace(low, high, 40) for low, high in zip(GEOMETRY.lower, GEOMETRY.upper)]
    tools = GEOMETRY.tool(np.stack(np.meshgrid(*axes)).reshape(3, -1))
    points = square(200, 3) * 1.3
    points = points[:, np.isnan(widest_arc(GEOMETRY, points)[0])]
    _, distance = nearest_on_border(GEOMETRY, points)
    for point, d in zip(points.T, distance):
        best = np.hypot(*(tools - point[:, None])).min()
        assert d <= best + 1e-12 and best < d + 0.03


def test_border_arcs_are_inside_the_limits():
    arcs = border_arcs(GEOMETRY)
    for share in np.linspace(0.0, 1.0, 21):
        q = arcs.posture.copy()
        q[arcs.joint, np.arange(len(arcs.joint))] += share * arcs.span[:, 0]
        assert GEOMETRY.contains(q, 1e-12).all()
        angle = arcs.start + share * arcs.span
        drawn = arcs.centre + arcs.radius * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(GEOMETRY.tool(q), drawn[:, :, 0], rtol=0, atol=1e-12)


def test_the_14_candidates_reach_the_point_and_are_at_a_limit_or_straight():
    points = random_targets(300, seed=4).T
    q = candidates(GEOMETRY, points)
    fixed = [GEOMETRY.lower[0], GEOMETRY.upper[0], GEOMETRY.lower[1], GEOMETRY.upper[1]]
    fixed += [GEOMETRY.lower[2], GEOMETRY.upper[2], 0.0]
    for k, angle in enumerate(fixed):
        for row in (2 * k, 2 * k + 1):
            there = ~np.isnan(q[:, row]).any(axis=0)
            assert there.any()
            assert GEOMETRY.error(q[:, row, there], points[:, there]).max() < 1e-12
            assert q[min(k // 2, 2), row, there] == pytest.approx(angle, abs=1e-12)


def test_middle_of_the_widest_arc_keeps_away_from_the_limits():
    """Most solutions have room; a limit that is touched has nowhere to go."""
    q = widest_arc(GEOMETRY, random_targets(2000, seed=5).T)
    lower, upper = np.array(GEOMETRY.lower)[:, None], np.array(GEOMETRY.upper)[:, None]
    room = np.minimum(q - lower, upper - q).min(axis=0)
    assert np.median(room) > np.deg2rad(15.0)
    assert (room > 1e-9).mean() > 0.99


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_two_links_reach_also_nearly_straight(side):
    distance = 0.5889 - np.array([0.0, 1e-16, 1e-12, 1e-6, 0.1])
    bearing = np.linspace(-3.0, 3.0, 5)
    point = distance * np.array([np.cos(bearing), np.sin(bearing)])
    direction, bend = two_links(0.3604, 0.2285, point, side)
    end = 0.3604 * np.exp(1j * direction) + 0.2285 * np.exp(1j * (direction + bend))
    np.testing.assert_allclose([end.real, end.imag], point, rtol=0, atol=1e-12)
    assert (side * bend >= 0.0).all()


def test_two_links_too_short_are_nan():
    _, bend = two_links(0.3, 0.2, np.array([[0.6, 0.05, 0.4], [0.0, 0.0, 0.0]]), 1.0)
    assert np.isnan(bend).tolist() == [True, True, False]
