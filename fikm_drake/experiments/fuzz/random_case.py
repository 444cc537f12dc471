"""Random tasks, laws, configs, targets and measurements for a random arm."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from pydrake.math import RigidTransform

import fikm_drake as fd
from fikm_drake.arrays import Array
from fikm_drake.experiments.fuzz.random_arm import RandomArm, random_arm
from fikm_drake.laws.quadratic import quadratic_of

Target: TypeAlias = "Array | RigidTransform"
"""What a task's port takes."""
CYCLES = (5, 40)
"""Cycles of a case."""
TASKS = ("position", "xy", "z", "orientation", "pose", "pointing")
BAD = (np.nan, np.inf, -np.inf, 1e101, -1e155, 1e200)
"""Numbers that a target may hold, and that are no target."""


@dataclass(frozen=True)
class RandomCase:
    """What a controller is given in one case."""

    arm: RandomArm
    """The plant."""
    config: fd.FuzzyIkConfig
    """The controller's; `fused` is set by who runs it."""
    start: Array
    """Joint positions (n,) [rad or m]."""
    targets: list[Target]
    """Targets of each cycle."""
    noise: list[Array]
    """Added to the command of each cycle (n,) where joints are measured [rad or m]."""
    wishes: list[Array]
    """Null-space motion of each cycle (n,) [rad/s or m/s]; no numbers at times."""
    measured: bool
    """Whether the port of the measured joints is connected."""


def random_case(rng: np.random.Generator) -> RandomCase:
    """A case of a controller."""
    arm = random_arm(rng)
    config = random_config(rng, arm)
    start = arm.posture(rng)
    count = int(rng.integers(*CYCLES))
    noise = [random_noise(rng, len(start), arm.scale) for _ in range(count)]
    targets = random_targets(rng, arm, config.task, start, count)
    measured = config.measured_position or bool(rng.random() < 0.2)
    size = 10.0 ** rng.uniform(-3.0, 3.0)
    wishes = [size * random_noise(rng, len(start), arm.scale) for _ in range(count)]
    return RandomCase(arm, config, start, targets, noise, wishes, measured)


def random_law(rng: np.random.Generator, scale: float) -> Any:
    """One of the laws that have names, with options."""
    kind = rng.integers(0, 8)
    if kind == 0:
        return fd.FuzzyMapping("direct")
    if kind == 1:
        return fd.DampedLeastSquares(scale * 10.0 ** rng.uniform(-3.0, 1.0))
    if kind == 2:
        return fd.PseudoInverse(10.0 ** rng.uniform(-12.0, -2.0))
    if kind == 3:
        return fd.JacobianTranspose()
    if kind == 4:
        return fd.FuzzyRateControl(
            str(rng.choice(["smooth", "paper"])),
            sweeps=int(rng.integers(1, 4)),
            error_range=scale * 10.0 ** rng.uniform(-2.0, 0.0),
        )
    iterations = int(rng.choice([1, 1, 2, 3, 6, 9]))
    return fd.FuzzyMapping(
        iterations=iterations,
        damping=float(rng.choice([0.0, 1e-3, 0.1])) if iterations > 1 else 0.0,
        error_damping=float(rng.choice([0.0, 3.0])) if iterations > 1 else 0.0,
        row_floor=float(rng.choice([0.0, 0.01, 0.3])),
        column_floor=float(rng.choice([0.0, 0.01, 0.3])),
    )


def random_config(rng: np.random.Generator, arm: RandomArm) -> fd.FuzzyIkConfig:
    """A controller's config; half of the fields as they are by default."""

    def maybe(default: Any, value: Any) -> Any:
        return value if rng.random() < 0.5 else default

    n, scale = len(arm.lower), arm.scale
    config = fd.FuzzyIkConfig(
        law=random_law(rng, scale),
        task=str(rng.choice(TASKS)),
        characteristic_length=maybe(0.3, 0.3 * scale),
        control_rate=maybe(50.0, 10.0 ** rng.uniform(0.5, 3.3)),
        measured_position=bool(rng.random() < 0.3),
        error_limit=maybe(0.2, float(rng.choice([0.2 * scale, np.inf]))),
        max_joint_step=maybe(0.5, float(rng.choice([10.0 ** rng.uniform(-4.0, 1.0), np.inf]))),
        singularity_nudge=maybe(0.01, float(rng.choice([0.0, 10.0]))),
        limit_margin=maybe(0.1, 0.0),
        tolerance=maybe(1e-3, 1e-3 * scale),
        gain_smoothing=maybe(2.0 / 3.0, 0.99 * rng.random()),
        error_smoothing=maybe(2.0 / 3.0, 0.99 * rng.random()),
        restart_search=bool(rng.random() < 0.08),
        null_space_motion=bool(rng.random() < 0.15),
        supervisor=maybe(fd.GainSupervisorConfig(), random_supervisor(rng)),
    )
    config.posture_rate = maybe(0.0, config.control_rate * rng.random())
    for name in ("velocity_limits", "acceleration_limits"):
        count = int(rng.choice([0, 0, 1, n]))
        setattr(config, name, (10.0 ** rng.uniform(-2.0, 2.0, count)).tolist())
    if rng.random() < 0.2:
        count = int(rng.choice([1, n]))
        config.jerk_limits = (10.0 ** rng.uniform(1.0, 5.0, count)).tolist()
    if quadratic_of(config.law, 6) and rng.random() < 0.3:
        config.limit_retreat = float(rng.choice([0.06, 10.0]))
    if rng.random() < 0.3:
        config = config.resolved_rate()
    elif rng.random() < 0.2:
        config = config.as_in_paper()
    return config


