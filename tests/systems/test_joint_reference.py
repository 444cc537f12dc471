"""The reference of an inner loop: straight lines between the samples of a command."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

import fikm_drake as fd

PERIOD, STEP = 0.02, 0.001


def reference_of(steps, step=STEP):
    """The desired states (N,2n) at the inner loop's times, for these joint steps a cycle."""
    n = steps.shape[1]
    builder = DiagramBuilder()
    integrator = builder.AddSystem(
        fd.JointIntegrator(
            np.full(n, -np.inf), np.full(n, np.inf), period=PERIOD, initial_position=np.zeros(n)
        )
    )
    reference = builder.AddSystem(fd.JointReference(n, period=PERIOD, time_step=step))
    builder.Connect(integrator.GetOutputPort("position"), reference.get_input_port(0))
    builder.Connect(integrator.GetOutputPort("velocity"), reference.get_input_port(1))
    sink = LogVectorOutput(reference.get_output_port(), builder, step)
    builder.ExportInput(integrator.get_input_port(), "joint_step")
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
    driver = drive(fd.JointReference(2, period=PERIOD, time_step=STEP))
    good = {"commanded_position": np.array([0.1, 0.2]), "commanded_velocity": np.array([1.0, -1.0])}
    driver.feed(**good).update()
    moving = driver["desired_state"]
    driver.feed(**good | {port: np.array([0.0, bad])}).update()
    held = driver["desired_state"]
    np.testing.assert_array_equal(held[:2], moving[:2])
    np.testing.assert_array_equal(held[2:], [0.0, 0.0])


def test_set_positions_is_at_rest(drive):
    reference = fd.JointReference(2, period=PERIOD, time_step=STEP)
    context = reference.CreateDefaultContext()
    reference.SetPositions(context, [0.3, -0.4])
    np.testing.assert_array_equal(reference.get_output_port().Eval(context), [0.3, -0.4, 0.0, 0.0])
    for bad in ([0.3], [0.3, np.nan]):
        with pytest.raises(ValueError, match="joint position must be 2 finite numbers"):
            reference.SetPositions(context, bad)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"period": 0.0}, ["period", "0.0"]),
        ({"time_step": np.nan}, ["time_step", "nan"]),
        ({"time_step": 0.05}, ["time_step", "0.05", "0.02"]),
    ],
)
def test_bad_arguments_are_named(changes, words):
    with pytest.raises(ValueError) as error:
        fd.JointReference(2, **{"period": PERIOD, "time_step": STEP} | changes)
    assert all(word in str(error.value) for word in words)
