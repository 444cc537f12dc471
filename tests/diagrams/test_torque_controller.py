"""Fuzzy IK in front of Drake's inverse dynamics, with a plant of mass and gravity."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource, LogVectorOutput

import fikm_drake as fd
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant

Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
TARGET = np.array([0.5, -0.45, 0.3])
OUTPUTS = ("actuation", "valid", "status")


@pytest.fixture(scope="module")
def discrete():
    """A discrete plant with arm7: the model of the inner loop."""
    return MakeDhArmPlant(fd.load_arm("arm7"), time_step=1e-3)


def settle(model, *, seconds=3.0, heavier=1.0, target=TARGET, config=None, **options):
    """Joints, their speeds, error of the tool [m] and torques after a step to `target`.

    The plant is the arm of the model with links heavier by a factor.
    """
    arm = fd.load_arm("arm7")
    builder = DiagramBuilder()
    plant = builder.AddSystem(MakeDhArmPlant(arm, time_step=1e-3))
    controller = builder.AddSystem(fd.FuzzyIkTorqueController(model, config=config, **options))
    source = builder.AddSystem(ConstantVectorSource(target))
    builder.Connect(source.get_output_port(), controller.GetInputPort("desired_position"))
    builder.Connect(plant.get_state_output_port(), controller.GetInputPort("estimated_state"))
    builder.Connect(controller.GetOutputPort("actuation"), plant.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    own, robot = (s.GetMyMutableContextFromRoot(root) for s in (controller, plant))
    controller.SetPositions(own, Q0)
    plant.SetPositions(robot, Q0)
    for i in range(1, 8):
        link = plant.GetBodyByName(f"link{i}")
        inertia = link.CalcSpatialInertiaInBodyFrame(robot)
        link.SetSpatialInertiaInBodyFrame(
            robot,
            SpatialInertia(
                heavier * inertia.get_mass(), inertia.get_com(), inertia.get_unit_inertia()
            ),
        )
    simulator.AdvanceTo(seconds)
    q = plant.GetPositions(robot)
    error = np.linalg.norm(arm.forward_kinematics(q)[:3, 3] - target)
    return q, plant.GetVelocities(robot), error, controller.GetOutputPort("actuation").Eval(own)


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("fused", [False, True])
def test_reaches_the_target_and_bears_the_arms_weight(discrete, measured, fused):
    config = fd.FuzzyIkConfig(measured_position=measured, fused=fused)
    q, v, error, torque = settle(discrete, config=config)
    assert error < 1e-4
    assert np.abs(v).max() < 1e-3
    context = discrete.CreateDefaultContext()
    discrete.SetPositions(context, q)
    gravity = discrete.CalcGravityGeneralizedForces(context)
    assert np.abs(gravity).max() > 5.0
    np.testing.assert_allclose(torque, -gravity, atol=0.05)


def test_measured_joints_make_up_for_a_wrong_model(discrete):
    """Links a quarter heavier than the model: the open loop droops, the measured one does not."""
    errors = [
        settle(discrete, heavier=1.25, config=fd.FuzzyIkConfig(measured_position=measured))[2]
        for measured in (False, True)
    ]
    assert errors[0] > 1e-4
    assert errors[1] < 1e-6


def test_a_slow_inner_loop_needs_lower_gains_with_measured_joints(discrete):
    """The trap of measured joints: Table I's gains swing the arm, half of them do not; the calm helps."""
    gains = {"gains": [0.5, 1.3, 0.4], "oscillating_gains": [0.05, 0.2, 0.015]}
    half = fd.GainSupervisorConfig(**gains, initial_gain=0.5)
    uncalmed = fd.GainSupervisorConfig(calming=1.0)
    table_1 = fd.FuzzyIkConfig(measured_position=True, supervisor=uncalmed)
    calmed = fd.FuzzyIkConfig(measured_position=True)
    lower = fd.FuzzyIkConfig(measured_position=True, supervisor=half)
    assert settle(discrete, config=lower, bandwidth=30.0)[2] < 1e-3
    swings = settle(discrete, config=table_1, bandwidth=30.0)[2]
    assert swings > 0.01
    assert settle(discrete, config=calmed, bandwidth=30.0)[2] < 0.2 * swings
    assert settle(discrete, config=fd.FuzzyIkConfig(), bandwidth=30.0)[2] < 1e-3


