"""The command supervisor as a block, and in the loop with a controller that chatters."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import DiscreteTimeIntegrator

import fikm_drake as fd

PERIOD = 0.01


class Relay(LeafSystem):
    """Full speed toward the target: the simplest controller that chatters for ever."""

    def __init__(self, target, speed):
        super().__init__()
        position = self.DeclareVectorInputPort("position", len(target))

        def calc(context, output):
            output.set_value(speed * np.sign(target - position.Eval(context)))

        self.DeclareVectorOutputPort("commanded_velocity", len(target), calc)


def test_output_is_gain_times_command(drive):
    supervision = fd.CommandSupervision(7)
    memory = supervision.initial_memory()
    driver = drive(fd.CommandSupervisor(7, period=PERIOD))
    rng = np.random.default_rng(0)
    for command in rng.normal(size=(60, 7)):
        outputs = driver.cycle(commanded_velocity=command)
        gain = supervision.gain(memory)
        np.testing.assert_array_equal(outputs["gain"], gain)
        np.testing.assert_array_equal(outputs["calmed_velocity"], gain * command)
        np.testing.assert_array_equal(outputs["oscillating"], supervision.oscillating(memory))
        supervision.remember(memory, command)
    assert outputs["oscillating"].any()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_command_that_is_not_finite_stops_the_arm_and_is_forgotten(bad, drive):
    driver = drive(fd.CommandSupervisor(2, period=PERIOD))
    driver.cycle(commanded_velocity=np.array([1.0, -1.0]))
    before = driver.state()
    outputs = driver.cycle(commanded_velocity=np.array([1.0, bad]))
    assert outputs["valid"] == 0
    np.testing.assert_array_equal(outputs["calmed_velocity"], [0.0, 0.0])
    np.testing.assert_array_equal(driver.state(), before)
    np.testing.assert_array_equal(
        driver.cycle(commanded_velocity=np.ones(2))["calmed_velocity"], np.ones(2)
    )


def test_a_relay_that_never_stops_is_left_with_the_least_gain():
    """Chatter that no gain can end is a hundredth of what it was; a new target is still reached."""
    target = np.array([0.5, -0.303])
    builder = DiagramBuilder()
    relay = builder.AddSystem(Relay(target, 1.0))
    supervisor = builder.AddSystem(fd.CommandSupervisor(2, period=PERIOD))
    integrator = builder.AddSystem(DiscreteTimeIntegrator(2, PERIOD))
    builder.Connect(relay.get_output_port(), supervisor.get_input_port())
    builder.Connect(supervisor.GetOutputPort("calmed_velocity"), integrator.get_input_port())
    builder.Connect(integrator.get_output_port(), relay.get_input_port())
    simulator = Simulator(builder.Build())
    context = integrator.GetMyContextFromRoot(simulator.get_context())
    positions = []
    for k in range(300):
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        positions.append(integrator.get_output_port().Eval(context).copy())
    speed = np.abs(np.diff(positions, axis=0)[-50:]) / PERIOD
    assert speed.max() <= 0.02
    np.testing.assert_allclose(positions[-1], target, atol=0.02)


@pytest.mark.parametrize(("argument", "value"), [("num_joints", 0), ("period", -1.0)])
def test_bad_arguments_are_named(argument, value):
    arguments = {"num_joints": 7, "period": PERIOD} | {argument: value}
    with pytest.raises(ValueError, match=argument):
        fd.CommandSupervisor(arguments["num_joints"], period=arguments["period"])
