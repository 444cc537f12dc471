"""What the calm is for: motion that is left before targets out of reach, beside other methods."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsStatus,
    DoDifferentialInverseKinematics,
)
from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.rollout import rollout
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task import Task
from fikm_drake.kinematics.task_kinematics import PlantTask
from fikm_drake.kinematics.tasks import make_task
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

SECONDS = 11.0
"""[s]"""
READY = (0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0)
"""Ready posture of the iiwa14 [rad]."""
SHOULDER, REACH = np.array([0.0, 0.0, 0.36]), 0.42 + 0.40 + 0.126
"""Shoulder and reach of the iiwa14 [m]."""
BEYOND = 0.4
"""How far outside its reach its pose is [m]."""
CIRCLES = {"planar4": (2.0, "xy", 0.3), "iiwa14": (1.3, "position", 0.2)}
"""Circles out of reach: radius [m], task, speed [m/s]."""
MOVING = 1e-6
"""A joint that is slower does not turn round [rad/s]."""
OURS, WITHOUT, DAMPED, DRAKE = "fuzzy, calm", "without the calm", "damped l. sq. 0.05", "Drake"

Targets = list[Any]


@dataclass(frozen=True)
class Rest:
    """Motion in the last second before a target out of reach."""

    target: str
    method: str
    step: float
    """Largest of a joint in a cycle [rad]."""
    speed: float
    """Speed of the joints, rms [rad/s]."""
    reversals: int
    """Reversals of the joint that turns round most often."""
    roughness: float
    """Change of the joint step from cycle to cycle, rms of its length [rad]."""
    error: float
    """Largest in the second half [m]."""


@dataclass(frozen=True)
class _Case:
    name: str
    arm: str
    start: Array
    targets: Targets
    config: FuzzyIkConfig


def calm_out_of_reach(targets: Sequence[str] = ("",)) -> list[Rest]:
    """Each method before each target: those that rest, poses, and circles.

    Args:
        targets: beginnings of the names of those that are wanted; by default all.
    """
    methods: dict[str, Callable[[_Case, MultibodyPlant], tuple[Array, Array]]] = {
        OURS: lambda case, plant: _ours(case, plant, 0.8),
        WITHOUT: lambda case, plant: _ours(case, plant, 1.0),
        DAMPED: _damped,
        DRAKE: _drake,
    }
    rests = []
    with quiet_drake():
        for case in _cases():
            if not case.name.startswith(tuple(targets)):
                continue
            plant = MakeDhArmPlant(load_arm(case.arm))
            for name, method in methods.items():
                q, error = method(case, plant)
                rests.append(_rest(case, name, q, error))
    return rests


def rest_lines(rests: list[Rest]) -> list[str]:
    """The table's lines."""
    lines = [
        f"Out of reach, in the last of {SECONDS:g} s: joint step a cycle [rad], speed rms [rad/s],",
        "reversals of a joint, change of the step a cycle [rad]; largest error of the second half [m]",
    ]
    for i, r in enumerate(rests):
        if i == 0 or rests[i - 1].target != r.target:
            lines.append(f"  {r.target}")
        lines.append(
            f"    {r.method:19s} {r.step:8.1e} {r.speed:8.1e} {r.reversals:4d} {r.roughness:8.1e}"
            f"  {r.error:.4f}"
        )
    return lines


def _cases() -> list[_Case]:
    cases = []
    for arm, target in (
        ("planar4", (0.0, 2.0)),
        ("arm7", (2.0, 0.0, 0.0)),
        ("arm7", (-1.4, 0.9, 1.1)),
    ):
        config = FuzzyIkConfig(task="xy" if len(target) == 2 else "position")
        cycles = round(SECONDS * config.control_rate)
        start = np.zeros(load_arm(arm).num_joints)
        cases.append(_Case(f"{arm} {target}", arm, start, [np.array(target)] * cycles, config))
    sharp = FuzzyMapping.iterated()
    config = FuzzyIkConfig(task="pose", law=sharp, control_rate=100.0)
    home = load_arm("iiwa14").forward_kinematics(READY)
    for ray in ((0.5, 0.0, 0.4), (0.0, 1.0, 0.3), (0.0, 0.0, 1.0)):
        far = SHOULDER + (REACH + BEYOND) * np.array(ray) / np.linalg.norm(ray)
        pose = RigidTransform(RotationMatrix(home[:3, :3]), far)
        cycles = round(SECONDS * config.control_rate)
        name = f"iiwa14 pose {BEYOND:g} m out, {ray}"
        cases.append(_Case(name, "iiwa14", np.array(READY), [pose] * cycles, config))
    for arm, (radius, task, speed) in CIRCLES.items():
        config = FuzzyIkConfig(task=task)
        phase = np.arange(round(SECONDS * config.control_rate)) / config.control_rate
        phase *= speed / radius
        circle = radius * np.stack([np.cos(phase), np.sin(phase)], axis=1)
        if task == "position":
            circle = np.column_stack([circle, np.full(len(phase), SHOULDER[2])])
        start = np.full(load_arm(arm).num_joints, 0.1)
        cases.append(
            _Case(f"{arm} circle of {radius:g} m at {speed:g} m/s", arm, start, [*circle], config)
        )
    return cases


