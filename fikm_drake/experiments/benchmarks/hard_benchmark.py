"""A line, a large step and targets out of reach, ours beside others (`fikm-drake benchmark hard`)."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsStatus,
    DoDifferentialInverseKinematics,
)

from fikm_drake.arrays import Array
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.law import Law
from fikm_drake.laws.pseudo_inverse import PseudoInverse
from fikm_drake.simulation.scenario import Scenario, TrackingScenario, load_scenario
from fikm_drake.simulation.simulate import simulate

LAST = 50
"""Cycles at the end in which motion is measured [-]."""
OUT_OF_REACH = {"planar4": ([0.0, 2.0], 0.5), "arm7": ([2.0, 0.0, 0.0], 1.0)}
"""Targets by arm, from its stretched or its zero posture, and their distance from its reach [m]."""

Loop = Callable[[Scenario], Array]


@dataclass(frozen=True)
class HardResult:
    """What one method does."""

    name: str
    line: tuple[float, float]
    """Table VI's line in 5 s: largest and mean error [m]."""
    step: tuple[float, float]
    """The 4-joint arm from stretched to (0, 1): time until the error is under 1 mm for good [s], and the
    largest joint motion of a cycle [rad]."""
    beyond: dict[str, tuple[float, float]]
    """Out of reach: error over the least there is [m], joint speed at the end, rms [rad/s], by arm."""


def hard_benchmark(
    *, seconds: int = 10, progress: Callable[[float], None] | None = None
) -> list[HardResult]:
    """Run each method in a loop at 50 Hz.

    Ours in their controller; damped least squares, the pseudo-inverse and Drake's
    `DoDifferentialInverseKinematics` as they are used: a step a cycle for the whole error.

    Args:
        seconds: at a target that does not move [s].
        progress: called after each method with the fraction done.

    Raises:
        ValueError: seconds is not at least 2.
    """
    if seconds < 2:
        raise ValueError(f"seconds must be at least 2, got {seconds}")
    results = []
    methods = loops()
    for name, loop in methods.items():
        results.append(_measure(name, loop, seconds))
        if progress:
            progress(len(results) / len(methods))
    return results


def loops() -> dict[str, Loop]:
    """The methods: a scenario to the joint positions (N,n) after each cycle."""
    gain_1 = GainSupervisorConfig(gains=[1.0] * 3, oscillating_gains=[1.0] * 3)
    sharp = FuzzyIkConfig(
        law=FuzzyMapping(iterations=3, damping=0.05, row_floor=0.05),
        supervisor=gain_1,  # calm stays, which `resolved_rate` would leave out
        gain_smoothing=0.0,
        error_smoothing=0.0,
        singularity_nudge=0.0,
    )
    return {
        "fuzzy, as in the paper": partial(_ours, FuzzyIkConfig().as_in_paper()),
        "fuzzy, calm (default)": partial(_ours, FuzzyIkConfig()),
        "fuzzy, 3 iterations, unfiltered": partial(_ours, sharp),
        "damped least squares 0.05": partial(_plain, DampedLeastSquares(0.05)),
        "pseudo-inverse": partial(_plain, PseudoInverse()),
        "Drake DoDifferentialInverseKinematics": _drake,
    }


def table(seconds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    results = hard_benchmark(seconds=seconds, progress=progress)
    lines = [
        "50 Hz; Table VI's line in 5 s: e_max / e_mean [cm] | 4 joints, large step: 1 mm after [s],",
        "largest motion of a joint in a cycle [rad] | out of reach, 4 and 7 joints: error over the least",
        f"there is [mm] / joint speed left after {seconds} s, rms [rad/s]",
    ]
    for r in results:
        beyond = " | ".join(f"{1e3 * e:9.3f} / {v:8.2g}" for e, v in r.beyond.values())
        lines.append(
            f"  {r.name:38s} {100 * r.line[0]:6.3f} / {100 * r.line[1]:6.3f}"
            f" | {r.step[0]:5.2f} {r.step[1]:6.2f} | {beyond}"
        )
    return BenchmarkTable(lines, results)


def _measure(name: str, loop: Loop, seconds: float) -> HardResult:
    line = load_scenario("table6_5s")
    moving = round(line.target.duration * line.control_rate)
    errors = _errors(line, loop(line))[:moving]
    large = load_scenario("large_step_4")
    large = large.but(target__hold=seconds)
    q = loop(large)
    bad = np.flatnonzero(_errors(large, q) >= 1e-3)
    motion = np.abs(np.diff(np.vstack([large.start(), q]), axis=0)).max()
    beyond = {}
    for arm, (target, least) in OUT_OF_REACH.items():
        scenario = TrackingScenario(arm=arm, waypoints=[target], hold=seconds)
        q = loop(scenario)
        rest = np.diff(q[-LAST:], axis=0) * scenario.control_rate
        error = float(_errors(scenario, q)[-LAST:].mean())
        beyond[arm] = (error - least, float(np.sqrt((rest**2).mean())))
    return HardResult(
        name,
        (float(errors.max()), float(errors.mean())),
        ((bad[-1] + 1) / large.control_rate, float(motion)),
        beyond,
    )


def _errors(scenario: Scenario, q: Array) -> Array:
    """Length of the error after each cycle (N,)."""
    targets = scenario.targets()
    tool = scenario.load_arm().forward_kinematics(q)[:, : targets.shape[1], 3]
    return np.linalg.norm(tool - targets, axis=1)


def _ours(config: FuzzyIkConfig, scenario: Scenario) -> Array:
    fused = dataclasses.replace(config, fused=True)
    return simulate(scenario.with_config(fused)).cycles.q


def _plain(law: Law, scenario: Scenario) -> Array:
    """A step a cycle for the whole error, inside the joint limits."""
    plant = MakeDhArmPlant(scenario.load_arm())
    kinematics = as_task(plant, "tool", scenario.controller_config().task)
    lower, upper = kinematics.arm.lower, kinematics.arm.upper
    q, positions = scenario.start(), []
    for target in scenario.targets():
        error, J = kinematics.error_and_jacobian(target, q)
        q = np.clip(q + law.step(J, error), lower, upper)
        positions.append(q)
    return np.array(positions)


def _drake(scenario: Scenario) -> Array:
    """A step a cycle by Drake's function with its defaults, for the rows of the task."""
    plant = MakeDhArmPlant(scenario.load_arm())
    n, period = plant.num_positions(), 1.0 / scenario.control_rate
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(period)
    q, positions = scenario.start(), []
    parameters.set_nominal_joint_position(q)
    rows = len(scenario.corners[0])
    parameters.set_end_effector_velocity_flag([False] * 3 + [True] * rows + [False] * (3 - rows))
    context, frame = plant.CreateDefaultContext(), plant.GetFrameByName("tool")
    stuck = DifferentialInverseKinematicsStatus.kNoSolutionFound
    for target in scenario.targets():
        plant.SetPositions(context, q)
        X = frame.CalcPoseInWorld(context)
        desired = RigidTransform(X.rotation(), np.r_[target, np.zeros(3 - rows)])
        found = DoDifferentialInverseKinematics(plant, context, desired, frame, parameters)
        if found.status != stuck:
            q = q + period * found.joint_velocities
        positions.append(q)
    return np.array(positions)
