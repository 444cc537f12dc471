"""Lengths and limits of the LabVolt 5250, and its angles."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.load_arm import load_arm

MODEL = "labvolt5250"
"""Name of the arm in `models/`."""


@dataclass(frozen=True)
class Geometry:
    """A turning base that carries three joints of one vertical plane.

    The plane's frame has its origin at the shoulder, x pointing away from the base's axis and y up.
    """

    lengths: tuple[float, float, float]
    """Of the links a_1, a_2, a_3 [m]."""
    lower: tuple[float, float, float]
    """Lower limits of the relative angles θ_1, θ_2 − θ_1, θ_3 − θ_2 [rad]."""
    upper: tuple[float, float, float]
    """Upper limits [rad]."""
    offset: float
    """Of the shoulder from the base's axis [m]."""
    height: float
    """Of the shoulder over the base [m]."""

    @cached_property
    def reach(self) -> float:
        """Of the stretched arm from the shoulder [m]."""
        return sum(self.lengths)

    @cached_property
    def middle(self) -> Array:
        """The middle of the limits (3,), relative angles [rad]."""
        return 0.5 * (np.array(self.lower) + np.array(self.upper))

    def tool(self, relative: Array) -> Array:
        """Tool points (2,N) [m] of relative angles (3,N) [rad], equations 1 and 2."""
        angles, lengths = np.cumsum(relative, axis=0), np.array(self.lengths)
        return np.array([lengths @ np.cos(angles), lengths @ np.sin(angles)])

    def error(self, relative: Array, target: Array) -> Array:
        """Distances (N,) [m] of the tool from targets (2,N) [m] at relative angles (3,N) [rad]."""
        return np.hypot(*(self.tool(relative) - target))

    def contains(self, relative: Array, tolerance: float) -> Bools:
        """Whether relative angles (3,…) [rad] are inside the limits; NaN is not."""
        inside = np.ones(relative.shape[1:], dtype=bool)
        for q, low, high in zip(relative, self.lower, self.upper):
            inside &= (q >= low - tolerance) & (q <= high + tolerance)
        return inside

    def clip(self, relative: Array) -> Array:
        """Relative angles (3,N) [rad], those beyond a limit moved to it."""
        lower, upper = (np.array(limit)[:, None] for limit in (self.lower, self.upper))
        return np.clip(relative, lower, upper)


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
