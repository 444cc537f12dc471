"""Many arms of a kind that follow targets of their own, without a Diagram."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.laws.law import Law


@dataclass(frozen=True)
class BatchRun:
    """What N arms did in T cycles."""

    error: Array
    """Length of the error at the start of each cycle (T,N) [m]."""
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
    errors, travel = [], np.zeros(q.shape[1])
    for target in [*targets, *[targets[-1]] * hold]:
        frames = arm.chain.frames(q)
        J = np.moveaxis(frames.jacobian(None)[:rows], -1, 0)
        error = target - frames.position[:rows].T
        step = law(J, error)
        errors.append(np.linalg.norm(error, axis=1))
        travel += np.linalg.norm(step, axis=1)
        q = q + step.T
    return BatchRun(np.array(errors), travel)


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
