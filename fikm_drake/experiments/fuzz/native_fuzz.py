"""The native kernel's cycle under a random case: what Python's tick makes of the same state."""

import dataclasses
from collections.abc import Iterator

import numpy as np

import fikm_drake as fd
from fikm_drake.arrays import Array
from fikm_drake.control.cycle import CycleState
from fikm_drake.control.native_cycle import NativeCycle, native_cycle, packed
from fikm_drake.experiments.fuzz.controller_fuzz import Violation
from fikm_drake.experiments.fuzz.random_arm import RandomArm, random_arm
from fikm_drake.experiments.fuzz.random_case import (
    Target,
    random_config,
    random_noise,
    random_targets,
)
from fikm_drake.kinematics.native.kernel import numpy_only
from fikm_drake.kinematics.tasks import make_task

ROUNDING = 1e-12
"""Of each number of the state, over the largest of its kind or 1."""
CYCLES = (20, 300)
"""Cycles of a case."""
TASKS = ("position", "xy", "z", "orientation", "pose")


def native_case(rng: np.random.Generator) -> Iterator[list[Violation]]:
    """Run a random case and yield what each cycle violates; nothing where there is no kernel.

    The task and the law are the same on both sides; their own tests compare them with Drake and numpy.

    Raises:
        ValueError: the config is refused.
    """
    arm = random_arm(rng)
    config = _config(rng, arm)
    task = make_task(fd.PlantArm(arm.plant), config.task, config.characteristic_length)
    cycle = fd.ControlCycle(task, config)
    native = native_cycle(cycle)
    with numpy_only():
        reference = fd.ControlCycle(task, config)
    start = arm.posture(rng)
    state = cycle.start(start)
    count = int(rng.integers(*CYCLES))
    for target in random_targets(rng, arm, config.task, start, count):
        noise = random_noise(rng, len(start), arm.scale)
        q = state.command + noise if config.measured_position else state.command.copy()
        yield list(_compare(native, reference, state, target, q)) if native else []


def _compare(
    native: NativeCycle, reference: fd.ControlCycle, state: CycleState, target: Target, q: Array
) -> Iterator[Violation]:
    """A cycle on both sides; the state after it is Python's."""
    command, velocity, memory = state.command.copy(), state.velocity.copy(), packed(state)
    seen = native.tick(command, velocity, memory, target, q)
    done = native.advance(command, velocity, memory, target, q)
    tick = reference.tick(state, target, q)
    before = *(part.copy() for part in state[:2]), packed(state)
    reference.advance(state, target, q, tick)
    after = (state.command, state.velocity, packed(state)) if done else before
    for name, own, other in zip(
        ("command", "velocity", "memory"), (command, velocity, memory), after
    ):
        if not _equal(own, other):
            yield "native is not python", f"{name}: {own} and {other}"
    if (seen is None) == done:
        yield "native is not python", "a tick without a state's change, or one without a tick"
    if seen and (seen.limited, seen.valid) != (tick.limited, tick.valid):
        yield "native is not python", f"limited, valid: {seen} and {tick}"
    for name in ("error", "joint_step", "command", "filtered_error") if seen else ():
        if not _equal(getattr(seen, name), getattr(tick, name)):
            yield "native is not python", f"{name}: {seen} and {tick}"


def _equal(own: Array, other: Array) -> bool:
    scale = max(1.0, float(np.abs(other).max(initial=0.0, where=np.abs(other) < 1e8)))
    return bool((np.abs(own - other) <= ROUNDING * np.maximum(scale, np.abs(other))).all())


def _config(rng: np.random.Generator, arm: RandomArm) -> fd.FuzzyIkConfig:
    """A config that the kernel takes, mostly."""
    iterations = int(rng.choice([1, 6, 9]))
    law = fd.FuzzyMapping(
        iterations=iterations,
        damping=float(rng.choice([0.0, 1e-3, 0.1])) if iterations > 1 else 0.0,
        error_damping=float(rng.choice([0.0, 3.0])) if iterations > 1 else 0.0,
        row_floor=float(rng.choice([0.0, 0.05])),
        column_floor=float(rng.choice([0.0, 0.05])),
    )
    config = random_config(rng, arm)
    if rng.random() < 0.7:
        config.velocity_limits, config.max_joint_step = [], 0.5
    if rng.random() < 0.7:
        config.acceleration_limits, config.jerk_limits = [], []
    if rng.random() < 0.15:
        config.limit_retreat = 0.06
    if rng.random() < 0.6:  # calms more often than one of any constants
        config.supervisor = fd.GainSupervisorConfig()
    return dataclasses.replace(
        config,
        law=law,
        task=str(rng.choice(TASKS)),
        restart_search=bool(rng.random() < 0.3),
        posture_rate=min(config.posture_rate, 5.0) if rng.random() < 0.5 else 0.0,
    )
