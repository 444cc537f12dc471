"""Cost of a law alone and of a cycle of differential IK (`fikm-drake benchmark cycle`)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DoDifferentialInverseKinematics,
)

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.interleaved import interleaved
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.jacobian_transpose import JacobianTranspose
from fikm_drake.laws.law import Law
from fikm_drake.laws.pseudo_inverse import PseudoInverse

ARM, POSTURE = "iiwa14", (0.1, 0.6, -0.2, -1.4, 0.3, 1.0, 0.4)
TASKS = {"position": 3, "pose": 6}
"""Tasks by name, and their rows."""
FUZZY, DRAKE = "fuzzy mapping", "Drake DoDifferentialInverseKinematics"
CALLS = 100
PERIOD = 0.01
"""[s]"""


@dataclass(frozen=True)
class CycleCost:
    """CPU time of a law or of a cycle."""

    rows: int
    """Rows of the task."""
    whole: bool
    """A cycle from joint positions to a joint step; else the law alone, with its Jacobian given."""
    name: str
    microseconds: float
    """Median over the rounds [µs]."""
    ratio: float
    """Median over the rounds of the time over that of `FUZZY` in the same round [-]."""


def cycle_benchmark(
    *, rounds: int = 40, progress: Callable[[float], None] | None = None
) -> list[CycleCost]:
    """Time laws alone, and cycles: joint positions and target to a joint step, with Drake's Jacobian.

    The cycles are calls of functions, not of blocks in a Simulator, for an iiwa14; Drake's
    `DoDifferentialInverseKinematics` has its pose task, or its position rows only, and joint velocity
    limits in both.

    Args:
        rounds: how often they take turns.
        progress: called after each task with the fraction done.

    Raises:
        ValueError: rounds is not positive.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be positive, got {rounds}")
    plant = MakeDhArmPlant(load_arm(ARM))
    q = np.array(POSTURE)
    costs = []
    for i, (task, rows) in enumerate(TASKS.items()):
        kinematics = as_task(plant, "tool", task)
        J = np.ascontiguousarray(kinematics.jacobian(q))
        for whole, calls in (
            (False, _laws(J, np.full(rows, 0.01))),
            (True, _cycles(kinematics, q)),
        ):
            times = interleaved(calls, rounds=rounds, repeats=CALLS)
            costs += [
                CycleCost(
                    rows,
                    whole,
                    name,
                    1e6 * median(spent),
                    median(s / f for s, f in zip(spent, times[FUZZY])),
                )
                for name, spent in times.items()
            ]
        if progress:
            progress((i + 1) / len(TASKS))
    return costs


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    results = cycle_benchmark(rounds=rounds, progress=progress)
    lines = [f"CPU time of a call (median), {ARM}, and over that of the fuzzy mapping"]
    for cost in results:
        what = "cycle with Drake's Jacobian" if cost.whole else "law alone"
        lines.append(
            f"  {cost.rows} rows, {what:28s} {cost.name:38s}"
            f" {cost.microseconds:7.1f} µs  {cost.ratio:5.2f}"
        )
    return BenchmarkTable(lines, results)


def laws() -> dict[str, Law]:
    """What is compared."""
    return {
        FUZZY: FuzzyMapping(),
        "fuzzy mapping, 3 iterations": FuzzyMapping(iterations=3, damping=0.1, row_floor=0.05),
        "damped least squares": DampedLeastSquares(),
        "pseudo-inverse": PseudoInverse(),
        "Jacobian transpose": JacobianTranspose(),
    }


def _laws(J: Array, dr: Array) -> dict[str, Callable[[], Any]]:
    return {name: partial(law.step, J, dr) for name, law in laws().items()}


def _cycles(kinematics: TaskKinematics, q: Array) -> dict[str, Callable[[], Any]]:
    """Each from joint positions and a target to a joint step."""
    context = kinematics.arm.plant.CreateDefaultContext()
    kinematics.arm.plant.SetPositions(context, q)
    X = kinematics.arm.plant.GetFrameByName("tool").CalcPoseInWorld(context)
    X = RigidTransform(X.rotation(), X.translation() + 0.01)
    target = X if kinematics.size == 6 else X.translation()

    def cycle(law: Law) -> Callable[[], Any]:
        def call() -> Array:
            error, J = kinematics.error_and_jacobian(target, q)
            return law.step(J, error)

        return call

    cycles = {name: cycle(law) for name, law in laws().items()}
    return cycles | {DRAKE: _drake(kinematics, q, X)}


def _drake(kinematics: TaskKinematics, q: Array, X: RigidTransform) -> Callable[[], Any]:
    plant = kinematics.arm.plant
    n = plant.num_positions()
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(PERIOD)
    parameters.set_nominal_joint_position(q)
    limit = kinematics.arm.velocity_limits
    parameters.set_joint_velocity_limits((-limit, limit))
    if kinematics.size == 3:
        parameters.set_end_effector_velocity_flag([False] * 3 + [True] * 3)
    context, frame = plant.CreateDefaultContext(), plant.GetFrameByName("tool")

    def call() -> Any:
        plant.SetPositions(context, q)
        return DoDifferentialInverseKinematics(plant, context, X, frame, parameters)

    return call
