"""The loop closed over the measured joints of a robot that is late."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    DiscreteTimeDelay,
    FirstOrderLowPassFilter,
    LogVectorOutput,
)

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

PERIOD = 0.02
Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
TARGET = np.array([0.5, -0.45, 0.3])


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def in_simulator(plant, config, lag, target, duration, start=Q0):
    """The controller with the command fed back through `lag`, or through nothing; its last error."""
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    source = builder.AddSystem(ConstantVectorSource(target))
    builder.Connect(source.get_output_port(), controller.GetInputPort("desired_position"))
    builder.AddSystem(lag)
    builder.Connect(controller.GetOutputPort("commanded_position"), lag.get_input_port())
    builder.Connect(lag.get_output_port(), controller.GetInputPort("estimated_position"))
    sinks = {
        name: LogVectorOutput(controller.GetOutputPort(name), builder, config.period)
        for name in ("task_error", "status", "commanded_position", "joint_step")
    }
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), start)
    own = lag.GetMyMutableContextFromRoot(root)
    if isinstance(lag, FirstOrderLowPassFilter):
        lag.set_initial_output_value(own, start)
    else:
        delayed = own.get_mutable_discrete_state_vector()
        delayed.SetFromVector(np.tile(start, delayed.size() // len(start)))
    simulator.AdvanceTo(duration)
    return {name: sink.FindLog(root).data().T.copy() for name, sink in sinks.items()}


def largest_gain(delay):
    """Below this K every λ of J C⁻¹ Jᵀ R⁻¹, at most 1, gives a stable loop with so many cycles' delay.

    e is the integral of −λ d, delayed, and d = K e / 3 + 2/3 of the last d (equation 31):
    z^delay (z − 1)(z − 2/3) + λ K z / 3 = 0.
    """

    def stable(gain):
        polynomial = np.zeros(delay + 3)
        polynomial[:3] = 1, -5 / 3, 2 / 3
        polynomial[-2] += gain / 3
        return np.abs(np.roots(polynomial)).max() < 1

    low, high = 0.0, 20.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def test_largest_gain_without_delay_is_that_of_the_paper_s_filter():
    """Stable for 0 < λK < 10, Schur bound, paper's filter; one cycle's delay leaves a tenth of it."""
    assert largest_gain(0) == pytest.approx(10.0)
    assert largest_gain(1) == pytest.approx(1.0)
    assert largest_gain(3) < largest_gain(2) < 1.0


def late_by(cycles):
    """Drake's delay takes its sample before the update of the same instant: one cycle more."""
    return DiscreteTimeDelay(PERIOD, cycles - 1, 7)


def constant_gain(gain):
    return fd.GainSupervisorConfig(
        gains=[gain] * 3, oscillating_gains=[gain] * 3, initial_gain=gain
    )


@pytest.mark.parametrize("delay", [1, 2, 3])
def test_converges_on_a_robot_that_is_late(plant, fused, delay):
    gain = 0.8 * largest_gain(delay)
    config = fd.FuzzyIkConfig(fused=fused, measured_position=True, supervisor=constant_gain(gain))
    series = in_simulator(plant, config, late_by(delay), TARGET, 20.0)
    assert lengths(series["task_error"])[-1] < config.tolerance
    assert series["status"][-1] == Status.CONVERGED
    assert lengths(series["joint_step"])[-50:].max() < 1e-3


def test_converges_on_a_robot_that_follows_with_a_lag(plant, fused):
    """A time constant of one cycle leaves Table I's gains stable."""
    config = fd.FuzzyIkConfig(fused=fused, measured_position=True)
    series = in_simulator(plant, config, FirstOrderLowPassFilter(PERIOD, 7), TARGET, 8.0)
    assert lengths(series["task_error"])[-1] < 1e-6
    assert series["status"][-1] == Status.CONVERGED


def test_table_1_is_too_fast_for_a_robot_that_is_late(plant, fused):
    """What `measured_position` warns of; bounded all the same, and never NaN. The calm ends the swings."""
    swings = {}
    for calming in (1.0, 0.8):
        supervisor = fd.GainSupervisorConfig(calming=calming)
        config = fd.FuzzyIkConfig(fused=fused, measured_position=True, supervisor=supervisor)
        series = in_simulator(plant, config, late_by(2), TARGET, 12.0)
        assert all(np.isfinite(values).all() for values in series.values())
        swings[calming] = lengths(series["joint_step"])[-100:].max()
        if calming == 1.0:
            assert lengths(series["task_error"])[-100:].max() > 0.1
    assert swings[1.0] > 0.1 and swings[0.8] < 1e-4


def test_a_perfect_measurement_changes_nothing(plant, run, fused):
    desired = np.tile(TARGET, (100, 1))
    own = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, desired)
    config = fd.FuzzyIkConfig(fused=fused, measured_position=True)
    measured = run(plant, config, Q0, desired, lambda k, commanded: commanded)
    for name in own:
        np.testing.assert_array_equal(own[name], measured[name], err_msg=name)
