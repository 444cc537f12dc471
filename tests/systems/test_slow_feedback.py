"""The command plus what the robot is off it, slowly."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

import fikm_drake as fd
from fikm_drake.experiments.benchmarks import feedback_benchmark as feedback

PERIOD = 0.01


def cycles(block, context, measured, command, count):
    block.GetInputPort("measured_position").FixValue(context, measured)
    block.GetInputPort("commanded_position").FixValue(context, command)
    for _ in range(count):
        context.SetDiscreteState(block.EvalUniquePeriodicDiscreteUpdate(context))
    return block.get_output_port(0).Eval(context).copy()


def test_it_begins_at_the_measurement_and_takes_over_a_difference_with_its_time_constant():
    block = fd.SlowFeedback(2, period=PERIOD, time_constant=0.2)
    context = block.CreateDefaultContext()
    measured, command = np.array([1.0, -2.0]), np.array([0.5, 0.0])
    np.testing.assert_array_equal(cycles(block, context, measured, command, 0), measured)
    for seconds in (0.2, 0.4):
        seen = cycles(block, context, measured, command, 20)
        share = 1.0 - np.exp(-seconds / 0.2)
        np.testing.assert_allclose(seen, command + share * (measured - command), rtol=1e-9)
    seen = cycles(block, context, measured, command, 500)
    np.testing.assert_allclose(seen, measured, rtol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_measurement_that_is_lost_is_shown_and_forgotten(bad):
    block = fd.SlowFeedback(1, period=PERIOD)
    context = block.CreateDefaultContext()
    cycles(block, context, np.array([0.3]), np.array([0.2]), 3)
    before = cycles(block, context, np.array([0.3]), np.array([0.2]), 0)
    assert not np.isfinite(cycles(block, context, np.array([bad]), np.array([0.2]), 5)).any()
    assert block.GetOutputPort("valid").Eval(context) == 0.0
    after = cycles(block, context, np.array([0.3]), np.array([0.2]), 0)
    np.testing.assert_array_equal(after, before)


def test_in_a_loop_the_command_starts_at_the_robot_and_a_droop_is_made_up_for():
    """A robot that hangs 0.05 rad below its command in every joint: its tool reaches the target."""
    arm = fd.load_arm("arm7")
    start, droop = np.full(7, 0.3), np.full(7, -0.05)
    target = arm.forward_kinematics(np.full(7, 0.4))[:3, 3]
    builder, plant = DiagramBuilder(), fd.MakeDhArmPlant(arm)
    config = fd.FuzzyIkConfig(measured_position=True, control_rate=100.0)
    ik = fd.AddFuzzyIkController(builder, plant, config=config)
    slow = builder.AddSystem(fd.SlowFeedback(7, period=config.period))
    source = builder.AddSystem(ConstantVectorSource(target))
    builder.Connect(source.get_output_port(), ik.get_input_port(0))
    command = ik.GetOutputPort("commanded_position")
    builder.Connect(command, slow.GetInputPort("commanded_position"))
    builder.Connect(slow.get_output_port(0), ik.GetInputPort("estimated_position"))
    builder.ExportInput(slow.GetInputPort("measured_position"), "measured")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    own = ik.GetMyContextFromRoot(root)
    measured = start
    for k in range(200):
        diagram.get_input_port().FixValue(root, measured)
        simulator.AdvanceTo((k + 0.5) * config.period)
        if k == 0:
            assert np.abs(command.Eval(own) - start).max() < 0.1
        measured = command.Eval(own) + droop
    error = np.linalg.norm(arm.forward_kinematics(measured)[:3, 3] - target)
    assert error < 1e-3 < np.linalg.norm(arm.forward_kinematics(measured - droop)[:3, 3] - target)


def test_behind_an_inner_loop_it_follows_a_path_closer_than_drake_s_integrator():
    """kp 1000, measurements 5 ms late with 1e-3 rad of noise; `fikm-drake benchmark feedback`."""
    mean = {}
    for name in ("fuzzy, resolved rate, slow feedback", "Drake's integrator, open loop"):
        result = feedback.run(name, feedback.controllers()[name], 4, 1000.0, 5, 1e-3)
        assert result.fastest < 1.3  # of the robot behind its inner loop
        mean[name] = result.mean
    ours, drakes = mean.values()
    assert ours < 0.5 * drakes


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_errors_name_the_bad_time_constant(bad):
    with pytest.raises(ValueError, match="time_constant"):
        fd.SlowFeedback(7, period=PERIOD, time_constant=bad)
