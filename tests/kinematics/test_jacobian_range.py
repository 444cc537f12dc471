"""Bounds of the Jacobian's elements: true everywhere, and attained where the paper uses them."""

import dataclasses

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.jacobian_range import jacobian_range
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.resources import model_names

ROUNDING = 1e-12


def sampled(arm, rng, count):
    """Positions with revolute joints free to turn and prismatic ones inside their limits."""
    q = rng.uniform(-np.pi, np.pi, (count, arm.num_joints))
    for i, joint in enumerate(arm.table.joints):
        if not joint.is_revolute:
            q[:, i] = rng.uniform(*np.clip(joint.limits, -10, 10), count)
            q[: count // 4, i] = rng.choice(np.clip(joint.limits, -10, 10), count // 4)
    return q


def test_random_arms_never_exceed_the_bound(random_arm):
    rng = np.random.default_rng(2)
    for _ in range(60):
        arm = random_arm(rng)
        largest = np.abs(arm.jacobian(sampled(arm, rng, 2000))).max(axis=0)
        assert (largest <= arm.jacobian_range() + ROUNDING).all(), arm.table


@pytest.mark.parametrize("name", model_names())
def test_our_models_never_exceed_the_bound(name):
    arm = load_arm(name)
    largest = np.abs(arm.jacobian(sampled(arm, np.random.default_rng(4), 50000))).max(axis=0)
    assert (largest <= arm.jacobian_range() + ROUNDING).all()


def test_planar2_range_of_paper_1():
    """Table III: x and y rows 1.5 and 0.5 (equation 11); the joints turn about z only."""
    expected = np.zeros((6, 2))
    expected[2] = 1.0
    expected[3:5] = [1.5, 0.5]
    np.testing.assert_allclose(load_arm("planar2").jacobian_range(), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["planar2", "planar4"])
def test_planar_arms_attain_the_bound(name):
    arm = load_arm(name)
    stretched = np.zeros((2, arm.num_joints))
    stretched[1, 0] = np.pi / 2
    attained = np.abs(arm.jacobian(stretched)).max(axis=0)
    np.testing.assert_allclose(arm.jacobian_range(), attained, rtol=0, atol=1e-14)


def test_single_turned_axes_attain_the_bound():
    """A link at a right angle to the base axis sweeps a circle in y and z."""
    tool = DhTransform(a=0.7)
    arm = DhArm(DhTable("arm", joints=[DhJoint(alpha=-np.pi / 2)], tool=tool))
    expected = [0, 1, 0, 0.7, 0, 0.7]
    np.testing.assert_allclose(arm.jacobian_range()[:, 0], expected, rtol=0, atol=1e-15)


def test_unlimited_prismatic_joint_makes_the_joints_below_it_unbounded():
    rows = [
        DhJoint(),
        DhJoint(alpha=np.pi / 2, type="prismatic"),
        DhJoint(alpha=np.pi / 2),
    ]
    bound = DhArm(DhTable("arm", joints=rows, tool=DhTransform(a=0.3))).jacobian_range()
    # Joint 2 slides across z: joint 1 moves the tool in x and y without bound, never in z.
    assert np.isinf(bound[3:5, 0]).all()
    np.testing.assert_allclose(bound[:3, 0], [0, 0, 1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(bound[5, 0], 0, rtol=0, atol=1e-15)
    assert np.isfinite(bound[:, 1:]).all()
    assert (bound[:3, 1] == 0).all()
    rows[1].lower, rows[1].upper = -1.0, 2.0
    bound = DhArm(DhTable("arm", joints=rows, tool=DhTransform(a=0.3))).jacobian_range()
    np.testing.assert_allclose(bound[3, 0], 2.3, rtol=0, atol=1e-14)


def test_one_sided_limits_of_a_prismatic_joint_leave_it_unbounded():
    rows = [DhJoint(), DhJoint(alpha=np.pi / 2, type="prismatic", lower=0.0)]
    assert np.isinf(DhArm(DhTable("arm", joints=rows)).jacobian_range()[3, 0])


def plant_range(plant):
    return jacobian_range(SerialChain.from_plant(plant, "tool"))


def test_a_plants_bound_is_its_tables(random_arm, plant_twin):
    rng = np.random.default_rng(6)
    for _ in range(20):
        arm = random_arm(rng)
        bound = plant_range(plant_twin(arm).plant)
        np.testing.assert_allclose(bound, arm.jacobian_range(), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_bound_is_true_for_plants_with_frames_of_any_kind(seed):
    """Axes that are neither z nor meet, links that lie aside: no table."""
    rng = np.random.default_rng(seed)
    n = 5
    before = np.tile(np.eye(4), (n, 1, 1))
    for X in before:
        Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        X[:3, :3], X[:3, 3] = Q * np.linalg.det(Q), rng.uniform(-1, 1, 3)
    chain = dataclasses.replace(
        DhArm(DhTable("arm", joints=[DhJoint()] * n, tool=DhTransform(a=0.3))).chain, before=before
    )
    J = np.abs(chain.jacobian(rng.uniform(-np.pi, np.pi, (20000, n)))).max(axis=0)
    bound = jacobian_range(chain)
    assert (J <= bound + ROUNDING).all()
    assert (J[:3] >= 0.9 * bound[:3]).all()


def test_a_plants_bound_is_of_the_joints_that_move_the_frame():
    """A free body in the plant is none of them."""
    from fikm_drake.kinematics.add_dh_arm import AddDhArm

    arm = load_arm("planar2")
    plant = MultibodyPlant(0.0)
    AddDhArm(plant, arm)
    Parser(plant).AddModelsFromString(
        '<robot name="ball"><link name="free"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>',
        "urdf",
    )
    plant.Finalize()
    np.testing.assert_allclose(plant_range(plant)[3], [1.5, 0.5], rtol=0, atol=1e-12)
