"""A controller under a random case: the Diagram beside the fused block, and what must hold of both."""

import dataclasses
from collections.abc import Iterator
from math import acos, hypot
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd
from fikm_drake.arrays import Array
from fikm_drake.experiments.fuzz.random_case import RandomCase, Target, is_bad, random_case

ROUNDING = 1e-9
"""Relative; of positions, whose differences are compared."""

Violation = tuple[str, str]
"""Kind, and what was seen."""


def controller_case(rng: np.random.Generator) -> Iterator[list[Violation]]:
    """Run a random case and yield what each cycle violates.

    Raises:
        ValueError: the config is refused.
    """
    case = random_case(rng)
    runs = [_Run(case, fused) for fused in (False, True)]
    for k, target in enumerate(case.targets):
        inputs = target, case.noise[k], case.wishes[k]
        found = [violation for run in runs for violation in run.cycle(*inputs)]
        yield [*found, *_differences(*(run.seen for run in runs))]


class _Run:
    """One controller and its Context, cycle by cycle."""

    def __init__(self, case: RandomCase, fused: bool) -> None:
        self.case, self.name = case, "fused" if fused else "diagram"
        config = dataclasses.replace(case.config, fused=fused)
        self.system = fd.MakeFuzzyIkController(case.arm.plant, config=config)
        self.context = self.system.CreateDefaultContext()
        self.system.SetPositions(self.context, case.start)
        self.last = self.change = self.loop_step = np.zeros(len(case.start))
        plant, period = case.arm.plant, config.period
        self.fast = period * _least(config.velocity_limits, plant.GetVelocityUpperLimits())
        self.hard = period**2 * _least(
            config.acceleration_limits, plant.GetAccelerationUpperLimits()
        )
        jerks = np.full(len(case.start), np.inf)
        self.jerk = period**3 * _least(config.jerk_limits, jerks)
        """How much the change of a step may change."""
        self.seen: dict[str, Array] = {}

    def cycle(self, target: Target, noise: Array, wish: Array) -> list[Violation]:
        """Give the inputs, read every output, take the step; what was violated."""
        system, context = self.system, self.context
        port = system.get_input_port(0)
        port.FixValue(context, Value(target) if isinstance(target, RigidTransform) else target)
        before = system.GetOutputPort("commanded_position").Eval(context).copy()
        q = before + noise if self.case.measured else before
        if self.case.measured:
            system.GetInputPort("estimated_position").FixValue(context, q)
        if self.case.config.null_space_motion:
            system.GetInputPort("null_space_motion").FixValue(context, wish)
        ports = (system.get_output_port(i) for i in range(system.num_output_ports()))
        self.seen = {port.get_name(): port.Eval(context).copy() for port in ports}
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
        after = system.GetOutputPort("commanded_position").Eval(context).copy()
        state = context.get_discrete_state()
        values = [state.value(i) for i in range(state.num_groups())]
        q = q if self.case.config.measured_position else before
        found = [
            ("not finite", name)
            for name, value in [
                *self.seen.items(),
                *((f"state {i}", v) for i, v in enumerate(values)),
            ]
            if not np.isfinite(value).all()
        ]
        found += self._limits(before, after)
        found += self._status(target, q)
        self.change, self.last = after - before - self.last, after - before
        self.loop_step = self.seen["joint_step"]
        return [(kind, f"{self.name}: {what}") for kind, what in found]

    def _limits(self, before: Array, after: Array) -> Iterator[Violation]:
        arm, step = self.case.arm, after - before
        slack = ROUNDING * (np.abs(step) + np.abs(self.last)) + 1e-15 * (1.0 + np.abs(before))
        slack += 1e-15 * np.abs(after)
        if (after < arm.lower).any() or (after > arm.upper).any():
            yield "position limit", f"{after}"
        if (np.abs(step) > self.fast + slack).any():
            yield "speed limit", f"{np.max(np.abs(step) / self.fast)} times"
        if (np.abs(step - self.last) > self.hard + 2.0 * slack).any():
            yield "acceleration limit", f"{np.max(np.abs(step - self.last) / self.hard)} times"
        jerk = np.abs(step - self.last - self.change)
        if (jerk > self.jerk * (1.0 + ROUNDING) + 4.0 * slack + 4e-15 * np.abs(before)).any():
            yield "jerk limit", f"{np.max(jerk / self.jerk)} times"
        longest = self.case.config.max_joint_step
        if np.linalg.norm(step) > longest + np.linalg.norm(slack):
            yield "step length", f"{np.linalg.norm(step)} beyond {longest}"

    def _status(self, target: Target, q: Array) -> Iterator[Violation]:
        status, step = float(self.seen["status"][0]), self.seen["joint_step"]
        if status not in set(fd.ControllerStatus):
            yield "status unknown", str(status)
        if is_bad(target) or not np.linalg.norm(q) < 1e100:
            if status != fd.ControllerStatus.INVALID_INPUT:
                yield "bad input, good status", fd.ControllerStatus(int(status)).name
            braking = np.isfinite(self.hard) | np.isfinite(self.jerk)
            if (
                np.abs(step) > np.where(braking, np.abs(self.loop_step) * (1 + ROUNDING), 0.0)
            ).any():
                yield "bad input moves", str(np.abs(step).max())
        elif status == fd.ControllerStatus.CONVERGED:
            config = self.case.config
            error = true_error(self.case.arm.plant, config, target, q)
            if not error <= config.tolerance * (1.0 + 1e-6) + 1e-12 * self.case.arm.scale:
                yield "false CONVERGED", f"{error} m"


def true_error(plant: MultibodyPlant, config: fd.FuzzyIkConfig, target: Target, q: Array) -> float:
    """How far the tool is from a target by Drake's own kinematics, scaled as the task [m]."""
    context: Any = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    X_WE = plant.GetFrameByName(config.frame).CalcPoseInWorld(context)
    length, turn = config.characteristic_length, 0.0
    if isinstance(target, RigidTransform):
        R = X_WE.rotation().InvertAndCompose(target.rotation())
        turn = length * abs(R.ToAngleAxis().angle())
        gap = target.translation() - X_WE.translation()
        return turn if config.task == "orientation" else hypot(turn, float(np.linalg.norm(gap)))
    p = X_WE.translation()
    if config.task == "pointing":
        along = target[3:] @ X_WE.rotation().matrix()[:, 2] / np.linalg.norm(target[3:])
        turn = length * acos(min(1.0, max(-1.0, along)))
        turn = max(0.0, turn - 3e-8 * length)  # of acos
        return hypot(turn, float(np.linalg.norm(target[:3] - p)))
    axes = "xyz" if config.task == "position" else config.task
    return float(np.linalg.norm(target - p[["xyz".index(axis) for axis in axes]]))


def _differences(diagram: dict[str, Array], fused: dict[str, Array]) -> Iterator[Violation]:
    if list(diagram) != list(fused):
        yield "diagram is not fused", f"ports {list(diagram)} and {list(fused)}"
    for name, value in diagram.items():
        if not np.array_equal(value, fused[name], equal_nan=True):
            yield "diagram is not fused", f"{name}: {value} and {fused[name]}"


def _least(own: list[float], plants: Array) -> Array:
    return np.minimum(plants, own if len(own) else np.inf)
