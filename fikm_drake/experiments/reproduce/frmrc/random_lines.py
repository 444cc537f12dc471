"""Past paper 3: lines all over the workspace, of three joints and of seven, tracked side by side."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.frmrc.laws import ALLOWED, PAPER, RMRC, SETTLED, THREE, laws
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import Law

LINES, SEED = 300, 0
SECONDS, RATE = 2.0, 50.0
"""Seconds and rate of a line [s], [Hz]."""
STARTS = [[0.5, 0.6, 0.6], [0.3, 0.9, -1.2], [1.0, -1.2, -0.8], [0.2, 1.4, 0.7], [-0.4, 1.0, 1.0]]
"""Five bent postures of the 3-joint arm [rad]."""
ENDS = [[-0.3, 0.7], [0.4, 0.8], [0.2, -0.6], [0.7, 0.2], [0.0, 0.9]]
"""Where lines from them go [m]."""
RADIUS = 0.2
"""Radius of circles from them, which lie inward [m]."""
LEAST = "3 sweeps, gain 1"
ERROR_3, ERROR_7, TRAVEL = 1.7, 2.2, 1.15
"""What we claim of three sweeps, times the pseudo-inverse: error (90th percentile) and travel."""


@dataclass(frozen=True)
class BatchRun:
    """What N arms did in T cycles."""

    error: Array
    """Length of the error at the start of each cycle (T,N) [m]."""
    after: Array
    """Length of what its step leaves of it (T,N) [m]."""
    travel: Array
    """Length of each arm's way in joint space (N,) [rad]."""


def track(law: Law, arm: DhArm, starts: ArrayLike, targets: Array, *, hold: int = 50) -> BatchRun:
    """Resolved rate control: q ← q + law(J(q), target − tool), a cycle a target, then `hold` cycles.

    Args:
        law: the law.
        arm: the arm.
        starts: joint positions (N,n) [rad or m].
        targets: tool positions (T,N,m) [m]; m = 2: x and y.
        hold: cycles at the last target.
    """
    rows = targets.shape[-1]
    q = np.array(starts, dtype=float).T
    errors, left, travel = [], [], np.zeros(q.shape[1])
    frames = arm.chain.frames(q)
    for target in [*targets, *[targets[-1]] * hold]:
        J = np.moveaxis(frames.jacobian(None)[:rows], -1, 0)
        error = target - frames.position[:rows].T
        step = law(J, error)
        errors.append(np.linalg.norm(error, axis=1))
        travel += np.linalg.norm(step, axis=1)
        q = q + step.T
        frames = arm.chain.frames(q)
        left.append(np.linalg.norm(target - frames.position[:rows].T, axis=1))
    return BatchRun(np.array(errors), np.array(left), travel)


def cubic_lines(starts: Array, ends: Array, cycles: int) -> Array:
    """Straight lines (cycles + 1, N, m) [m] with the cubic profile of equation 16, at rest at both ends."""
    t = np.linspace(0.0, 1.0, cycles + 1)[:, None, None]
    return starts + (ends - starts) * t * t * (3.0 - 2.0 * t)


