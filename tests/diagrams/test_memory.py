"""A long run keeps nothing of what is past."""

import gc
import os
import tracemalloc

import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

import fikm_drake as fd

WARM, STEPS, RATE = 20_000, 100_000, 1000.0
"""Cycles before the first look, cycles after it, cycles a second."""


def resident():
    """Memory of this process [bytes]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def moving_target():
    """A target that wanders for the whole run and is lost for none of it."""
    seconds = int((WARM + STEPS) / RATE) + 1
    knots = [
        [0.4 + 0.1 * (k % 3), -0.5 + 0.1 * (k % 2), 0.3 - 0.1 * (k % 5)] for k in range(seconds)
    ]
    return PiecewisePolynomial.FirstOrderHold(list(range(seconds)), list(zip(*knots)))


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs Linux's /proc")
def test_100000_steps_without_growth_of_memory(plant, fused):
    builder = DiagramBuilder()
    config = fd.FuzzyIkConfig(fused=fused, control_rate=RATE)
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    source = builder.AddSystem(TrajectorySource(moving_target()))
    builder.Connect(source.get_output_port(), controller.GetInputPort("desired_position"))
    simulator = Simulator(builder.Build())
    status = controller.GetOutputPort("status")
    context = controller.GetMyContextFromRoot(simulator.get_context())

    def look(cycles):
        simulator.AdvanceTo(cycles / RATE)
        assert status.Eval(context)[0] != fd.ControllerStatus.INVALID_INPUT
        gc.collect()
        return resident()

    before = look(WARM)
    grown = look(WARM + STEPS - 20_000) - before
    tracemalloc.start()
    try:
        look(WARM + STEPS - 18_000)
        traced = tracemalloc.get_traced_memory()[0]
        look(WARM + STEPS)
        traced = tracemalloc.get_traced_memory()[0] - traced
    finally:
        tracemalloc.stop()
    print(f"\nfused {fused}: resident +{grown} bytes in 80000 steps, Python +{traced} in 18000")
    assert grown < 4e6  # 50 bytes a step would be more
    assert traced < 1e5  # 6 bytes a step would be more