def _rest(case: _Case, method: str, q: Array, error: Array) -> Rest:
    rate = case.config.control_rate
    steps = np.diff(q, axis=0)[-round(rate) :]
    moving = np.where(np.abs(steps) * rate > MOVING, steps, 0.0)
    return Rest(
        target=case.name,
        method=method,
        step=float(np.abs(steps).max()),
        speed=float(np.sqrt((steps**2).mean()) * rate),
        reversals=int((moving[1:] * moving[:-1] < 0).sum(axis=0).max()),
        roughness=float(np.sqrt((np.diff(steps, axis=0) ** 2).sum(axis=1).mean())),
        error=float(error[len(error) // 2 :].max()),
    )


def _ours(case: _Case, plant: MultibodyPlant, calming: float) -> tuple[Array, Array]:
    task = _task(case, plant)
    supervisor = GainSupervisorConfig(calming=calming)
    cycle = ControlCycle(task, dataclasses.replace(case.config, supervisor=supervisor))
    path = rollout(cycle, case.targets, case.start)
    return np.vstack([case.start, path.q[:-1]]), np.linalg.norm(path.error, axis=1)


def _task(case: _Case, plant: MultibodyPlant) -> PlantTask:
    return make_task(PlantArm(plant, "tool"), case.config.task)


def _damped(case: _Case, plant: MultibodyPlant) -> tuple[Array, Array]:
    """A step a cycle for the whole error, inside the joint limits."""
    kinematics = _task(case, plant)
    lower, upper, law = kinematics.arm.lower, kinematics.arm.upper, DampedLeastSquares(0.05)
    q, positions, errors = case.start, [], []
    for target in case.targets:
        error, J = kinematics.error_and_jacobian(target, q)
        positions.append(q)
        errors.append(float(np.linalg.norm(error)))
        q = np.clip(q + law.step(J, error), lower, upper)
    return np.array(positions), np.array(errors)


def _drake(case: _Case, plant: MultibodyPlant) -> tuple[Array, Array]:
    """A step a cycle by Drake's `DoDifferentialInverseKinematics`, for the rows of the task."""
    kinematics = _task(case, plant)
    n, period = len(case.start), case.config.period
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(period)
    parameters.set_nominal_joint_position(case.start)
    task, lower, upper = Task(case.config.task), kinematics.arm.lower, kinematics.arm.upper
    rows = [i in task.rows for i in range(6)]
    parameters.set_end_effector_velocity_flag(rows)
    if task.turns:  # as its users have it: with the joints' limits
        parameters.set_joint_position_limits((lower, upper))
        speed = kinematics.arm.velocity_limits
        parameters.set_joint_velocity_limits((-speed, speed))
    context, frame = plant.CreateDefaultContext(), plant.GetFrameByName("tool")
    stuck = DifferentialInverseKinematicsStatus.kNoSolutionFound
    q, positions, errors = case.start, [], []
    for target in case.targets:
        positions.append(q)
        errors.append(float(np.linalg.norm(kinematics.error(target, q))))
        plant.SetPositions(context, q)
        desired = target
        if not task.turns:
            X = frame.CalcPoseInWorld(context)
            place = X.translation().copy()
            place[task.coordinates] = target
            desired = RigidTransform(X.rotation(), place)
        found = DoDifferentialInverseKinematics(plant, context, desired, frame, parameters)
        if found.status != stuck:
            q = np.clip(q + period * found.joint_velocities, lower, upper)
    return np.array(positions), np.array(errors)
