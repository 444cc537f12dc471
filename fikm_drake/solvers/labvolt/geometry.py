"""Lengths and limits of the LabVolt 5250, its angles, and the counts of its servos."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_links import PlanarLinks

MODEL = "labvolt5250"
"""Name of the arm in `models/`."""


@dataclass(frozen=True)
class Geometry(PlanarLinks):
    """A turning base that carries three links of one vertical plane.

    The plane's frame has its origin at the shoulder, x pointing away from the base's axis and y up.
    """

    offset: float
    """Offset of the shoulder from the base's axis [m]."""
    height: float
    """Height of the shoulder over the base [m]."""


@cache
def labvolt() -> Geometry:
    """The LabVolt 5250, from `models/labvolt5250.yaml`."""
    arm = load_arm(MODEL)
    base, shoulder, elbow, wrist = arm.table.joints
    low, high = arm.lower[1:].tolist(), arm.upper[1:].tolist()
    return Geometry(
        (elbow.a, wrist.a, arm.table.tool.a), tuple(low), tuple(high), shoulder.a, base.d
    )


def to_absolute(relative: ArrayLike) -> Array:
    """Angles from the horizontal, as the paper and the LabVolt count them.

    Args:
        relative: θ_1, θ_2 − θ_1, θ_3 − θ_2 (…,3) [rad], as the joints of the URDF.

    Returns:
        θ_1, θ_2, θ_3 (…,3) [rad].
    """
    return np.cumsum(np.asarray(relative, dtype=float), axis=-1)


def to_relative(absolute: ArrayLike) -> Array:
    """The inverse of `to_absolute`."""
    absolute = np.asarray(absolute, dtype=float)
    return np.diff(absolute, axis=-1, prepend=0.0)


def forward_kinematics(angles: ArrayLike) -> Array:
    """Tool point in the arm's plane, equations 1 and 2.

    Args:
        angles: absolute, from the horizontal, θ_1, θ_2, θ_3 (…,3) [rad].

    Returns:
        x and y from the shoulder (…,2) [m].
    """
    angles = np.asarray(angles, dtype=float)
    lengths = np.array(labvolt().lengths)
    return np.stack([np.cos(angles) @ lengths, np.sin(angles) @ lengths], axis=-1)


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