def test_added_controller_is_connected_to_its_plant():
    """The factory wires plant and controller; a pose task exports desired_pose."""
    arm = fd.load_arm("iiwa14")
    home = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
    T = arm.forward_kinematics(home + 0.1)
    config = fd.FuzzyIkConfig(
        task="pose", law=fd.FuzzyMapping(iterations=3, damping=0.1, row_floor=0.05)
    )
    builder = DiagramBuilder()
    plant = builder.AddSystem(MakeDhArmPlant(arm, time_step=1e-3))
    controller = fd.AddFuzzyIkTorqueController(builder, plant, config=config)
    source = builder.AddSystem(ConstantValueSource(Value(RigidTransform(T))))
    builder.Connect(source.get_output_port(), controller.GetInputPort("desired_pose"))
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), home)
    robot = plant.GetMyMutableContextFromRoot(root)
    plant.SetPositions(robot, home)
    simulator.AdvanceTo(3.0)
    np.testing.assert_allclose(arm.forward_kinematics(plant.GetPositions(robot)), T, atol=1e-3)


@pytest.mark.parametrize("measured", [False, True])
def test_a_target_that_steps_is_reached_inside_the_limits(measured):
    """The iiwa14 from q = 0, stretched upright: speeds and torques of the data sheet's order."""
    arm = fd.load_arm("iiwa14")
    builder = DiagramBuilder()
    plant = builder.AddSystem(MakeDhArmPlant(arm, time_step=1e-3))
    config = fd.FuzzyIkConfig(measured_position=measured)
    controller = fd.AddFuzzyIkTorqueController(builder, plant, config=config)
    target = builder.AddSystem(ConstantVectorSource([0.4, 0.2, 0.5]))
    builder.Connect(target.get_output_port(), controller.GetInputPort("desired_position"))
    states = LogVectorOutput(plant.get_state_output_port(), builder, 1e-3)
    torques = LogVectorOutput(controller.GetOutputPort("actuation"), builder, 1e-3)
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    simulator.AdvanceTo(3.0)
    state, torque = (sink.FindLog(root).data() for sink in (states, torques))
    reached = arm.forward_kinematics(state[:7, -1])[:3, 3]
    np.testing.assert_allclose(reached, [0.4, 0.2, 0.5], atol=1e-4)
    assert (np.abs(state[7:]).max(axis=1) < 1.1 * arm.velocity_limits).all()
    assert np.abs(torque).max() < 100.0


def test_ports(discrete, ports):
    controller = fd.FuzzyIkTorqueController(discrete)
    inputs, outputs = ports(controller)
    assert inputs == {"desired_position": 3, "estimated_state": 14}
    own = ports(fd.MakeFuzzyIkController(discrete))[1]
    assert outputs == {"actuation": 7} | own | {"valid": 1}


def test_a_lost_target_holds_the_arm(discrete):
    """NaN as a target: the command holds, and the inner loop holds the arm against gravity."""
    q, v, _, torque = settle(discrete, target=np.full(3, np.nan), seconds=0.5)
    np.testing.assert_allclose(q, Q0, atol=1e-6)
    assert np.abs(v).max() < 1e-6
    assert np.isfinite(torque).all()


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_lost_state_ends_no_process(discrete, measured, bad):
    """Torques from the last good state; Drake's inverse dynamics would end the process."""
    config = fd.FuzzyIkConfig(measured_position=measured)
    controller = fd.FuzzyIkTorqueController(discrete, config=config)
    context = controller.CreateDefaultContext()
    controller.SetPositions(context, Q0)
    controller.GetInputPort("desired_position").FixValue(context, TARGET)
    state = np.concatenate([Q0, np.zeros(7)])
    outputs = []
    for i in (None, 2, 9):
        lost = state.copy()
        if i is not None:
            lost[i] = bad
        controller.GetInputPort("estimated_state").FixValue(context, lost)
        outputs.append([controller.GetOutputPort(name).Eval(context).copy() for name in OUTPUTS])
    (torque, valid, _), (torque_2, valid_2, status_2), (torque_9, valid_9, _) = outputs
    np.testing.assert_array_equal(torque_2, torque)
    np.testing.assert_array_equal(torque_9, torque)
    assert (valid, valid_2, valid_9) == (1, 0, 0)
    assert (status_2 == fd.ControllerStatus.INVALID_INPUT) == measured


def test_bad_arguments_are_named(discrete, plant_with):
    with pytest.raises(ValueError, match="discrete.*time step of 0.0 s"):
        fd.FuzzyIkTorqueController(plant_with("arm7"))
    for bandwidth in (0.0, -1.0, np.nan, np.inf):  # bad as either
        with pytest.raises(ValueError, match="bandwidth"):
            fd.FuzzyIkTorqueController(discrete, bandwidth=bandwidth)
        with pytest.raises(ValueError, match="acceleration_limits"):
            fd.FuzzyIkTorqueController(discrete, acceleration_limits=bandwidth)
    unactuated = MultibodyPlant(1e-3)
    fd.AddDhArm(unactuated, fd.load_arm("arm7"))
    unactuated.RemoveJointActuator(unactuated.GetJointActuatorByName("joint3_motor"))
    unactuated.Finalize()
    with pytest.raises(ValueError, match=r"joint3.*have none"):
        fd.FuzzyIkTorqueController(unactuated)
