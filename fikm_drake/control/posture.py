"""A posture that a redundant arm prefers, kept where the task leaves it free."""

import numpy as np

from fikm_drake.arrays import Array

DAMPING = 1e-6
"""Damping of the projection, relative to the largest it can be: it stays finite at singular postures."""


def posture_step(J: Array, pull: Array) -> Array:
    """The part of a joint step `pull` (n,) that does not move the tool: N pull, N = I − J⁺ J.

    Args:
        J: the task Jacobian (m,n).
        pull: the joint step toward the preferred posture (n,) [rad or m].
    """
    square = J @ J.T
    square.flat[:: len(J) + 1] += DAMPING * np.trace(square) + 1e-300
    return pull - J.T @ np.linalg.solve(square, J @ pull)