def circles(starts: Array, centres: Array, turns: int, cycles: int) -> Array:
    """Circles (turns · cycles + 1, N, 2) [m] in the plane, counterclockwise, from the start points."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, turns * cycles + 1)[:, None]
    x, y = (starts - centres).T
    turned = [x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)]
    return centres + np.stack(turned, axis=-1)


def starts() -> Section:
    """Lines and three circles from five bent postures of the 3-joint arm."""
    arm = load_arm("kim_lee3r")
    tool = arm.forward_kinematics(STARTS)[:, :2, 3]
    cycles = round(SECONDS * RATE)
    centres = tool * (1.0 - RADIUS / np.linalg.norm(tool, axis=1, keepdims=True))
    paths = {
        "line": cubic_lines(tool, np.array(ENDS), cycles),
        "circle": circles(tool, centres, 3, cycles),
    }
    cells = []
    for path, targets in paths.items():
        runs = {name: track(law, arm, STARTS, targets) for name, law in laws(arm, "xy").items()}
        reference = runs.pop(RMRC)
        for name, run in runs.items():
            ratios = [
                found.max(axis=0) / least.max(axis=0)
                for found, least in ((run.after, reference.after), (run.error, reference.error))
            ]
            after, before = (f"{ratio.max():.2f} / {np.median(ratio):.2f}" for ratio in ratios)
            most = ALLOWED[path].get(name)
            claim = None if most is None else bool(ratios[1].max() <= most)
            label = f"{path}, {name}: worst / median [-]"
            cells.append(Cell(label, None, after, None, before, claim, "before"))
        for name, run in runs.items():
            rest = 1000 * float(run.error[-1].max())
            claim = None if name == PAPER else rest < SETTLED
            cells.append(Cell(f"{path}, {name}: error at the end, worst [mm]", "0", rest, claim))
    return Section(
        "starts",
        "max error over the pseudo-inverse's, lines and three cycles from five bent postures at 50 Hz",
        cells,
    )


def lines() -> Section:
    """Random lines, each from one random posture's tool position to another's."""
    cells = []
    for name, most in (
        ("kim_lee3r", {THREE: (ERROR_3, TRAVEL)}),
        ("iiwa14", {THREE: (ERROR_7, TRAVEL)}),
        ("arm7", {LEAST: (ERROR_7, TRAVEL)}),
        ("panda", {}),
    ):
        arm = load_arm(name)
        task = "xy" if arm.num_joints == 3 else "position"
        found: dict[str, Law] = {**laws(arm, task), LEAST: FuzzyRateControl(sweeps=3, gain=1.0)}
        postures, targets = random_lines(arm, 2 if task == "xy" else 3)
        runs = {key: track(law, arm, postures, targets) for key, law in found.items()}
        reference = runs.pop(RMRC)
        cells += [_cell(name, key, run, reference, most.get(key)) for key, run in runs.items()]
    notes = [
        f"Of {SECONDS:g} s at {RATE:g} Hz with the cubic profile, each between the tool positions of two",
        "random postures, limits ignored on the way: many pass by singular postures, where the",
        "pseudo-inverse turns the joints fast and the fuzzy laws are late instead.",
        "Each: max error over the pseudo-inverse's (median / 90th percentile), which after the step leaves",
        "next to nothing; travel of the joints on all lines over its; lines that are within 0.01 mm 50",
        "cycles after the end.",
    ]
    return Section("lines", f"{LINES} random lines", cells, notes)


def random_lines(arm: DhArm, rows: int) -> tuple[Array, Array]:
    """Start postures (N,n) [rad] and targets (T,N,rows) [m]."""
    rng = np.random.default_rng(SEED)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    postures, others = rng.uniform(lower, upper, (2, LINES, arm.num_joints))
    tool, end = (arm.forward_kinematics(q)[:, :rows, 3] for q in (postures, others))
    return postures, cubic_lines(tool, end, round(SECONDS * RATE))


def _cell(
    arm: str,
    key: str,
    run: BatchRun,
    reference: BatchRun,
    most: tuple[float, float] | None,
) -> Cell:
    after = np.percentile(run.after.max(axis=0) / reference.after.max(axis=0), [50, 90])
    middle, high = np.percentile(run.error.max(axis=0) / reference.error.max(axis=0), [50, 90])
    travel = float(run.travel.sum() / reference.travel.sum())
    ended = 100 * np.mean(1000 * run.error[-1] < SETTLED)
    claim = None if most is None else bool(high <= most[0] and travel <= most[1])
    text = f"{middle:5.2f} / {high:5.2f}, travel {travel:.2f}, {ended:3.0f} %"
    left = f"{after[0]:5.2f} / {after[1]:5.2f}"
    return Cell(f"{arm}, {key}", None, left, None, text, claim, "before")
