"""Seeded runs for `fikm-drake benchmark calm`: an arm, a task, a rate, and a target that it can follow."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RotationMatrix

from fikm_drake.arrays import Array
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

TASKS = {
    "planar2": ("xy", "x"),
    "planar4": ("xy", "x"),
    "kim_lee3r": ("xy", "x"),
    "hassantabar3r": ("xy",),
    "hassantabar4r": ("position", "xz"),
    "tojo4dof": ("position", "yz"),
    "labvolt5250": ("position", "xz"),
    "arm7": ("position", "pose", "xy", "orientation"),
    "iiwa14": ("position", "pose", "yz", "orientation"),
    "panda": ("position", "pose", "xz", "orientation"),
    "puma560": ("position", "pose", "pointing", "z"),
    "ur5": ("position", "pose", "pointing", "xy"),
    "gen3": ("position", "pose", "xz"),
    "jaco": ("position", "pose", "yz"),
    "xarm7": ("position", "pose", "xy"),
}
"""Tasks that are tried, by arm."""
KINDS = ("constant", "line", "stop_and_go", "jumps", "creep", "circle")
"""How the target moves."""
RATES = (50.0, 100.0, 200.0, 500.0, 1000.0)
"""[Hz]"""
NOISES = ("none", "none", "target", "sensor")
"""What shakes: nothing, as often as the others together; the target; the measured joints."""
CYCLES, SECONDS = 1200, 12.0
"""A run is as long as the shorter of these."""
SHARP = FuzzyMapping.iterated()
"""The usual law for a pose; the other is the default, the paper's."""
LENGTH = 0.3
"""A turn of 1 rad counts as this much [m]."""


@dataclass(frozen=True)
class CalmRun:
    """A run: whose, of what, and the targets of its cycles."""

    index: int
    arm: str
    task: str
    kind: str
    rate: float
    """[Hz]"""
    noise: str
    sigma: float
    """Standard deviation of the noise [m, or rad for the sensors]."""
    sharp: bool
    """The law is `SHARP`."""
    start: Array
    """Joint positions (n,) [rad or m]."""
    poses: Array
    """What the tool should do (N,4,4)."""
    shaken: Array
    """The same as the controller sees it (N,4,4)."""
    sensor: Array
    """Noise of the measured joints (N,n) [rad or m]; zeros where they are not measured."""
    counted: Array
    """Cycles whose error counts (N,): not the way to a target that jumped."""

    @property
    def name(self) -> str:
        """What is run, in one line."""
        noise = "" if self.noise == "none" else f", noise {self.sigma:.1e} on the {self.noise}"
        law = ", sharp" if self.sharp else ""
        return f"#{self.index} {self.arm} {self.task} {self.kind} {self.rate:g} Hz{law}{noise}"


def calm_run(index: int, *, seed: int = 0, arms: Sequence[str] = tuple(TASKS)) -> CalmRun:
    """Run number `index`: every arm in turn, all else at random.

    Targets come from joint motions inside the limits, so that they can be reached; a `line` is a straight
    one of constant orientation near the start. Nothing is known of singular postures on the way.

    Args:
        index: which run; each has its own stream of random numbers.
        seed: of all runs.
        arms: of `TASKS`.
    """
    rng = np.random.default_rng([seed, index])
    name = arms[index % len(arms)]
    arm = load_arm(name)
    task, kind = str(rng.choice(TASKS[name])), str(rng.choice(KINDS))
    rate, noise = float(rng.choice(RATES)), str(rng.choice(NOISES))
    cycles = min(CYCLES, round(SECONDS * rate))
    times = np.arange(cycles) / rate
    start = _posture(rng, arm)
    poses, counted = _path(rng, arm, start, kind, times)
    sigma = {"none": 0.0, "target": 2e-3, "sensor": 1e-3}[noise] * 10.0 ** rng.uniform(-1.3, 0.0)
    shaken = _shake(rng, poses, sigma) if noise == "target" else poses
    sensor = sigma * rng.normal(size=(cycles, len(start))) if noise == "sensor" else 0.0
    sharp = task == "pose" and rng.random() < 0.7 or task != "orientation" and rng.random() < 0.2
    return CalmRun(
        index=index,
        arm=name,
        task=task,
        kind=kind,
        rate=rate,
        noise=noise,
        sigma=sigma,
        sharp=sharp,
        start=start,
        poses=poses,
        shaken=shaken,
        sensor=np.broadcast_to(sensor, (cycles, len(start))),
        counted=counted,
    )


def config_of(run: CalmRun, *, calming: float) -> FuzzyIkConfig:
    """The controller's config: default, but for the run's own; `calming` 1 is without the calm."""
    return FuzzyIkConfig(
        task=run.task,
        control_rate=run.rate,
        characteristic_length=LENGTH,
        law=SHARP if run.sharp else FuzzyMapping(),
        measured_position=run.noise == "sensor",
        supervisor=GainSupervisorConfig(calming=calming),
    )


