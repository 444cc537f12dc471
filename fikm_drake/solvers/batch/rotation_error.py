"""Angle-axis orientation errors of many frames at once."""

import numpy as np

from fikm_drake.arrays import Array

NEARLY_HALF_TURN = -0.99
"""Below this cosine (172°) the sine no longer gives a precise axis."""


def rotation_error(rotation: Array, target: Array) -> tuple[Array, Array]:
    """The turns that carry frames to their targets, correct through 180°.

    Args:
        rotation: (3,3,N), rotation[k] is axis k of the frame in the base frame.
        target: (3,3,N), the same of the target.

    Returns:
        Rotation vectors (3,N) [rad] in the base frame, and their lengths (N,) in [0, π]. At 180° one
        of the two opposite axes.
    """
    sine_axis = np.empty(rotation.shape[1:])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        np.sum(
            rotation[:, j] * target[:, k] - rotation[:, k] * target[:, j], axis=0, out=sine_axis[i]
        )
    sine_axis *= 0.5
    sine = np.sqrt(np.sum(sine_axis * sine_axis, axis=0))
    cosine = 0.5 * (np.sum(np.sum(rotation * target, axis=0), axis=0) - 1.0)
    angle = np.arctan2(sine, cosine)
    error = sine_axis * np.divide(angle, sine, out=np.ones_like(sine), where=sine > 1e-9)
    lanes = np.flatnonzero(cosine < NEARLY_HALF_TURN)
    if lanes.size:
        axis = _axis(rotation[..., lanes], target[..., lanes], cosine[lanes], sine_axis[:, lanes])
        error[:, lanes] = angle[lanes] * axis
    return error, angle


def _axis(rotation: Array, target: Array, cosine: Array, sine_axis: Array) -> Array:
    """Unit axes (3,N) of turns near 180°, from E + Eᵀ = 2 cos θ I + 2 (1 − cos θ) a aᵀ."""
    E = np.sum(target[:, :, None] * rotation[:, None], axis=0)
    outer = 0.5 * (E + E.swapaxes(0, 1)) - cosine * np.eye(3)[..., None]
    largest = np.argmax(np.einsum("iin->in", outer), axis=0)
    axis = outer[:, largest, np.arange(largest.size)]
    axis = axis / np.sqrt(np.sum(axis * axis, axis=0))
    return np.where(np.sum(axis * sine_axis, axis=0) < 0.0, -axis, axis)
