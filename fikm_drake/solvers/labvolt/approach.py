"""Postures that reach a point with the hand at a given angle, or as near to it as can be, in closed form.

The hand's angle θ_3 from the horizontal leaves two links for the wrist, so two postures at most. Along
the curve of all postures for a point θ_3 turns back only where the arm is straight at the elbow, and the
curve ends only where a joint is at its limit. So where neither posture is inside the limits, the nearest
angle is at one of 14 others: a limit, twelve, or the straight elbow, two.
"""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.angles import wrap
from fikm_drake.kinematics.planar_links import EDGE, PlanarLinks, chord, two_links
from fikm_drake.solvers.labvolt.feasible_postures import SIDES, candidates

LIMITED = 12
"""Of the candidates of `feasible_postures` those at a limit; the others are straight at the wrist."""


def at_approach(
    links: PlanarLinks, target: Array, approach: Array, near: Array
) -> tuple[Array, Array]:
    """The posture nearest to `near` that reaches a point at an approach angle, or at the nearest one.

    Args:
        links: the arm.
        target: points in the arm's plane (2,N) [m].
        approach: θ_3, from the horizontal (N,) [rad].
        near: relative angles (3,N) that choose between two postures [rad].

    Returns:
        Relative angles (3,N) [rad], NaN where the point cannot be reached; how far θ_3 is from the
        approach angle (N,), in [−π, π] [rad].
    """
    first, second, third = links.lengths
    wrist = target - third * np.array([np.cos(approach), np.sin(approach)])
    shoulder, elbow = two_links(first, second, wrist[:, None], SIDES)
    exact = np.stack([shoulder, elbow, wrap(approach - shoulder - elbow)])
    length, _ = chord(first, second, 0.0)
    direction, bend = two_links(length, third, target[:, None], SIDES)
    straight = np.stack([direction, np.zeros_like(bend), bend])
    edges = candidates(links, target)[:, :LIMITED]
    q = np.concatenate([wrap(exact), wrap(straight), edges], axis=1)
    inside = links.contains(q, EDGE)
    off = wrap(q.sum(axis=0) - approach)
    off[:2] = 0.0
    away = np.sqrt(((q - near[:, None]) ** 2).sum(axis=0))
    # First by the angle, then, between the two exact ones, by how near the posture is.
    cost = np.where(inside, np.abs(off), np.inf)
    cost[:2] = np.where(inside[:2], -1.0 / (1.0 + away[:2]), np.inf)
    best, lanes = cost.argmin(axis=0), np.arange(target.shape[1])
    found = links.clip(q[:, best, lanes])
    lost = ~inside.any(axis=0)
    found[:, lost] = np.nan
    return found, np.where(lost, np.nan, off[best, lanes])
