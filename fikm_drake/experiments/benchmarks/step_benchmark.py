"""Cost of one control step in a Simulator, ours beside Drake's (`fikm-drake benchmark step`)."""

import dataclasses
import gc
import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from fikm_drake.diagrams.add_fuzzy_ik_controller import MakeFuzzyIkController
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.native.kernel import numpy_only
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.simulation.scenario import Scenario, load_scenario

SCENARIO = "table6_5s"
POSE_LAW = FuzzyMapping.iterated()
"""What is recommended for poses."""
VELOCITY_LIMIT = 2.0
"""Velocity limit of every joint, for Drake's usual set-up [rad/s]; the path needs less."""
DRAKE_USUAL = "Drake integrator, pose, velocity limits"
DRAKE_LEAST = "Drake integrator, position only, no limits"

Step = Callable[[int], float]


@dataclasses.dataclass(frozen=True)
class StepCost:
    """CPU time of a step."""

    name: str
    microseconds: float
    """Median over all steps [µs]."""
    to_usual: float
    """Median over the rounds of the time over that of `DRAKE_USUAL` in the same round [-]."""
    to_least: float
    """The same over that of `DRAKE_LEAST` [-]."""


def step_benchmark(
    *, rounds: int = 20, progress: Callable[[float], None] | None = None
) -> list[StepCost]:
    """Time a step of the Diagram, of the fused block and of Drake's differential IK integrator.

    All follow the same moving target with arm7 at the same rate, each alone in a Simulator. The
    target is set between the steps, outside the time taken; what is timed is `Simulator.AdvanceTo`
    over one period. They take turns, a path each, so that a noisy machine disturbs them alike.

    Drake's `DifferentialInverseKinematicsIntegrator` runs twice: as its examples set it up, for a
    pose and with joint velocity limits, and with the least to do: position only. Ours run twice as well,
    for a position as in the paper and for a pose with the recommended law, `POSE_LAW`; both keep the
    plant's limits. Where there is the native kernel they use it; the fused block runs without it too, and for
    positions with a restart search, which has nothing to do, and with limits of acceleration, which it
    brakes for. A block of one line of Python says what the framework takes.

    Args:
        rounds: how often each follows the whole path.
        progress: called after each round with the fraction done.

    Raises:
        ValueError: rounds is not positive.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be positive, got {rounds}")
    scenario = load_scenario(SCENARIO)
    makers = {
        DRAKE_USUAL: _drake_step(usual=True),
        DRAKE_LEAST: _drake_step(usual=False),
        "a Python block that reads and writes": _floor,
        "fikm_drake Diagram": _our_step(fused=False),
        "fikm_drake fused": _our_step(fused=True),
        "fikm_drake fused, numpy": _our_step(fused=True, native=False),
        "fikm_drake fused, restart search": _our_step(fused=True, restart_search=True),
        "fikm_drake fused, limits of acceleration": _our_step(fused=True, acceleration=20.0),
        "fikm_drake Diagram, pose": _our_step(fused=False, pose=True),
        "fikm_drake fused, pose": _our_step(fused=True, pose=True),
        "fikm_drake fused, pose, numpy": _our_step(fused=True, pose=True, native=False),
    }
    times: dict[str, list[list[float]]] = {name: [] for name in makers}
    with quiet_drake():
        for i in range(rounds):
            for name, make in makers.items():
                times[name].append(_follow(make(scenario), scenario.num_cycles))
            if progress:
                progress((i + 1) / rounds)
    medians = {name: [median(path) for path in paths] for name, paths in times.items()}

    def ratio(name: str, reference: str) -> float:
        return median(t / d for t, d in zip(medians[name], medians[reference]))

    return [
        StepCost(
            name,
            1e6 * median(t for path in paths for t in path),
            ratio(name, DRAKE_USUAL),
            ratio(name, DRAKE_LEAST),
        )
        for name, paths in times.items()
    ]


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = step_benchmark(rounds=rounds, progress=progress)
    lines = [
        "one control step of arm7 in a Simulator, CPU time (median), over Drake's usual and least"
    ]
    lines += [
        f"  {cost.name:44s} {cost.microseconds:6.1f} µs  {cost.to_usual:5.2f}  {cost.to_least:5.2f}"
        for cost in costs
    ]
    return BenchmarkTable(lines, costs)


def _follow(step: Step, cycles: int) -> list[float]:
    """CPU time of each step [s], undisturbed by the garbage collector."""
    gc.collect()
    gc.disable()
    try:
        return [step(k) for k in range(cycles)]
    finally:
        gc.enable()


def _floor(scenario: Scenario) -> Step:
    """A block that takes a target and keeps it."""
    block = _Keeper(1.0 / scenario.control_rate)
    simulator = Simulator(block)
    context, targets = simulator.get_mutable_context(), list(scenario.targets())
    port = block.GetInputPort("target")
    return _timed(simulator, lambda k: port.FixValue(context, targets[k]), scenario)


class _Keeper(LeafSystem):
    def __init__(self, period: float) -> None:
        super().__init__()
        self._target = self.DeclareVectorInputPort("target", 3).Eval
        self.DeclareDiscreteState(3)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        discrete_state.get_mutable_value(0)[:] = self._target(context)


def _our_step(
    *,
    fused: bool,
    pose: bool = False,
    native: bool = True,
    restart_search: bool = False,
    acceleration: float | None = None,
) -> Callable[[Scenario], Step]:
    def make(scenario: Scenario) -> Step:
        if not native:
            with numpy_only():
                step = with_kernel(scenario)

            def without_kernel(k: int) -> float:
                with numpy_only():
                    return step(k)

            return without_kernel
        return with_kernel(scenario)

    def with_kernel(scenario: Scenario) -> Step:
        plant = MakeDhArmPlant(scenario.load_arm())
        config = dataclasses.replace(scenario.controller_config(), fused=fused)
        config.restart_search = restart_search
        if acceleration:
            config.acceleration_limits = [acceleration]
        if pose:
            config = dataclasses.replace(config, task="pose", law=POSE_LAW)
        controller = MakeFuzzyIkController(plant, config=config)
        simulator = Simulator(controller)
        context = simulator.get_mutable_context()
        controller.SetPositions(context, scenario.start())
        targets: Sequence[Any] = list(scenario.targets())
        if pose:
            R_WE = RotationMatrix(scenario.load_arm().forward_kinematics(scenario.start())[:3, :3])
            targets = [Value(RigidTransform(R_WE, p)) for p in targets]
        port = controller.GetInputPort("desired_pose" if pose else "desired_position")
        return _timed(simulator, lambda k: port.FixValue(context, targets[k]), scenario)

    return make


def _drake_step(*, usual: bool) -> Callable[[Scenario], Step]:
    def make(scenario: Scenario) -> Step:
        plant = MakeDhArmPlant(scenario.load_arm())
        n, period = plant.num_positions(), 1.0 / scenario.control_rate
        parameters = DifferentialInverseKinematicsParameters(n, n)
        parameters.set_time_step(period)
        parameters.set_nominal_joint_position(scenario.start())
        if usual:
            limit = np.full(n, VELOCITY_LIMIT)
            parameters.set_joint_velocity_limits((-limit, limit))
        else:
            parameters.set_end_effector_velocity_flag([False] * 3 + [True] * 3)
        integrator = DifferentialInverseKinematicsIntegrator(
            plant, plant.GetFrameByName("tool"), period, parameters
        )
        simulator = Simulator(integrator)
        context = simulator.get_mutable_context()
        integrator.SetPositions(context, scenario.start())
        X_WE = integrator.ForwardKinematics(context)
        poses = [Value(RigidTransform(X_WE.rotation(), p)) for p in scenario.targets()]
        port = integrator.GetInputPort("X_AE_desired")
        return _timed(simulator, lambda k: port.FixValue(context, poses[k]), scenario)

    return make


def _timed(simulator: Simulator, set_target: Callable, scenario: Scenario) -> Step:
    simulator.Initialize()
    period = 1.0 / scenario.control_rate

    def step(k: int) -> float:
        set_target(k)
        end = (k + 0.5) * period
        start = time.process_time()
        simulator.AdvanceTo(end)
        return time.process_time() - start

    return step
