"""Servo counts, as the LabVolt 5250's controller takes them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array

COUNTS = np.array([1.0 / 0.0015, -666.66667, -1.0 / 0.001699])
"""Counts a degree of θ_1, θ_2, θ_3, from Go_Robot.m of M. Elsharif's MATLAB library [1/deg]."""
ZERO = np.array([105.0, 0.0, 0.0])
"""Angles at count zero [deg]."""


def to_servo_counts(angles: ArrayLike) -> NDArray[np.int64]:
    """The nearest counts of the shoulder, the elbow and the wrist.

    Args:
        angles: absolute θ_1, θ_2, θ_3 (…,3), finite [rad].

    Raises:
        ValueError: angles that are not finite.
    """
    degrees = np.rad2deg(np.asarray(angles, dtype=float))
    if not np.isfinite(degrees).all():
        raise ValueError("angles must be finite")
    return np.rint((degrees - ZERO) * COUNTS).astype(np.int64)


def from_servo_counts(counts: ArrayLike) -> Array:
    """The absolute angles (…,3) [rad] of counts (…,3)."""
    return np.deg2rad(np.asarray(counts, dtype=float) / COUNTS + ZERO)
