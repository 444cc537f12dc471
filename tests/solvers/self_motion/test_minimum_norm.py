"""The posture closest to mid-range, and steps of minimum norm along a path."""

import numpy as np
import pytest

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.minimum_norm_path import minimum_norm_path


def random_arm(seed):
    rng = np.random.default_rng(seed)
    limits = np.sort(rng.uniform(-3.1, 3.1, (3, 2)), axis=1)
    rows = [DhJoint(a=a, lower=low, upper=high) for a, (low, high) in zip((0.0, 1.0, 0.8), limits)]
    return DhArm(DhTable("random", "craig", rows, DhTransform(a=0.5)))


@pytest.mark.parametrize("arm", [load_arm("hassantabar3r"), *map(random_arm, range(4))])
def test_no_posture_is_closer_to_mid_range(arm):
    geometry = Planar3R(arm)
    rng = np.random.default_rng(1)
    points = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (100, 3)))[:, :2, 3]
    q = closest_to_mid_range(arm, points)
    assert geometry.is_inside(q).all()
    np.testing.assert_allclose(arm.forward_kinematics(q)[:, :2, 3], points, rtol=0, atol=1e-12)
    theta_1 = np.linspace(arm.lower[0], arm.upper[0], 4001)
    others = geometry.postures(points[:, None], theta_1).reshape(100, -1, 3)
    squares = np.sum((others - geometry.middle) ** 2, axis=-1)
    squares[~geometry.is_inside(others)] = np.inf
    ours = np.sum((q - geometry.middle) ** 2, axis=-1)
    assert (ours <= squares.min(axis=1) + 1e-12).all()


def test_closest_is_stationary_inside_its_interval():
    """(q − middle) is at right angles to the self-motion unless a limit stops it."""
    arm = load_arm("hassantabar3r")
    geometry = Planar3R(arm)
    rng = np.random.default_rng(2)
    points = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (300, 3)))[:, :2, 3]
    q = closest_to_mid_range(arm, points)
    lower, upper = feasible_interval_table(arm, points).widest()
    free = (q[:, 0] > lower + 1e-6) & (q[:, 0] < upper - 1e-6)
    motion = geometry.self_motion(q)
    motion /= np.linalg.norm(motion, axis=1)[:, None]
    assert free.sum() > 100
    assert np.abs(np.sum((q - geometry.middle) * motion, axis=1)[free]).max() < 1e-9


def test_infeasible_points_have_no_closest_posture():
    q = closest_to_mid_range(load_arm("hassantabar3r"), [[9.0, 0.0], [1.0, 2.0], [np.nan, 0.0]])
    np.testing.assert_array_equal(np.isnan(q).all(axis=1), [True, False, True])


def test_edge_of_the_workspace_is_the_stretched_arm():
    q = closest_to_mid_range(load_arm("hassantabar3r"), [[4.5, 0.0]])
    np.testing.assert_allclose(q, [[0.0, 0.0, 0.0]], atol=1e-7)


def test_integrated_steps_drift_as_in_the_thesis_s_square():
    """θ1 at P0 of trajectory A: 1.243 at first, 1.305 after five laps; the tool is exact all along."""
    arm = load_arm("hassantabar3r")
    corners = [(-1.0, 2.0), (1.0, 2.0), (1.0, 4.0), (-1.0, 4.0), (-1.0, 2.0)]
    share = np.linspace(0, 4, 401)
    lap = np.stack([np.interp(share, range(5), column) for column in zip(*corners)], axis=1)
    points = np.concatenate([lap, *[lap[1:]] * 4])
    q = minimum_norm_path(arm, points, [np.pi / 4, np.pi / 4, np.pi / 2])
    assert q[0, 0] == pytest.approx(1.243, abs=1e-3)
    assert q[-1, 0] == pytest.approx(1.305, abs=1e-3)
    np.testing.assert_allclose(arm.forward_kinematics(q)[:, :2, 3], points, rtol=0, atol=1e-12)


def test_integration_ends_where_a_point_is_out_of_reach():
    arm = load_arm("hassantabar3r")
    q = minimum_norm_path(arm, [[1.0, 2.0], [9.0, 0.0], [1.0, 2.0]], [0.5, 0.5, 0.5])
    np.testing.assert_array_equal(np.isnan(q).all(axis=1), [False, True, True])


def test_minimum_norm_in_space():
    arm = load_arm("arm7")
    start = np.full(7, 0.3)
    points = arm.forward_kinematics(start)[:3, 3] + np.linspace(0, 0.1, 5)[:, None] * [1, 0, 0]
    q = minimum_norm_path(arm, points, start, task="position")
    np.testing.assert_allclose(arm.forward_kinematics(q)[:, :3, 3], points, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "start", "task", "words"),
    [
        ([[1.0, 2.0]], [0.0] * 3, "pose", "task"),
        ([[1.0, 2.0, 0.0]], [0.0] * 3, "xy", "points"),
        ([[1.0, np.nan]], [0.0] * 3, "xy", "points"),
        ([[1.0, 2.0]], [0.0] * 2, "xy", "start"),
        ([[1.0, 2.0]], [np.nan] * 3, "xy", "start"),
    ],
)
def test_bad_paths_are_named(points, start, task, words):
    with pytest.raises(ValueError, match=words):
        minimum_norm_path(load_arm("hassantabar3r"), points, start, task=task)


def test_bad_arms_and_points_are_named():
    with pytest.raises(ValueError, match="points"):
        closest_to_mid_range(load_arm("hassantabar3r"), [1.0, 2.0])
    free = DhArm(DhTable("free", "craig", [DhJoint(a=a) for a in (0, 1, 1)], DhTransform(a=1)))
    with pytest.raises(ValueError, match="two limits"):
        closest_to_mid_range(free, [[1.0, 2.0]])