def _ranges(arm: DhArm) -> tuple[Array, Array]:
    """Where joints may be, a tenth of the range off their limits, and within half a turn."""
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    lower, upper = np.minimum(lower, arm.upper - 1.0), np.maximum(upper, arm.lower + 1.0)
    lower, upper = np.maximum(lower, arm.lower), np.minimum(upper, arm.upper)
    margin = 0.1 * (upper - lower)
    return lower + margin, upper - margin


def _posture(rng: np.random.Generator, arm: DhArm) -> Array:
    lower, upper = _ranges(arm)
    return rng.uniform(lower, upper)


def _near(rng: np.random.Generator, arm: DhArm, q: Array, most: float) -> Array:
    """A posture near another, no joint further than `most` of its range."""
    lower, upper = _ranges(arm)
    return np.clip(q + most * (upper - lower) * rng.uniform(-1.0, 1.0, len(q)), lower, upper)


def _path(
    rng: np.random.Generator, arm: DhArm, start: Array, kind: str, times: Array
) -> tuple[Array, Array]:
    """Poses (N,4,4) of the tool and which of them count (N,)."""
    everything = np.ones(len(times), dtype=bool)
    if kind == "jumps":
        stays = rng.uniform(0.3, 0.6) * times[-1]
        number = (times // stays).astype(int)
        postures = [start]
        for _ in range(number[-1]):
            postures.append(_near(rng, arm, postures[-1], 0.15))
        poses = arm.forward_kinematics(np.array(postures)[number])
        return poses, times % stays > 0.5 * stays
    if kind == "line":
        return _line(rng, arm.forward_kinematics(start), times), everything
    if kind == "circle":
        turns = rng.uniform(0.3, 2.0) * 2 * np.pi * times[:, None] / times[-1]
        a, b = _near(rng, arm, start, 0.08) - start, _near(rng, arm, start, 0.08) - start
        q = start + a * np.sin(turns) + b * (1.0 - np.cos(turns))
        return arm.forward_kinematics(np.clip(q, *_ranges(arm))), everything
    postures = [start]
    for _ in range(4):
        postures.append(_near(rng, arm, postures[-1], 0.15))
    steps = np.linspace(0.0, 4.0, 2001)
    corner = np.minimum(steps.astype(int), 3)
    legs, fraction = np.array(postures), (steps - corner)[:, None]
    fine = arm.forward_kinematics(legs[corner] + fraction * (legs[corner + 1] - legs[corner]))
    way = np.concatenate([[0.0], np.cumsum(_distances(fine))])
    speed = 10.0 ** (rng.uniform(-3.7, -2.3) if kind == "creep" else rng.uniform(-1.7, -0.6))
    goes = np.ones(len(times))
    if kind == "stop_and_go":
        goes = (np.sin(np.cumsum(rng.uniform(2.0, 9.0, 1) * np.gradient(times))) > -0.2).astype(
            float
        )
        goes *= (times > rng.uniform(0.0, 0.3) * times[-1]) & (times % 3.1 < rng.uniform(1.0, 3.1))
    driven = np.concatenate([[0.0], np.cumsum(speed * goes[1:] * np.diff(times))])
    steps_at = np.interp(np.minimum(driven, way[-1]), way, steps)
    corner = np.minimum(steps_at.astype(int), 3)
    q = legs[corner] + (steps_at - corner)[:, None] * (legs[corner + 1] - legs[corner])
    return arm.forward_kinematics(q), everything


def _distances(poses: Array) -> Array:
    """Between neighbours (N−1,) [m], turns counted too."""
    moved = np.diff(poses[:, :3, 3], axis=0)
    turned = LENGTH / np.sqrt(2.0) * np.diff(poses[:, :3, :3], axis=0)
    return np.sqrt((moved**2).sum(axis=1) + (turned**2).sum(axis=(1, 2)))


def _line(rng: np.random.Generator, home: Array, times: Array) -> Array:
    """Straight legs near the start at up to 0.1 m/s, with the start's orientation."""
    corners = [home[:3, 3]] + [home[:3, 3] + rng.uniform(-0.12, 0.12, 3) for _ in range(3)]
    pauses = [max(0.2, float(np.linalg.norm(b - a)) / 0.1) for a, b in zip(corners, corners[1:])]
    ends = np.concatenate([[0.0], np.cumsum(pauses)])
    poses = np.repeat(home[None], len(times), axis=0)
    for i in range(3):
        poses[:, i, 3] = np.interp(times, ends, np.array(corners)[:, i])
    return poses


def _shake(rng: np.random.Generator, poses: Array, sigma: float) -> Array:
    """Noise of position, and of orientation as much over the length."""
    shaken = poses.copy()
    for T in shaken:
        turn = rng.normal(size=3) * sigma / LENGTH
        T[:3, 3] += sigma * rng.normal(size=3)
        angle = float(np.linalg.norm(turn))
        T[:3, :3] = RotationMatrix(AngleAxis(angle, turn / angle)).matrix() @ T[:3, :3]
    return shaken
