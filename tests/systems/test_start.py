"""The command starts where the robot is."""

import warnings

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

import fikm_drake as fd

Q = np.array([1.0, 0.5, 0.3])


@pytest.fixture(scope="module")
def arm():
    return fd.load_arm("hassantabar3r")


def started(arm, *, fused=True, measured=False, connect=True, place=None):
    """A controller whose target is where the tool of a robot at Q is, after Initialize."""
    plant, builder = fd.MakeDhArmPlant(arm), DiagramBuilder()
    config = fd.FuzzyIkConfig(fused=fused, measured_position=measured, task="xy")
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    target = builder.AddSystem(ConstantVectorSource(arm.forward_kinematics(Q)[:2, 3]))
    builder.Connect(target.get_output_port(), controller.GetInputPort("desired_position"))
    if connect:
        robot = builder.AddSystem(ConstantVectorSource(Q))
        builder.Connect(robot.get_output_port(), controller.GetInputPort("estimated_position"))
    simulator = Simulator(builder.Build())
    own = controller.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    if place is not None:
        controller.SetPositions(own, place)
    return simulator, controller, own


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("measured", [False, True])
def test_the_first_command_is_the_measurement_and_nothing_moves(arm, fused, measured):
    simulator, controller, own = started(arm, fused=fused, measured=measured)
    simulator.Initialize()
    command = controller.GetOutputPort("commanded_position")
    np.testing.assert_array_equal(command.Eval(own), Q)
    simulator.AdvanceTo(1.0)
    np.testing.assert_allclose(command.Eval(own), Q, atol=1e-12)
    status = controller.GetOutputPort("status").Eval(own)[0]
    assert status == fd.ControllerStatus.CONVERGED


@pytest.mark.parametrize("fused", [False, True])
def test_a_second_initialization_starts_anew(arm, fused):
    simulator, controller, own = started(arm, fused=fused)
    simulator.AdvanceTo(0.5)
    controller.SetPositions(own, 0.5 * Q)
    simulator.Initialize()
    command = controller.GetOutputPort("commanded_position")
    np.testing.assert_array_equal(command.Eval(own), Q)


@pytest.mark.parametrize("fused", [False, True])
def test_a_start_by_silence_is_warned_of_once_and_names_the_cure(arm, fused):
    simulator, *_ = started(arm, fused=fused, connect=False)
    with pytest.warns(UserWarning, match="estimated_position.*SetPositions") as seen:
        simulator.AdvanceTo(0.2)
    assert len(seen) == 1
    simulator, controller, own = started(arm, fused=fused, connect=False, place=Q)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulator.AdvanceTo(0.2)
    command = controller.GetOutputPort("commanded_position").Eval(own)
    np.testing.assert_allclose(command, Q, atol=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("fused", [False, True])
def test_a_measurement_that_is_not_finite_starts_nothing(arm, fused, bad):
    simulator, controller, own = started(arm, fused=fused, place=0.9 * Q)
    measured = np.array([0.1, bad, 0.2])
    controller.GetInputPort("estimated_position").FixValue(own, measured)
    simulator.Initialize()
    command = controller.GetOutputPort("commanded_position")
    np.testing.assert_array_equal(command.Eval(own), 0.9 * Q)
    assert controller.GetOutputPort("status").Eval(own)[0] == fd.ControllerStatus.NOT_FOLLOWING


@pytest.mark.parametrize("measured", [False, True])
def test_a_torque_driven_arm_stays_where_it_was_put(measured):
    """The plant placed by the user, the controller not: 168 rad/s after 10 ms, before."""
    arm, builder = fd.load_arm("iiwa14"), DiagramBuilder()
    plant = fd.MakeDhArmPlant(arm, time_step=1e-3)
    builder.AddSystem(plant)
    config = fd.FuzzyIkConfig(
        task="pose", measured_position=measured, law=fd.FuzzyMapping(iterations=6, damping=0.1)
    )
    controller = fd.AddFuzzyIkTorqueController(builder, plant, config=config)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    q = np.array([0.3, 0.7, -0.2, -1.2, 0.1, 0.8, 0.5])
    plant.SetPositions(context, q)
    own = controller.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    X = plant.GetFrameByName("tool").CalcPoseInWorld(context)
    controller.GetInputPort("desired_pose").FixValue(own, RigidTransform(X))
    simulator.AdvanceTo(0.3)
    np.testing.assert_allclose(plant.GetPositions(context), q, atol=1e-6)
    assert np.abs(plant.GetVelocities(context)).max() < 1e-4
