"""What a run's tool shall follow: corners, poses, a circle, a table, or any of Drake's trajectories."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from math import cos, pi, sin

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.trajectories import (
    PathParameterizedTrajectory,
    PiecewisePolynomial,
    PiecewiseQuaternionSlerp,
)

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finites, check_not_negative, check_positive_finite
from fikm_drake.simulation.scenario.motion import PROFILES, Motion, Pose, along_path, rotation_at
from fikm_drake.simulation.scenario.samples import Csv, Samples

SHAPES = ("polyline", "spline")
TURN_LENGTH = 0.3
"""Where poses follow each other a turn of 1 rad takes as long as this way [m]."""


@dataclass
class Path:
    """Corners to pass one after the other, then to hold at the last.

    One corner, or a duration of 0, is a step: the target is the last corner from the start.

    Attributes:
        positions: corners [m]: pairs are (x, y), and only these rows count, or triples; or
        poses: corners with orientation. One of the two.
        duration: from the first to the last corner [s].
        hold: at the last corner afterwards [s].
        profile: `constant` speed along the path, or `cubic`: at rest at both ends.
        shape: `polyline`, or `spline`: a smooth curve through the corners.
    """

    positions: list[list[float]] = field(default_factory=list)
    poses: list[Pose] = field(default_factory=list)
    duration: float = 0.0
    hold: float = 0.4
    profile: str = "constant"
    shape: str = "polyline"

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if bool(self.positions) == bool(self.poses):
            raise ValueError("a target needs either positions or poses")
        for pose in self.poses:
            pose.validate()
        points = self._points()
        if points.ndim != 2 or points.shape[1] not in (2, 3):
            raise ValueError(f"positions must be pairs or triples [m], got shape {points.shape}")
        if not np.isfinite(points).all():
            raise ValueError(f"positions must be finite [m], got {self.positions}")
        _check_times(self)
        if self.shape not in SHAPES:
            raise ValueError(f"shape must be one of {SHAPES}, got {self.shape!r}")

    def motion(self) -> Motion:
        """The target over time."""
        points = self._points()
        rotations = [pose.rotation() for pose in self.poses]
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if rotations:
            turns = [_angle(a, b) for a, b in zip(rotations, rotations[1:])]
            lengths = lengths + TURN_LENGTH * np.array(turns)
        keep = np.flatnonzero(
            np.concatenate([[True], lengths > 0.0])
        )  # a path does not pause at a repeated corner
        breaks = np.concatenate([[0.0], np.cumsum(lengths[lengths > 0.0])])
        size = 7 if rotations else points.shape[1]
        if len(breaks) < 2 or self.duration == 0.0:
            last = points[-1]
            turn = (lambda _: rotations[-1]) if rotations else None
            return Motion(size, 0.0, lambda _: last, turn, points)
        along = along_path(self.profile, self.duration, breaks[-1])
        if self.shape == "spline" and len(breaks) > 2:
            path = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(breaks, points[keep].T)
            corners = path.vector_values(np.linspace(0.0, breaks[-1], 40 * len(breaks))).T
        else:
            path, corners = PiecewisePolynomial.FirstOrderHold(breaks, points[keep].T), points
        timed = PathParameterizedTrajectory(path, along)
        turn = None
        if rotations:
            slerp = PiecewiseQuaternionSlerp(breaks, [rotations[i] for i in keep])
            turn = lambda t: rotation_at(slerp, float(along.value(t)[0, 0]))  # noqa: E731
        return Motion(size, self.duration, lambda t: timed.value(t)[:, 0], turn, corners)

    def _points(self) -> Array:
        try:
            return np.array([p.xyz for p in self.poses] or self.positions, dtype=float)
        except (TypeError, ValueError) as error:
            raise ValueError(
                f"positions must be rows of one length, got {self.positions}"
            ) from error


@dataclass
class Circle:
    """A circle about a point, at constant speed or at rest at both ends.

    Attributes:
        center: its middle [m], (x, y) or (x, y, z).
        radius: [m].
        normal: the axis about which it turns, for a centre of three numbers.
        start: angle of its first point, from the world's x (y where the normal is x) [rad].
        cycles: how many turns; negative: clockwise.
        rpy: orientation of the tool meanwhile [rad]; empty: it does not count.
        duration: of all turns [s].
        hold: at the end [s].
        profile: `constant` or `cubic`.
    """

    center: list[float] = field(default_factory=list)
    radius: float = 0.1
    normal: list[float] = field(default_factory=lambda: [0.0, 0.0, 1.0])
    start: float = 0.0
    cycles: float = 1.0
    rpy: list[float] = field(default_factory=list)
    duration: float = 5.0
    hold: float = 0.4
    profile: str = "constant"

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if len(self.center) not in (2, 3):
            raise ValueError(f"center must be (x, y) or (x, y, z) [m], got {self.center}")
        check_finites("center", self.center, len(self.center), "m")
        check_positive_finite("radius", self.radius, "m")
        if not np.linalg.norm(check_finites("normal", self.normal, 3, "-")) > 0.0:
            raise ValueError(f"normal must not be zero, got {self.normal}")
        if len(self.center) == 2 and self.normal != [0.0, 0.0, 1.0]:
            raise ValueError("normal is not used for a centre of two numbers")
        if self.rpy:
            check_finites("rpy", self.rpy, 3, "rad")
        check_finites("start and cycles", [self.start, self.cycles], 2, "rad, -")
        _check_times(self)
        if not self.duration:
            raise ValueError("duration of a circle must be positive [s]")

    def motion(self) -> Motion:
        """The target over time."""
        z = np.array(self.normal) / np.linalg.norm(self.normal)
        x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
        x = x - (x @ z) * z
        axes = np.stack([x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x))])
        axes = axes[:, : len(self.center)]
        angle = along_path(self.profile, self.duration, 2 * pi * self.cycles)

        def at(turned: float) -> Array:
            phi = self.start + turned
            return np.array(self.center) + self.radius * (cos(phi) * axes[0] + sin(phi) * axes[1])

        whole = np.linspace(0.0, 2 * pi * self.cycles, 1 + max(8, int(120 * abs(self.cycles))))
        corners = np.array([at(turned) for turned in whole])
        rotation = RotationMatrix(RollPitchYaw(self.rpy)) if self.rpy else None
        if rotation is not None and len(self.center) == 2:
            raise ValueError("a circle with rpy needs a centre of three numbers")
        return Motion(
            7 if rotation else len(self.center),
            self.duration,
            lambda t: at(float(angle.value(t)[0, 0])),
            (lambda _: rotation) if rotation else None,
            corners,
        )


Target = Path | Circle | Csv | Samples
"""In YAML by a tag, `target: !Circle {…}`; without one a `Path`."""


def _check_times(target: Path | Circle) -> None:
    for name in ("duration", "hold"):
        check_not_negative(name, getattr(target, name))
    if target.profile not in PROFILES:
        raise ValueError(f"profile must be one of {PROFILES}, got {target.profile!r}")


def _angle(a: RotationMatrix, b: RotationMatrix) -> float:
    return float((a.inverse() @ b).ToAngleAxis().angle())