def random_supervisor(rng: np.random.Generator) -> fd.GainSupervisorConfig:
    """Windows, thresholds and what the calm does; gains up to what the filtered loop bears."""
    window = int(rng.integers(2, 20))
    slow = int(rng.integers(window, 100))
    return fd.GainSupervisorConfig(
        window=window,
        sign_changes=int(rng.integers(1, window)),
        slow_window=slow,
        slow_sign_changes=int(rng.integers(1, slow)),
        gains=rng.uniform(0.0, 6.0, 3).tolist(),
        oscillating_gains=rng.uniform(0.0, 1.0, 3).tolist(),
        dead_band=10.0 ** rng.uniform(-15.0, -3.0),
        calming=float(rng.choice([0.3, 0.8, 1.0])),
        recovery=1.0 + 10.0 ** rng.uniform(-3.0, 1.0),
        calm_damping=float(rng.choice([0.0, 0.3, 3.0])),
    )


def is_bad(target: Target) -> bool:
    """True if a target holds a number that is none, or one that no arm can be asked for."""
    numbers = target.GetAsMatrix34() if isinstance(target, RigidTransform) else target
    return not np.linalg.norm(numbers) < 1e100


def random_noise(rng: np.random.Generator, n: int, scale: float) -> Array:
    """Of measured joints (n,) [rad or m], bad numbers among it."""
    noise = 1e-3 * rng.normal(size=n) if rng.random() < 0.8 else np.zeros(n)
    if rng.random() < 0.05:
        noise[rng.integers(n)] = rng.choice(BAD)
    return noise


def random_targets(
    rng: np.random.Generator, arm: RandomArm, task: str, start: Array, count: int
) -> list[Target]:
    """Targets that rest, creep, jump, lie out of reach, shake, and are no numbers at times."""
    plant = arm.plant
    context = plant.CreateDefaultContext()
    tool = plant.GetFrameByName("tool")

    def pose_at(q: Array) -> RigidTransform:
        plant.SetPositions(context, q)
        return tool.CalcPoseInWorld(context)

    pose = pose_at(start if rng.random() < 0.3 else arm.posture(rng))
    creep = arm.scale * 10.0 ** rng.uniform(-6.0, -1.0) * rng.normal(size=3)
    shake = arm.scale * float(rng.choice([0.0, 1e-4, 1e-2]))
    often = float(rng.choice([0.0, 0.03, 0.2]))  # of jumps and of bad numbers
    targets = []
    for _ in range(count):
        if rng.random() < often:
            pose = pose_at(arm.posture(rng))
        if rng.random() < 0.5 * often:
            pose = RigidTransform(pose.rotation(), pose.translation() * 10.0 ** rng.uniform(0, 90))
        pose = RigidTransform(pose.rotation(), pose.translation() + creep)
        shaken = RigidTransform(pose.rotation(), pose.translation() + shake * rng.normal(size=3))
        targets.append(_as_target(rng, task, shaken, bad=rng.random() < often))
    return targets


def _as_target(rng: np.random.Generator, task: str, pose: RigidTransform, *, bad: bool) -> Target:
    p = pose.translation().copy()
    if task in ("orientation", "pose"):
        if bad:
            p[rng.integers(3)] = rng.choice(BAD)
        return RigidTransform(pose.rotation(), p)
    if task == "pointing":
        vector = np.concatenate((p, pose.rotation().matrix()[:, 2]))
    else:
        vector = p[["xyz".index(axis) for axis in ("xyz" if task == "position" else task)]]
    if bad:
        vector[rng.integers(len(vector))] = rng.choice(BAD)
    return vector
