"""Paper 1's controller (figure 1, section 2.7) on many paths at once, what it leaves open as options.

One tick: e = target − tool; K from e and the last ten cycles; K_applied = K/3 + 2/3 K_applied;
d = K_applied e/3 + 2/3 d; q ← q + C⁻¹ Jᵀ R⁻¹ d. The Diagram does the same for one path, and a test holds
both together; here a cycle is a few array operations, whatever the number of paths.
"""

from dataclasses import dataclass

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig, gain_rules
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.law import Law

WINDOW = 10
"""Cycles that the supervisor looks back, of section 2.7."""
UNKNOWN = ("medium", "known so far")
AVERAGES = ("with the present error", "before it")


@dataclass(frozen=True)
class Reading:
    """How the paper is read where it gives no number or more than one sense."""

    breakpoints: tuple[float, float, float] = (0.0, 1.0, 2.0)
    """Figure 6: S, M and B peak at these multiples of the average error [-]."""
    average: str = AVERAGES[0]
    """Average of ten errors: the present one among them, or the ten before it."""
    unknown: str = UNKNOWN[0]
    """Before ten errors are known: every error is medium, or compared with the average of those there are."""
    by_rows: bool = False
    """An error and a gain for each row of the task (`d_avg for dr_i`), or for its length."""
    initial_gain: float = 1.0
    """K_applied before the first cycle [-]."""
    first_error: str = "zero"
    """dr of equation 31 before the first cycle: `zero`, or the `first` amplified error itself."""


@dataclass(frozen=True)
class Rollout:
    """What N arms did in T cycles."""

    after: Array
    """Length of the error after each cycle's step, to that cycle's target (T,N) [m]."""
    before: Array
    """Length of the error before it (T,N) [m]."""
    q: Array
    """Joint positions after each cycle (T,N,n) [rad or m]."""


def rollout(
    arm: DhArm,
    starts: Array,
    targets: Array,
    *,
    reading: Reading | None = None,
    law: Law | None = None,
    supervised: bool = True,
) -> Rollout:
    """Run the controller of figure 1, a cycle a target.

    Args:
        arm: the arm.
        starts: joint positions (N,n) [rad or m].
        targets: of the tool (T,N,m) [m]; m = 2: x and y.
        reading: what the paper leaves open; None: ours.
        law: (J, dr) to a joint step; None: the fuzzy mapping, indirect.
        supervised: False: gain 1 and no filters, as `FuzzyIkConfig.resolved_rate`.
    """
    reading, law = reading or Reading(), law or FuzzyMapping()
    rules = gain_rules(GainSupervisorConfig(error_breakpoints=list(reading.breakpoints)))
    q, rows = np.array(starts, dtype=float), targets.shape[-1]
    applied: Array = np.full((len(q), rows if reading.by_rows else 1), reading.initial_gain)
    d: Array = np.zeros((len(q), rows))
    errors: list[Array] = []
    steps: list[Array] = []
    frames = arm.chain.frames(q.T)
    before, after, path = [], [], []
    for target in targets:
        error = target - frames.position[:rows].T
        size = np.abs(error) if reading.by_rows else np.linalg.norm(error, axis=1, keepdims=True)
        errors.append(size)
        relative = _relative(errors, reading)
        K = rules(relative, _sign_changes(steps)[:, None])
        applied = K / 3.0 + 2.0 / 3.0 * applied
        amplified = applied * error
        if len(errors) == 1 and reading.first_error == "first":
            d = amplified
        d = amplified / 3.0 + 2.0 / 3.0 * d if supervised else error
        step = law(np.moveaxis(frames.jacobian(None)[:rows], -1, 0), d)
        q = q + step
        steps.append(np.sign(step))
        frames = arm.chain.frames(q.T)
        before.append(np.linalg.norm(error, axis=1))
        after.append(np.linalg.norm(target - frames.position[:rows].T, axis=1))
        path.append(q)
    return Rollout(np.array(after), np.array(before), np.array(path))


def _relative(errors: list[Array], reading: Reading) -> Array:
    """The present error over its average, as read."""
    now, known = errors[-1], errors[-WINDOW:]
    if reading.average == AVERAGES[1]:
        known = errors[-WINDOW - 1 : -1]
    enough = len(known) == WINDOW or (reading.unknown == UNKNOWN[1] and known)
    if not enough:
        return np.full(now.shape, reading.breakpoints[1])
    average = np.mean(known, axis=0)
    return np.divide(now, average, out=np.zeros_like(now), where=average > 0.0)


def _sign_changes(signs: list[Array]) -> Array:
    """The most changes of sign (N,) of a joint's last ten steps, or zeros before the second."""
    if len(signs) < 2:
        return np.zeros(len(signs[0]) if signs else 1)
    window = np.array(signs[-WINDOW:])
    return (window[1:] * window[:-1] < 0.0).sum(axis=0).max(axis=-1)
