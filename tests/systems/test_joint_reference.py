"""The reference of an inner loop: straight lines between the samples of a command."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

import fikm_drake as fd

PERIOD, STEP = 0.02, 0.001
FREE = 1e9
"""An acceleration that limits nothing here [rad/s²]."""


def make(n, step=STEP, speed=np.inf, acceleration=FREE):
    return fd.JointReference(
        n,
        period=PERIOD,
        time_step=step,
        velocity_limits=np.full(n, speed),
        acceleration_limits=acceleration,
    )


def reference_of(steps, step=STEP, **limits):
    """The desired states (N,2n) at the inner loop's times, for these joint steps a cycle."""
    n = steps.shape[1]
    builder = DiagramBuilder()
    integrator = builder.AddSystem(
        fd.JointIntegrator(
            np.full(n, -np.inf), np.full(n, np.inf), period=PERIOD, initial_position=np.zeros(n)
        )
    )
    reference = builder.AddSystem(make(n, step, **limits))
    builder.Connect(integrator.GetOutputPort("position"), reference.get_input_port(0))
    builder.Connect(integrator.GetOutputPort("velocity"), reference.get_input_port(1))
    sink = LogVectorOutput(reference.get_output_port(), builder, step)
    builder.ExportInput(integrator.GetInputPort("joint_step"), "joint_step")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    for k, joint_step in enumerate(steps):
        diagram.get_input_port().FixValue(root, joint_step)
        simulator.AdvanceTo((k + 1) * PERIOD - 0.25 * step)
    return sink.FindLog(root).data().T


def test_reaches_each_command_at_the_end_of_its_cycle_on_a_straight_line():
    steps = np.random.default_rng(0).normal(scale=0.05, size=(200, 3))
    log = reference_of(steps)
    corners = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    times = np.arange(len(log)) * STEP
    expected = np.stack(
        [np.interp(times, PERIOD * np.arange(len(corners)), c) for c in corners.T], axis=1
    )
    np.testing.assert_allclose(log[:, :3], expected, atol=1e-12)
    slopes = np.repeat(steps / PERIOD, round(PERIOD / STEP), axis=0)
    np.testing.assert_allclose(log[1:, 3:], slopes[: len(log) - 1], atol=1e-9)


@pytest.mark.parametrize("step", [0.003, 0.0007, 0.02])
def test_any_time_step_does(step):
    """Also where the period is no multiple of it: on the line between the samples."""
    steps = np.random.default_rng(1).normal(scale=0.05, size=(50, 1))
    log = reference_of(steps, step)
    corners = np.concatenate([np.zeros((1, 1)), np.cumsum(steps, axis=0)])[:, 0]
    times = np.arange(len(log)) * step
    expected = np.interp(times, PERIOD * np.arange(len(corners)), corners)
    # A step that straddles the end of a cycle stays at the cycle's end.
    slack = step * np.abs(steps).max() / PERIOD + 1e-12
    assert np.abs(log[:, 0] - expected).max() <= slack


@pytest.mark.parametrize("port", ["commanded_position", "commanded_velocity"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_holds_while_an_input_is_not_finite(port, bad, drive):
    driver = drive(make(2))
    good = {"commanded_position": np.array([0.1, 0.2]), "commanded_velocity": np.array([1.0, -1.0])}
    driver.feed(**good).update()
    moving = driver["desired_state"]
    driver.feed(**good | {port: np.array([0.0, bad])}).update()
    held = driver["desired_state"]
    np.testing.assert_allclose(held[:2], moving[:2], atol=1e-9)
    np.testing.assert_allclose(held[2:], [0.0, 0.0], atol=1e-6)


def test_limits_of_velocity_and_acceleration_hold():
    """A step of the command of 0.5 rad in a cycle, as an arm can do it; then it is there."""
    steps = np.zeros((60, 1))
    steps[0] = 0.5
    log = reference_of(steps, speed=1.2, acceleration=20.0)
    speed = log[:, 1]
    assert speed.max() == pytest.approx(1.2)
    assert np.abs(np.diff(speed)).max() <= 20.0 * STEP * (1 + 1e-9)
    np.testing.assert_allclose(np.diff(log[:, 0]), STEP * speed[1:], atol=1e-12)
    assert log[:, 0].max() <= 0.5 + 20.0 * STEP**2
    np.testing.assert_allclose(log[-1], [0.5, 0.0], atol=1e-6)


def test_set_positions_is_at_rest(drive):
    reference = make(2)
    context = reference.CreateDefaultContext()
    reference.SetPositions(context, [0.3, -0.4])
    np.testing.assert_array_equal(reference.get_output_port().Eval(context), [0.3, -0.4, 0.0, 0.0])
    for bad in ([0.3], [0.3, np.nan]):
        with pytest.raises(ValueError, match="joint position must be 2 finite numbers"):
            reference.SetPositions(context, bad)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"velocity_limits": [1.0]}, ["velocity_limits", "2", "[1.0]"]),
        ({"velocity_limits": [1.0, 0.0]}, ["velocity_limits", "[1.0, 0.0]"]),
        ({"velocity_limits": [1.0, np.nan]}, ["velocity_limits", "nan"]),
        ({"acceleration_limits": 0.0}, ["acceleration_limits", "0.0"]),
        ({"acceleration_limits": np.inf}, ["acceleration_limits", "inf"]),
        ({"period": 0.0}, ["period", "0.0"]),
        ({"time_step": np.nan}, ["time_step", "nan"]),
        ({"time_step": 0.05}, ["time_step", "0.05", "0.02"]),
    ],
)
def test_bad_arguments_are_named(changes, words):
    good = {"period": PERIOD, "time_step": STEP, "velocity_limits": [1.0, 1.0]}
    with pytest.raises(ValueError) as error:
        fd.JointReference(2, **good | {"acceleration_limits": 1.0} | changes)
    assert all(word in str(error.value) for word in words)
