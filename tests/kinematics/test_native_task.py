"""Error and Jacobian of tasks by the native kernel equal those by Drake."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

import fikm_drake as fd
from fikm_drake.kinematics.native import kernel as loading
from fikm_drake.kinematics.native.kernel import numpy_only
from fikm_drake.resources import model_names

TASKS = (fd.PositionTask, lambda arm: fd.PositionTask(arm, "xz"), fd.PoseTask, fd.OrientationTask)


@pytest.fixture(autouse=True)
def with_kernel(native_kernel, monkeypatch):
    monkeypatch.setattr(loading, "_load", lambda: (native_kernel, ""))


def rotation(rng, size):
    """A turn of this size about any axis."""
    axis = rng.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned = np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross
    return RotationMatrix.ProjectToRotationMatrix(turned)


def assert_equal(task, plain, target, q, half_turn=False):
    error, J = task.error_and_jacobian(target, q)
    other, same = plain.error_and_jacobian(target, q)
    np.testing.assert_allclose(J, same, rtol=0, atol=1e-12)
    if half_turn and np.linalg.norm(error - other) > 1.0:  # both ways round are as short
        other[:3] *= -1.0
        np.testing.assert_allclose(error, other, rtol=0, atol=1e-7)
    else:
        np.testing.assert_allclose(error, other, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(task.error(target, q), error)
    np.testing.assert_array_equal(task.jacobian(q), J)


@pytest.mark.parametrize("make", TASKS)
def test_equal_drakes(make):
    rng = np.random.default_rng(4)
    for name in model_names():
        arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm(name)))
        task = make(arm)
        with numpy_only():
            plain = make(arm)
        assert task.native and not plain.native
        for exponent in range(17):
            q = rng.uniform(-3.0, 3.0, arm.num_joints)
            target = rng.uniform(-1.0, 1.0, task.size)
            if task.port == "desired_pose":
                X_WE = arm.pose(arm.context_at(q))
                for size, half in ((10.0**-exponent, False), (np.pi - 10.0**-exponent, True)):
                    R = rotation(rng, size) @ X_WE.rotation()
                    assert_equal(task, plain, RigidTransform(R, rng.normal(size=3)), q, half)
            else:
                assert_equal(task, plain, target, q)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_what_is_not_finite_gives_nan(bad):
    arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("iiwa14")))
    for task in (fd.PositionTask(arm), fd.PoseTask(arm), fd.OrientationTask(arm)):
        poses = task.port == "desired_pose"
        good = RigidTransform() if poses else np.zeros(3)
        q = np.zeros(7)
        assert np.isfinite(task.error(good, q)).all()
        q[3] = bad
        assert np.isnan(task.error(good, q)).all() and np.isnan(task.jacobian(q)).all()
        wrong = RigidTransform([0.0, bad, 0.0]) if poses else np.array([0.0, bad, 0.0])
        assert not np.linalg.norm(task.error(wrong, np.zeros(7))) < 1e100


def test_a_subclass_has_its_own_error():
    class Above(fd.PositionTask):
        def target_error(self, context, target):
            return super().target_error(context, target) + [0.0, 0.0, 0.1]

    arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("panda")))
    target, q = np.array([0.3, 0.0, 0.4]), arm.default_position
    difference = Above(arm).error(target, q) - fd.PositionTask(arm).error(target, q)
    np.testing.assert_allclose(difference, [0.0, 0.0, 0.1], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "options", [{"reference_frame": "link2"}, {"joints": ["joint2", "joint4", "joint5"]}]
)
def test_of_another_frame_and_of_some_joints(options):
    rng = np.random.default_rng(0)
    arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("iiwa14")), "tool", **options)
    for make in TASKS:
        task = make(arm)
        with numpy_only():
            plain = make(arm)
        assert task.native
        target = rng.uniform(-0.5, 0.5, task.size)
        if task.port == "desired_pose":
            target = RigidTransform(rotation(rng, 1.0), rng.normal(size=3))
        assert_equal(task, plain, target, rng.uniform(-0.5, 0.5, arm.num_joints))
