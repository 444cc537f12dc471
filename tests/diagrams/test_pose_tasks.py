"""Tasks with orientation: the error, its Jacobian, and arms that reach poses."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

import fikm_drake as fd
from fikm_drake.kinematics.task import Task
from fikm_drake.kinematics.tasks import as_task, make_task

READY = [0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0]
LENGTH = 0.3


@pytest.fixture(scope="module")
def iiwa():
    return fd.load_arm("iiwa14")


@pytest.fixture(scope="module")
def plant(iiwa):
    plant = MultibodyPlant(0.0)
    fd.AddDhArm(plant, iiwa)
    plant.Finalize()
    return plant


def turned(axis, angle):
    """Rotation (3,3) by Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def pose_of(arm, q):
    T = arm.forward_kinematics(q)
    return RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.4, 2.0, 3.1, np.pi - 1e-9])
def test_orientation_error_is_the_turn_to_the_target(plant, iiwa, angle):
    q, axis = np.array(READY), np.array([1.0, -2.0, 0.5]) / np.linalg.norm([1.0, -2.0, 0.5])
    T = iiwa.forward_kinematics(q)
    desired = RigidTransform(RotationMatrix(turned(axis, angle) @ T[:3, :3]), T[:3, 3] + 0.1)
    error = as_task(plant, "tool", "pose").error(desired, q)
    np.testing.assert_allclose(error[:3], LENGTH * angle * axis, atol=1e-7)
    np.testing.assert_allclose(error[3:], 0.1, atol=1e-12)


def test_half_a_turn_is_one_of_the_two_axes(plant, iiwa):
    T = iiwa.forward_kinematics(READY)
    desired = RigidTransform(RotationMatrix(turned([0, 0, 1], np.pi) @ T[:3, :3]), T[:3, 3])
    error = as_task(plant, "tool", "orientation").error(desired, np.array(READY))
    np.testing.assert_allclose(np.abs(error), [0, 0, LENGTH * np.pi], atol=1e-9)


@pytest.mark.parametrize("name", ["pose", "orientation", "position", "xz"])
def test_jacobian_is_the_derivative_of_the_error(plant, iiwa, name):
    kinematics = make_task(fd.PlantArm(plant), name, 0.7)
    q, h = np.array(READY) + 0.1, 1e-6
    desired = pose_of(iiwa, q)
    if name in ("position", "xz"):
        desired = desired.translation()[Task(name).coordinates]
    numeric = np.stack(
        [
            (kinematics.error(desired, q - d) - kinematics.error(desired, q + d)) / (2 * h)
            for d in h * np.eye(7)
        ],
        axis=1,
    )
    np.testing.assert_allclose(kinematics.jacobian(q), numeric, atol=1e-8)
    error, J = kinematics.error_and_jacobian(desired, q)
    np.testing.assert_array_equal(J, kinematics.jacobian(q))
    np.testing.assert_array_equal(error, kinematics.error(desired, q))
    assert (np.abs(J) <= kinematics.jacobian_range() + 1e-12).all()


def run(plant, config, desired, seconds):
    """The controller, its context and the largest joint step of a run."""
    controller = fd.MakeFuzzyIkController(plant, config=config)
    simulator = Simulator(controller)
    context = simulator.get_mutable_context()
    controller.SetPositions(context, READY)
    controller.GetInputPort("desired_pose").FixValue(context, Value(desired))
    simulator.AdvanceTo(seconds)
    return controller, context, simulator


def output(controller, context, name):
    return controller.GetOutputPort(name).Eval(context)


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("task", ["pose", "orientation"])
def test_reaches_poses_near_by(plant, iiwa, task, fused):
    config = fd.FuzzyIkConfig(
        task=task,
        law=fd.FuzzyMapping(iterations=6, damping=0.01, row_floor=0.01),
        control_rate=100.0,
        fused=fused,
    )
    rng = np.random.default_rng(5)
    for _ in range(5):
        desired = pose_of(iiwa, np.array(READY) + rng.uniform(-0.4, 0.4, 7))
        controller, context, _ = run(plant, config, desired, 3.0)
        q = output(controller, context, "commanded_position")
        reached = pose_of(iiwa, q)
        turn = (desired.rotation().inverse() @ reached.rotation()).ToAngleAxis().angle()
        assert turn < 0.01
        if task == "pose":
            assert np.linalg.norm(reached.translation() - desired.translation()) < 1e-3
        assert output(controller, context, "status")[0] == fd.ControllerStatus.CONVERGED
        assert (q >= iiwa.lower).all() and (q <= iiwa.upper).all()


def test_fused_equals_the_diagram(plant, iiwa):
    desired = pose_of(iiwa, np.array(READY) + 0.3)
    results = []
    for fused in (False, True):
        config = fd.FuzzyIkConfig(
            task="pose", law=fd.FuzzyMapping(iterations=4, damping=0.05), fused=fused
        )
        controller, context, _ = run(plant, config, desired, 1.0)
        names = ("commanded_position", "task_error", "joint_step")
        results.append([output(controller, context, name) for name in names])
    for diagram, fused in zip(*results):
        np.testing.assert_allclose(fused, diagram, atol=1e-12)


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_lost_pose_holds_the_command(plant, iiwa, fused, bad):
    config = fd.FuzzyIkConfig(
        task="pose", law=fd.FuzzyMapping(iterations=6, damping=0.01), fused=fused
    )
    good = pose_of(iiwa, np.array(READY) + 0.2)
    controller, context, simulator = run(plant, config, good, 0.1)
    port = controller.GetInputPort("desired_pose")
    port.FixValue(context, Value(RigidTransform([bad, 0.0, 0.5])))
    held = output(controller, context, "commanded_position").copy()
    simulator.AdvanceTo(0.5)
    np.testing.assert_array_equal(output(controller, context, "commanded_position"), held)
    assert output(controller, context, "status")[0] == fd.ControllerStatus.INVALID_INPUT
    assert not output(controller, context, "task_error").any()
    port.FixValue(context, Value(good))
    simulator.AdvanceTo(3.0)
    assert output(controller, context, "status")[0] == fd.ControllerStatus.CONVERGED


def test_direct_mapping_of_a_pose(plant, iiwa):
    """The rule bases know the rows of rotation in metres."""
    desired = pose_of(iiwa, np.array(READY) + 0.05)
    errors = []
    for method in ("indirect", "direct"):
        config = fd.FuzzyIkConfig(task="pose", law=fd.FuzzyMapping(method))
        controller, context, _ = run(plant, config, desired, 2.0)
        errors.append(np.linalg.norm(output(controller, context, "task_error")))
    assert errors[1] == pytest.approx(errors[0], rel=0.3)


def test_bad_tasks():
    with pytest.raises(ValueError, match="orientation.*pose"):
        Task("posture")
    for length in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="characteristic_length"):
            fd.FuzzyIkConfig(task="pose", characteristic_length=length).validate()
