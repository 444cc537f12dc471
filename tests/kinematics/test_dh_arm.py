"""Forward kinematics and Jacobian against Drake, a peer library, finite differences, paper 1."""

import json
from pathlib import Path

import numpy as np
import pytest

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import model_names

GOLDEN = json.loads((Path(__file__).parents[1] / "golden/fk_golden.json").read_text("utf-8"))


@pytest.mark.parametrize("convention", ["craig", "standard"])
def test_random_arms_agree_with_multibody_plant(convention, random_arm, plant_twin):
    rng = np.random.default_rng(1993)
    for _ in range(60):
        arm = random_arm(rng, convention=convention)
        twin = plant_twin(arm)
        for _ in range(3):
            q = rng.uniform(-3, 3, arm.num_joints)
            np.testing.assert_allclose(
                arm.forward_kinematics(q), twin.pose(q), rtol=0, atol=1e-12, err_msg=str(arm.table)
            )
            np.testing.assert_allclose(
                arm.jacobian(q), twin.jacobian(q), rtol=0, atol=1e-12, err_msg=str(arm.table)
            )


@pytest.mark.parametrize("offset", [0.0, 1e-16, 1e-12, 1e-9, -1e-8, 1e-7, 1e-5])
def test_joint_frames_in_gimbal_lock_agree_with_multibody_plant(offset, plant_twin):
    right = np.pi / 2
    rows = [
        DhJoint(alpha=sign * right + offset, a=0.3, d=0.2, theta=other * right - offset)
        for sign in (1, -1)
        for other in (1, -1)
    ]
    arm = DhArm(DhTable("locked", "craig", rows))
    twin = plant_twin(arm)
    for q in np.random.default_rng(7).uniform(-3, 3, (5, 4)):
        np.testing.assert_allclose(arm.forward_kinematics(q), twin.pose(q), rtol=0, atol=1e-12)
        np.testing.assert_allclose(arm.jacobian(q), twin.jacobian(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", model_names())
def test_our_models_agree_with_multibody_plant(name, plant_twin):
    arm = load_arm(name)
    twin = plant_twin(arm)
    for q in np.random.default_rng(3).uniform(-3, 3, (10, arm.num_joints)):
        np.testing.assert_allclose(arm.forward_kinematics(q), twin.pose(q), rtol=0, atol=1e-12)
        np.testing.assert_allclose(arm.jacobian(q), twin.jacobian(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", GOLDEN["arms"])
def test_golden_kinematics_of_roboticstoolbox(name):
    arm, golden = load_arm(name), GOLDEN["arms"][name]
    np.testing.assert_allclose(arm.forward_kinematics(golden["q"]), golden["T"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(arm.jacobian(golden["q"]), golden["J"], rtol=0, atol=1e-9)


def test_puma560_nominal_pose_by_hand():
    """Standard DH with d = [.67183, 0, .15005, .4318, 0, 0]: the closed form of the pose."""
    X = load_arm("puma560").forward_kinematics([0, np.pi / 4, -np.pi, 0, np.pi / 4, 0])
    c = np.sqrt(0.5)
    # Upper arm up at 45°; q2 + q3 = −135° points the elbow's x back and down, its −y forward.
    x = 0.4318 * c - 0.0203 * c + 0.4318 * c
    z = 0.67183 + 0.4318 * c - 0.0203 * c - 0.4318 * c
    np.testing.assert_allclose(X[:3, 3], [x, -0.15005, z], rtol=0, atol=1e-12)
    np.testing.assert_allclose(X[:3, 3], [0.596303, -0.150050, 0.657476], rtol=0, atol=5e-7)
    # q2 + q3 + q5 = −90°: the tool points forward.
    np.testing.assert_allclose(X[:3, 2], [1, 0, 0], rtol=0, atol=1e-12)


def test_arm7_home_position_of_paper_1():
    X = load_arm("arm7").forward_kinematics(np.zeros(7))
    np.testing.assert_allclose(X[:3, 3], [0.2, -0.6, 0.6], rtol=0, atol=1e-12)


def test_planar2_is_the_textbook_arm():
    q = np.random.default_rng(0).uniform(-3, 3, (20, 2))
    first, both = q[:, 0], q.sum(axis=1)
    tool = load_arm("planar2").forward_kinematics(q)[:, :3, 3]
    x, y = np.cos(first) + 0.5 * np.cos(both), np.sin(first) + 0.5 * np.sin(both)
    np.testing.assert_allclose(tool, np.stack([x, y, 0 * x], axis=1), rtol=0, atol=1e-14)


def test_a_standard_row_is_rz_tz_tx_rx():
    """The conventions differ only in the order of the factors, written out here once more."""

    def rz_tz(row):
        c, s = np.cos(row.theta), np.sin(row.theta)
        return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, row.d], [0, 0, 0, 1]])

    def rx_tx(row):
        c, s = np.cos(row.alpha), np.sin(row.alpha)
        return np.array([[1, 0, 0, row.a], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])

    rng = np.random.default_rng(5)
    rows = [DhJoint(*rng.uniform(-1, 1, 4).tolist(), type=t) for t in ("revolute", "prismatic")]
    tool = DhTransform(*rng.uniform(-1, 1, 4).tolist())
    q = rng.uniform(-1, 1, 2)
    moved = [DhTransform(r.alpha, r.a, r.d, r.theta) for r in rows]
    moved[0].theta += q[0]
    moved[1].d += q[1]
    standard, craig = np.eye(4), np.eye(4)
    for row in [*moved, tool]:
        standard = standard @ rz_tz(row) @ rx_tx(row)
        craig = craig @ rx_tx(row) @ rz_tz(row)
    for convention, expected in (("standard", standard), ("craig", craig)):
        arm = DhArm(DhTable("arm", convention, rows, tool))
        np.testing.assert_allclose(arm.forward_kinematics(q), expected, rtol=0, atol=1e-14)


def test_jacobian_is_the_derivative_of_forward_kinematics(random_arm):
    rng = np.random.default_rng(11)
    h = 1e-6
    for _ in range(30):
        arm = random_arm(rng)
        n = arm.num_joints
        q = rng.uniform(-3, 3, n)
        plus, minus = (arm.forward_kinematics(q + step * np.eye(n)) for step in (h, -h))
        derivative = (plus - minus) / (2 * h)
        X = arm.forward_kinematics(q)
        spin = derivative[:, :3, :3] @ X[:3, :3].T  # the skew matrix of ω
        omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
        expected = np.vstack([omega, derivative[:, :3, 3].T])
        np.testing.assert_allclose(arm.jacobian(q), expected, rtol=0, atol=2e-9)


def test_leading_axes_are_vectorised(random_arm):
    rng = np.random.default_rng(13)
    arm = random_arm(rng)
    n = arm.num_joints
    q = rng.uniform(-3, 3, (2, 3, n))
    poses, jacobians, links = arm.forward_kinematics(q), arm.jacobian(q), arm.link_poses(q)
    assert poses.shape == (2, 3, 4, 4)
    assert jacobians.shape == (2, 3, 6, n)
    assert links.shape == (2, 3, n, 4, 4)
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(poses[index], arm.forward_kinematics(q[index]), atol=1e-15)
        np.testing.assert_allclose(jacobians[index], arm.jacobian(q[index]), atol=1e-15)
        np.testing.assert_allclose(links[index], arm.link_poses(q[index]), atol=1e-15)
    assert arm.forward_kinematics(np.zeros((0, n))).shape == (0, 4, 4)
    assert arm.jacobian(np.zeros((0, n))).shape == (0, 6, n)


@pytest.mark.parametrize("q", [0.0, [], [1.0], [1.0, 2.0, 3.0], np.zeros((2, 3)), np.zeros((2, 0))])
def test_wrong_shapes_of_q_are_named(q):
    arm = load_arm("planar2")
    for function in (arm.forward_kinematics, arm.jacobian, arm.link_poses):
        with pytest.raises(ValueError, match=r"planar2.*\(…, 2\), got") as error:
            function(q)
        assert str(np.shape(q)) in str(error.value)


def test_limits_are_arrays_with_infinities():
    rows = [DhJoint(lower=-1, velocity=2.0), DhJoint(upper=3.0, type="prismatic"), DhJoint()]
    arm = DhArm(DhTable("arm", joints=rows))
    np.testing.assert_array_equal(arm.lower, [-1, -np.inf, -np.inf])
    np.testing.assert_array_equal(arm.upper, [np.inf, 3, np.inf])
    np.testing.assert_array_equal(arm.velocity_limits, [2, np.inf, np.inf])


def test_default_position_is_the_nearest_to_zero():
    limits = [(None, None), (-1.0, 2.0), (0.5, 2.0), (-2.0, -0.25)]
    rows = [DhJoint(lower=lower, upper=upper) for lower, upper in limits]
    arm = DhArm(DhTable("arm", joints=rows))
    np.testing.assert_array_equal(arm.default_position, [0, 0, 0.5, -0.25])


def test_an_arm_does_not_change_with_its_table():
    table = DhTable("arm", joints=[DhJoint(d=1.0)])
    arm = DhArm(table)
    before = arm.forward_kinematics([0.3])
    table.joints[0].d = 5.0
    arm.table.joints[0].d = 6.0
    arm.tool_pose[0, 3] = 7.0
    np.testing.assert_array_equal(arm.forward_kinematics([0.3]), before)
    assert arm.table.joints[0].d == 1.0


def test_joint_and_tool_frames_build_the_pose(random_arm):
    arm = random_arm(np.random.default_rng(17))
    X = np.eye(4)
    for i in range(arm.num_joints):
        X = X @ arm.joint_origin(i)
    expected = arm.forward_kinematics(np.zeros(arm.num_joints))
    np.testing.assert_allclose(X @ arm.tool_pose, expected, rtol=0, atol=1e-14)


def test_repr_names_the_arm():
    assert repr(load_arm("panda")) == "<DhArm 'panda': 7 joints>"
