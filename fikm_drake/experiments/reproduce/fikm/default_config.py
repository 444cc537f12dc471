"""The default controller, the paper's, beside the one that follows closest: noisy targets, out of reach."""

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.rollout import rollout
from fikm_drake.experiments.reproduce.fikm.random_curves import TRACKING, configs
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.tasks import make_task
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

POSTURES, SEED = 20, 3
"""Random postures of each arm."""
NOISE = 1e-3
"""Standard deviation of the target's noise, each coordinate, each cycle [m]."""
HELD = 200
"""Cycles of a target that stands but for its noise."""
CIRCLES = {"planar4": ("xy", 2.0, 0.3), "iiwa14": ("position", 1.3, 0.2)}
"""Circles out of reach: task, radius [m], speed [m/s]."""
SECONDS = 11.0
"""On a circle [s]."""
CALM = 1e-2
"""Change of the joints' step that `for_tracking()` is claimed to stay below out of reach [rad]."""
HEIGHT = 0.36
"""Of the iiwa14's shoulder, and its circle [m]."""


@dataclass(frozen=True)
class Motion:
    """How a controller moves an arm."""

    shaken: float
    """The tool's own motion about a noisy target that stands, over the noise, rms [-]."""
    acceleration: float
    """The joints' acceleration there, rms [rad/s²]."""
    step: float
    """Largest joint step of a cycle in the last second of a circle out of reach [rad]."""
    change: float
    """Change of the joints' step from cycle to cycle there, rms of its length [rad]."""


def compared() -> dict[str, FuzzyIkConfig]:
    """Those of `random_curves`, and the last with a law whose damping does not grow with the error."""
    found = configs()
    sharp = found[TRACKING]
    law = replace(FuzzyMapping.iterated(), error_damping=0.0)
    return {**found, "the same without error damping": replace(sharp, law=law)}


def measure(name: str, config: FuzzyIkConfig) -> Motion:
    """Both motions of an arm of `CIRCLES`."""
    (task, radius, speed), arm = CIRCLES[name], load_arm(name)
    config = replace(config, task=task)
    cycle = ControlCycle(make_task(PlantArm(MakeDhArmPlant(arm), "tool"), task), config)
    rng, rows = np.random.default_rng(SEED), 2 if task == "xy" else 3
    shaken, accelerations = [], []
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    for q in rng.uniform(0.8 * low, 0.8 * high, (POSTURES, arm.num_joints)):
        place = arm.forward_kinematics(q)[:rows, 3]
        run = rollout(cycle, list(place + NOISE * rng.normal(size=(HELD, rows))), q)
        tool = arm.forward_kinematics(run.q)[HELD // 2 :, :rows, 3]
        shaken.append(np.sqrt(((tool - place) ** 2).mean()) / NOISE)
        second = np.diff(run.q[HELD // 2 :], n=2, axis=0) * config.control_rate**2
        accelerations.append(np.sqrt((second**2).mean()))
    start = np.full(arm.num_joints, 0.1)
    steps = np.diff(rollout(cycle, _circle(radius, speed, rows, config), start).q, axis=0)
    last = steps[-round(config.control_rate) :]
    change = float(np.sqrt((np.diff(last, axis=0) ** 2).sum(axis=1).mean()))
    return Motion(
        float(np.median(shaken)),
        float(np.median(accelerations)),
        float(np.abs(last).max()),
        change,
    )


def default() -> Section:
    """What the default passes on of a target's noise, and how it moves out of reach, beside sharper ones."""
    found = {
        (arm, name): measure(arm, config) for arm in CIRCLES for name, config in compared().items()
    }
    usual = next(iter(compared()))
    cells = []
    for arm in CIRCLES:
        ours, sharp = found[arm, usual], found[arm, TRACKING]
        for name in compared():
            motion = found[arm, name]
            smoother, calm = ours.acceleration < sharp.acceleration, sharp.change < CALM
            text = f"{motion.shaken:.2f} / {motion.acceleration:.1f}"
            text += f" | {motion.step:.1e} / {motion.change:.1e}"
            claims = {usual: smoother, TRACKING: calm}
            cells.append(Cell(f"{arm}, {name}", None, text, claims.get(name)))
    notes = [
        f"First a target that stands but for noise of {1e3 * NOISE:g} mm: the tool's motion over the noise,",
        f"and the joints' acceleration [rad/s²], rms, median of {POSTURES} postures; then the last second",
        "of a circle out of reach: largest joint step, change of the step a cycle [rad].",
        "Claimed: the default accelerates less than the last, which out of reach changes its step by less",
        f"than {CALM:g} rad a cycle. The paper's gain and filters are made for targets that are noisy;",
        "`for_tracking()` is for those that move smoothly; that its law's damping grows with the error is",
        "what keeps it calm out of reach: see the same without.",
    ]
    return Section(
        "default",
        "the default beside the one that follows closest, behind noise and out of reach",
        cells,
        notes,
        {"fikm_default": _figure(found)},
    )


def _circle(radius: float, speed: float, rows: int, config: FuzzyIkConfig) -> list[Array]:
    """Targets, one a cycle."""
    phase = speed / radius * np.arange(round(SECONDS * config.control_rate)) / config.control_rate
    circle = radius * np.stack([np.cos(phase), np.sin(phase)], axis=1)
    if rows == 3:
        circle = np.column_stack([circle, np.full(len(phase), HEIGHT)])
    return list(circle)


def _figure(found: dict[tuple[str, str], Motion]) -> Figure:
    figure = Figure(figsize=(11, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    names = list(compared())
    rows = np.arange(len(names))[::-1]
    for k, arm in enumerate(CIRCLES):
        motions = [found[arm, name] for name in names]
        left.barh(rows - 0.4 * k + 0.2, [m.acceleration for m in motions], 0.4, label=arm)
        right.barh(rows - 0.4 * k + 0.2, [m.change for m in motions], 0.4, label=arm)
    left.set_yticks(rows, names)
    left.set_xlabel("target with noise: joint acceleration, rms [rad/s²]")
    right.set_xlabel("out of reach: change of the joint step a cycle, rms [rad]")
    right.set_xscale("log")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend()
    return figure
