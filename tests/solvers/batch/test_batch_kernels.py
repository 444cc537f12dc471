"""The structure-of-arrays kinematics, step, rotation error and reach against plain ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.conjugate_gradients import conjugate_gradients
from fikm_drake.resources import model_names
from fikm_drake.solvers.batch.batch_targets import BatchTargets, rotation_error
from fikm_drake.solvers.batch.descent import batch_step, solve_positive_definite
from fikm_drake.solvers.batch.reach import Reach

angles = st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi]) | st.floats(-np.pi, np.pi)
lengths = st.just(0.0) | st.floats(-1.0, 1.0)
transforms = {"alpha": angles, "a": lengths, "d": lengths, "theta": angles}
joints = st.builds(
    DhJoint,
    **transforms,
    type=st.sampled_from(["revolute", "revolute", "prismatic"]),
    lower=st.floats(-2.0, -0.1),
    upper=st.floats(0.1, 2.0),
)
tables = st.builds(
    DhTable,
    name=st.just("random"),
    convention=st.sampled_from(["craig", "standard"]),
    joints=st.lists(joints, min_size=1, max_size=7),
    tool=st.builds(DhTransform, **transforms),
)


@given(tables)
def test_kinematics_equal_those_of_the_arm(table):
    arm = DhArm(table)
    q = np.random.default_rng(4).uniform(-3, 3, (9, arm.num_joints))
    frames = arm.chain.frames(np.ascontiguousarray(q.T))
    # Matrix products, and the columns of a Jacobian as textbooks write them.
    links = arm.link_poses(q)
    X = links[:, -1] @ arm.tool_pose
    revolute = np.array([joint.is_revolute for joint in arm.table.joints])[:, None]
    axes, levers = links[..., :3, 2], X[:, None, :3, 3] - links[..., :3, 3]
    linear = np.where(revolute, np.cross(axes, levers), axes)
    J = np.concatenate([np.where(revolute, axes, 0.0), linear], axis=2).transpose(0, 2, 1)
    exact = {"rtol": 0, "atol": 1e-12}
    np.testing.assert_allclose(frames.position.T, X[:, :3, 3], **exact)
    np.testing.assert_allclose(frames.rotation.transpose(2, 1, 0), X[:, :3, :3], **exact)
    scale = np.repeat([0.3, 1.0], 3)[:, None]
    np.testing.assert_allclose(frames.jacobian(0.3).transpose(2, 0, 1), scale * J, **exact)
    np.testing.assert_allclose(frames.jacobian(None).transpose(2, 0, 1), J[:, 3:], **exact)


@given(tables, st.sampled_from(["position", "pose"]), st.integers(0, 2**32 - 1))
def test_no_reachable_target_is_called_out_of_reach(table, task, seed):
    arm = DhArm(table)
    q = np.random.default_rng(seed).uniform(arm.lower, arm.upper, (30, arm.num_joints))
    X = arm.forward_kinematics(q)
    targets = X if task == "pose" else X[:, :3, 3]
    assert not out_of_reach(arm, targets, (1e-6, 1e-6)).any()
    assert not out_of_reach(arm, targets, (1e-6, 1e-6), limits=False).any()


@pytest.mark.parametrize("m", [3, 6])
def test_step_equals_m_conjugate_gradients_on_the_scaled_jacobian(m):
    rng = np.random.default_rng(m)
    J, e = rng.normal(size=(20, m, 7)), rng.normal(size=(20, m))
    r, c = np.abs(J).sum(2), np.abs(J).sum(1)
    S = J / np.sqrt(r)[:, :, None] / np.sqrt(c)[:, None]
    expected = conjugate_gradients(S, e / np.sqrt(r), m, damping=0.1) / np.sqrt(c)
    J, e = np.ascontiguousarray(J.transpose(1, 2, 0)), np.ascontiguousarray(e.T)
    np.testing.assert_allclose(batch_step(J, e, 0.01, floor=0.0).T, expected, rtol=1e-6)


def test_step_is_finite_and_calm_where_rows_and_columns_vanish():
    J = np.zeros((3, 4, 2))
    J[0, 1] = 0.5
    e = np.ones((3, 2))
    step = batch_step(J, e, 1e-6)
    np.testing.assert_allclose(step[[0, 2, 3]], 0.0, atol=1e-12)
    np.testing.assert_allclose(step[1], 2.0, rtol=1e-3)
    np.testing.assert_array_equal(batch_step(np.zeros((3, 4, 2)), e, 1e-6), 0.0)


def test_blocked_joint_leaves_the_motion_to_the_others():
    J = np.ones((1, 2, 1))
    step = batch_step(J, np.ones((1, 1)), 1e-9, weights=np.array([[1e-3], [1.0]]))
    assert step[0, 0] < 2e-3 and step.sum() == pytest.approx(1.0, rel=1e-3)


def test_positive_definite_systems_are_solved():
    rng = np.random.default_rng(5)
    A = rng.normal(size=(8, 6, 9))
    M, b = A @ A.swapaxes(1, 2), rng.normal(size=(8, 6))
    y = solve_positive_definite(M.transpose(1, 2, 0).copy(), b.T.copy())
    np.testing.assert_allclose(y.T, np.linalg.solve(M, b[..., None])[..., 0], rtol=1e-8)


@pytest.mark.parametrize(
    "angle", [0.0, 1e-12, 1e-7, 1e-3, 1.0, 2.9, 3.0, 3.14, np.pi - 1e-9, np.pi]
)
def test_rotation_error_is_the_rotation_vector_through_180_degrees(angle):
    rng = np.random.default_rng(6)
    axes = np.concatenate([rng.normal(size=(200, 3)), np.eye(3), -np.eye(3)])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    start = _rotations(rng.normal(size=axes.shape), 2.0)
    target = _rotations(axes, angle) @ start
    error, size = rotation_error(start.transpose(2, 1, 0), target.transpose(2, 1, 0))
    np.testing.assert_allclose(size, angle, rtol=0, atol=1e-7 if angle > 3 else 1e-12)
    np.testing.assert_allclose(np.linalg.norm(error, axis=0), size, rtol=0, atol=1e-12)
    if angle == np.pi:
        error = error * np.sign(np.sum(error.T * axes, axis=1))
    np.testing.assert_allclose(error.T, angle * axes, rtol=0, atol=2e-7)


def test_reach_is_an_annulus_and_a_plane():
    arm = DhArm(DhTable("two", "craig", [DhJoint(), DhJoint(a=1.0)], DhTransform(a=0.4)))
    points = np.array([[1.39, 0, 0], [1.41, 0, 0], [0, 0.61, 0], [0, 0.59, 0], [1, 0, 0.01]])
    np.testing.assert_array_equal(out_of_reach(arm, points, (1e-3, 0.1)), [0, 1, 0, 1, 1])


def test_tilted_pose_is_out_of_reach_of_a_planar_arm():
    arm = load_arm("planar4")
    X = arm.forward_kinematics([0.3, 0.4, -0.5, 0.6])
    tilt = np.eye(4)
    tilt[:3, :3] = _rotations(np.array([[1.0, 0.0, 0.0]]), 0.02)[0]
    np.testing.assert_array_equal(out_of_reach(arm, np.array([X, X @ tilt]), (1e-3, 0.01)), [0, 1])


@pytest.mark.parametrize("name", model_names())
def test_far_targets_are_out_of_reach_of_our_models(name):
    assert out_of_reach(load_arm(name), np.array([[9.0, 0.0, 0.0]]), (1e-3, 0.1)).all()


def out_of_reach(arm, targets, tolerance, limits=True):
    reach = Reach(arm.chain, targets.ndim == 3, tolerance, limits)
    return reach.beyond(BatchTargets.from_array(targets))


def _rotations(axes, angle):
    """Rodrigues' formula, (N,3,3)."""
    x, y, z = axes.T / np.linalg.norm(axes, axis=1)
    o = np.zeros_like(x)
    K = np.array([[o, -z, y], [z, o, -x], [-y, x, o]]).transpose(2, 0, 1)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
