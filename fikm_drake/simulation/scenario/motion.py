"""A target over time, and poses in YAML."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.trajectories import PiecewisePolynomial, PiecewiseQuaternionSlerp

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finites

PROFILES = ("constant", "cubic")


@dataclass(frozen=True)
class Motion:
    """A target over time."""

    size: int
    """2: x and y, 3: a position, 7: a pose."""
    duration: float
    """Until it rests [s]."""
    position: Callable[[float], Array]
    """Position of the time [s]: (2,) or (3,) [m]."""
    orientation: Callable[[float], RotationMatrix] | None
    """Orientation of the time [s]; None: it does not count."""
    corners: Array
    """The path as a polyline (k,2) or (k,3) [m]."""

    def numbers(self, time: float) -> Array:
        """Position [m], or quaternion w, x, y, z and position, as logs have it."""
        if self.orientation is None:
            return self.position(time)
        quaternion = self.orientation(time).ToQuaternion().wxyz()
        return np.concatenate([quaternion, self.position(time)])

    def pose(self, time: float) -> RigidTransform:
        """X_WE of a target with an orientation."""
        assert self.orientation is not None
        return RigidTransform(self.orientation(time), self.position(time))


@dataclass
class Pose:
    """A pose of the tool in the world.

    Attributes:
        xyz: where [m].
        rpy: roll, pitch and yaw [rad], or
        quaternion: w, x, y, z, of any length but 0. One of the two.
    """

    xyz: list[float] = field(default_factory=list)
    rpy: list[float] = field(default_factory=list)
    quaternion: list[float] = field(default_factory=list)

    def rotation(self) -> RotationMatrix:
        """The orientation."""
        if self.rpy:
            return RotationMatrix(RollPitchYaw(self.rpy))
        return RotationMatrix(
            Quaternion(np.array(self.quaternion) / np.linalg.norm(self.quaternion))
        )

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        check_finites("xyz", self.xyz, 3, "m")
        if bool(self.rpy) == bool(self.quaternion):
            raise ValueError("a pose needs either rpy or quaternion, got " + repr(self))
        if self.rpy:
            check_finites("rpy", self.rpy, 3, "rad")
        elif not np.linalg.norm(check_finites("quaternion", self.quaternion, 4, "-")) > 0.0:
            raise ValueError(f"quaternion must not be zero, got {self.quaternion}")


def along_path(profile: str, duration: float, length: float) -> PiecewisePolynomial:
    """The way along a path of this length [m] over time, for a profile of `PROFILES`."""
    times, ends = [0.0, duration], np.array([[0.0, length]])
    if profile == "cubic":
        return PiecewisePolynomial.CubicHermite(times, ends, np.zeros((1, 2)))
    return PiecewisePolynomial.FirstOrderHold(times, ends)


def rotation_at(slerp: PiecewiseQuaternionSlerp, at: float) -> RotationMatrix:
    """Rotation of a slerp at a place of its breaks."""
    return RotationMatrix(Quaternion(slerp.orientation(at).wxyz()))
