"""A rectangle of a workplane in front of an arm."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from math import cos, sin
from numbers import Integral
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finite, check_finites
from fikm_drake.resources import load_model


@dataclass
class Workplane:
    """A horizontal rectangle, with coordinates of its own in mm.

    x runs to the right along the near edge, y away from the arm, both from the near left corner;
    the height is over the workplane.

    Attributes:
        origin: the near left corner in the arm's base frame, which is the world's where it is
            welded [m].
        yaw: angle of the near edge about the vertical [rad]; 0: it runs along the world's x.
        size: width along x and depth along y [mm], integers.
    """

    origin: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    yaw: float = 0.0
    size: list[int] = field(default_factory=lambda: [400, 300])

    def validate(self) -> None:
        """Raise ValueError, naming the bad value, unless this is a rectangle."""
        check_finites("origin", self.origin, 3, "m")
        check_finite("yaw [rad]", self.yaw)
        check_finites("size", self.size, 2, "mm")
        if not all(isinstance(s, Integral) and s > 0 for s in self.size):
            raise ValueError(f"size must be two positive integers [mm], got {self.size}")

    def to_world(self, points: ArrayLike) -> Array:
        """Points (…,2) of the workplane [mm] in the world (…,3) [m]; ValueError for another shape."""
        return _rows("points", points, 2) / 1000 @ self._axes()[:2] + self.origin

    def from_world(self, positions: ArrayLike) -> Array:
        """x, y and height over the workplane (…,3) [mm] of positions (…,3) in the world [m].

        Raises:
            ValueError: positions of another shape.
        """
        return 1000 * (_rows("positions", positions, 3) - self.origin) @ self._axes().T

    def grid(self, every: int = 1) -> NDArray[np.int64]:
        """Points at every whole millimetre, or every so many (nx, ny, 2)."""
        width, depth = self.size
        return np.moveaxis(np.mgrid[: width + 1 : every, : depth + 1 : every], 0, -1)

    def _axes(self) -> Array:
        """Unit vectors along x, y and up in the world, as rows."""
        c, s = cos(self.yaw), sin(self.yaw)
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _rows(name: str, values: ArrayLike, size: int) -> Array:
    array = np.asarray(values, dtype=float)
    if array.shape[-1:] != (size,):
        raise ValueError(f"{name} must be (…, {size}), got {array.shape}")
    return array


def load_workplane(name_or_path: str | Path) -> Workplane:
    """Load a workplane by the name of one of our models or from a YAML file of your own.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file does not describe a workplane; the message says what is wrong.
    """
    return load_model(Workplane, name_or_path, folder="workplanes", kind="workplane")
