"""Runs a scenario in Drake's Simulator."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource, VectorLogSink

from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController
from fikm_drake.diagrams.fuzzy_ik_torque_controller import AddFuzzyIkTorqueController
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.task import Task
from fikm_drake.laws.law import Law
from fikm_drake.simulation.tracking_log import TrackingLog
from fikm_drake.simulation.tracking_scenario import TrackingScenario

LOGGED = ("joint_step", "gain", "oscillating", "status")
TIME_STEP = 1e-3
"""Of a torque-driven arm [s]."""


class SimulationStopped(RuntimeError):
    """A run ended early; `log` holds the cycles that were done."""

    def __init__(self, log: TrackingLog, reason: BaseException) -> None:
        cycles = f"{len(log.time)} of {log.scenario.num_cycles} cycles"
        super().__init__(f"the run stopped after {cycles}: {str(reason) or type(reason).__name__}")
        self.log = log


def simulate(
    scenario: TrackingScenario,
    *,
    law: Law | None = None,
    progress: Callable[[float], None] | None = None,
) -> TrackingLog:
    """Build the Diagram of a scenario, run it in Drake's Simulator and return the log.

    Args:
        scenario: what to run.
        law: another law in place of the scenario's fuzzy mapping; the log does not keep it.
        progress: called now and then with the fraction of the run that is done.

    Raises:
        ValueError: the scenario is not valid.
        SimulationStopped: the run was interrupted or failed; the error carries the log so far.
    """
    scenario.validate()
    arm = scenario.load_arm()

    builder = DiagramBuilder()
    desired = builder.AddNamedSystem("desired", TrajectorySource(scenario.trajectory()))
    config = scenario.controller_config()
    if scenario.servo_bandwidth is None:
        controller = AddFuzzyIkController(builder, MakeDhArmPlant(arm), config=config, law=law)
        plant, position = None, controller.GetOutputPort("commanded_position")
    else:
        plant = builder.AddNamedSystem("plant", MakeDhArmPlant(arm, time_step=TIME_STEP))
        controller = AddFuzzyIkTorqueController(
            builder, plant, config=config, law=law, bandwidth=scenario.servo_bandwidth
        )
        position = plant.get_state_output_port()
    builder.Connect(desired.get_output_port(), controller.GetInputPort("desired_position"))
    period = 1.0 / scenario.control_rate
    sinks = {
        "desired": LogVectorOutput(desired.get_output_port(), builder, period),
        "position": LogVectorOutput(position, builder, period),
    }
    for name in LOGGED:
        sinks[name] = LogVectorOutput(controller.GetOutputPort(name), builder, period)
    diagram = builder.Build()
    diagram.set_name(f"{arm.name} tracking")

    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), scenario.start())
    if plant is not None:
        plant.SetPositions(plant.GetMyMutableContextFromRoot(root), scenario.start())

    def log() -> TrackingLog:
        last = position.Eval(position.get_system().GetMyContextFromRoot(root))
        return _collect(scenario, {name: _data(sink, root) for name, sink in sinks.items()}, last)

    try:
        for cycles in _chunks(scenario.num_cycles):
            # Short of the end of the last wanted cycle, so that rounding cannot add one, but past
            # the last time step of a torque-driven arm in it.
            simulator.AdvanceTo((cycles - 0.01) * period)
            if progress:
                progress(cycles / scenario.num_cycles)
    except (Exception, KeyboardInterrupt) as reason:
        if not sinks["desired"].FindLog(root).num_samples():
            raise
        raise SimulationStopped(log(), reason) from reason
    return log()


def _chunks(cycles: int) -> list[int]:
    """Cycles done at the end of each of at most 100 parts of a run."""
    return sorted({-(-cycles * part // 100) for part in range(1, 101)})


def _data(sink: VectorLogSink, root: Context) -> np.ndarray:
    """Samples (N, size), copied: Drake's are views."""
    return sink.FindLog(root).data().T.copy()


def _collect(
    scenario: TrackingScenario, data: dict[str, np.ndarray], last: np.ndarray
) -> TrackingLog:
    """The log of the cycles done: Drake publishes each sample before the cycle's update."""
    N = min(len(series) for series in data.values())
    data = {name: series[:N] for name, series in data.items()}
    q = np.concatenate([data["position"][1:], [last]])[:, : len(scenario.start())]
    coordinates = Task(scenario.controller_config().task).coordinates
    actual = scenario.load_arm().forward_kinematics(q)[:, coordinates, 3]
    return TrackingLog(
        scenario=scenario,
        time=np.arange(N) / scenario.control_rate,
        desired=data["desired"],
        actual=actual,
        q=q,
        joint_step=data["joint_step"],
        error=data["desired"] - actual,
        gain=data["gain"][:, 0],
        oscillating=data["oscillating"][:, 0] > 0.5,
        status=data["status"][:, 0].astype(np.int64),
    )
