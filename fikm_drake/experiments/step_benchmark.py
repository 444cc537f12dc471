"""Cost of one control step in a Simulator, ours beside Drake's (`fikm-drake benchmark step`)."""

import dataclasses
import gc
import time
from collections.abc import Callable
from statistics import median

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from fikm_drake.diagrams.add_fuzzy_ik_controller import MakeFuzzyIkController
from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.simulation.tracking_scenario import TrackingScenario, load_scenario

SCENARIO = "table6_5s"
DRAKE = "Drake DifferentialInverseKinematicsIntegrator"

Step = Callable[[int], float]


@dataclasses.dataclass(frozen=True)
class StepCost:
    """CPU time of a step."""

    name: str
    microseconds: float
    """Median over all steps [µs]."""
    ratio: float
    """Median over the rounds of the time over Drake's in the same round [-]."""


def step_benchmark(
    *, rounds: int = 20, progress: Callable[[float], None] | None = None
) -> list[StepCost]:
    """Time a step of the Diagram, of the fused block and of Drake's differential IK integrator.

    All three follow the same moving target with arm7 at the same rate, each alone in a Simulator.
    The target is set between the steps, outside the time taken; what is timed is
    `Simulator.AdvanceTo` over one period. The three take turns step by step, so that a noisy
    machine disturbs them alike.

    Args:
        rounds: how often to follow the whole path.
        progress: called after each round with the fraction done.

    Raises:
        ValueError: rounds is not positive.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be positive, got {rounds}")
    scenario = load_scenario(SCENARIO)
    steps = {
        DRAKE: _drake_step,
        "fikm_drake Diagram": _our_step(fused=False),
        "fikm_drake fused": _our_step(fused=True),
    }
    runs: dict[str, list[list[float]]] = {name: [] for name in steps}
    for i in range(rounds):
        timers = {name: make(scenario) for name, make in steps.items()}
        times: dict[str, list[float]] = {name: [] for name in steps}
        gc.collect()
        gc.disable()
        try:
            for k in range(scenario.num_cycles):
                for name, step in timers.items():
                    times[name].append(step(k))
        finally:
            gc.enable()
        for name in steps:
            runs[name].append(times[name])
        if progress:
            progress((i + 1) / rounds)
    base = [median(times) for times in runs[DRAKE]]
    return [
        StepCost(
            name,
            1e6 * median(t for times in rounds_ for t in times),
            median(median(times) / reference for times, reference in zip(rounds_, base)),
        )
        for name, rounds_ in runs.items()
    ]


def _our_step(*, fused: bool) -> Callable[[TrackingScenario], Step]:
    def make(scenario: TrackingScenario) -> Step:
        plant = _plant(scenario)
        config = dataclasses.replace(scenario.controller_config(), fused=fused)
        controller = MakeFuzzyIkController(plant, config=config)
        simulator = Simulator(controller)
        context = simulator.get_mutable_context()
        controller.SetPositions(context, scenario.start())
        port = controller.GetInputPort("desired_position")
        targets = _targets(scenario)
        return _timed(simulator, lambda k: port.FixValue(context, targets[k]), scenario)

    return make


def _drake_step(scenario: TrackingScenario) -> Step:
    plant = _plant(scenario)
    tool = plant.GetFrameByName("tool")
    n = plant.num_positions()
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(1.0 / scenario.control_rate)
    parameters.set_end_effector_velocity_flag([False] * 3 + [True] * 3)  # position only
    parameters.set_nominal_joint_position(scenario.start())
    integrator = DifferentialInverseKinematicsIntegrator(
        plant, tool, 1.0 / scenario.control_rate, parameters
    )
    simulator = Simulator(integrator)
    context = simulator.get_mutable_context()
    integrator.SetPositions(context, scenario.start())
    X_WE = integrator.ForwardKinematics(context)
    poses = [Value(RigidTransform(X_WE.rotation(), p)) for p in _targets(scenario)]
    port = integrator.GetInputPort("X_AE_desired")
    return _timed(simulator, lambda k: port.FixValue(context, poses[k]), scenario)


def _timed(simulator: Simulator, set_target: Callable, scenario: TrackingScenario) -> Step:
    simulator.Initialize()
    period = 1.0 / scenario.control_rate

    def step(k: int) -> float:
        set_target(k)
        end = (k + 0.5) * period
        start = time.process_time()
        simulator.AdvanceTo(end)
        return time.process_time() - start

    return step


def _plant(scenario: TrackingScenario) -> MultibodyPlant:
    plant = MultibodyPlant(time_step=0.0)
    AddDhArm(plant, scenario.load_arm())
    plant.Finalize()
    return plant


def _targets(scenario: TrackingScenario) -> np.ndarray:
    trajectory = scenario.trajectory()
    times = np.arange(scenario.num_cycles) / scenario.control_rate
    return np.array([trajectory.value(t)[:, 0] for t in times])
