"""Measured joint positions at points of a workplane."""

from math import ceil, floor
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.integer import IntegerPartition, fit_singletons
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction


class WorkplaneData:
    """Joint positions measured at points of a workplane, as those of a person in section 3.3.

    Args:
        points: x, y (k,2) [mm].
        positions: joint positions there (k,n), without jumps by a full turn [rad].

    Raises:
        ValueError: the shapes do not fit, or a number is not finite.
    """

    def __init__(self, points: ArrayLike, positions: ArrayLike) -> None:
        self._points = np.array(points, dtype=float)
        self._positions = np.array(positions, dtype=float)
        if self._points.ndim != 2 or self._points.shape[1] != 2:
            raise ValueError(f"points must be (k, 2), got {self._points.shape}")
        if self._positions.ndim != 2 or len(self._positions) != len(self._points):
            raise ValueError(
                f"positions must be ({len(self._points)}, n), got {self._positions.shape}"
            )
        for name, array in (("points", self._points), ("positions", self._positions)):
            for row in np.flatnonzero(~np.isfinite(array).all(axis=1)):
                raise ValueError(f"{name} must be finite, got {array[row].tolist()} in row {row}")
        if not self._positions.size:
            raise ValueError("there must be at least one point and one joint")

    def singletons(
        self, labels: tuple[int, int], conjunction: Conjunction, *, least_squares: bool
    ) -> tuple[IntegerPartition, IntegerPartition, Array]:
        """Memberships of x and y and singletons (n1, n2, n).

        Points that are a grid of `labels` whole millimetres, in any order, are the peaks themselves.
        Otherwise the peaks are evenly spaced over the points' range, and the singletons are fitted.

        Args:
            labels: memberships of x and of y, 2 to 33 each.
            conjunction: `min` or `product`, which counts for the fit only.
            least_squares: True: fitted even if the points are such a grid.

        Raises:
            ValueError: the data do not determine every singleton.
        """
        x, y = (np.unique(column) for column in self._points.T)
        if not least_squares and self._is_grid(x, y, labels):
            order = np.lexsort((self._points[:, 1], self._points[:, 0]))
            table = self._positions[order].reshape(len(x), len(y), -1)
            first, second = (IntegerPartition([int(knot) for knot in axis]) for axis in (x, y))
            return first, second, table
        first = IntegerPartition.even(floor(x[0]), ceil(x[-1]), labels[0])
        second = IntegerPartition.even(floor(y[0]), ceil(y[-1]), labels[1])
        fitted = fit_singletons(first, second, self._points, self._positions, conjunction)
        return first, second, fitted

    def _is_grid(self, x: Array, y: Array, labels: tuple[int, int]) -> bool:
        """True if the points are all pairs of these coordinates, whole and as many as `labels`."""
        whole = bool((self._points == np.rint(self._points)).all())
        pairs = len(np.unique(self._points, axis=0)) == len(self._points) == len(x) * len(y)
        return whole and pairs and (len(x), len(y)) == tuple(labels)


def load_workplane_data(path: str | Path) -> WorkplaneData:
    """Read points and joint positions from a CSV file.

    Each line holds x, y [mm] and the joint positions [degrees]; a first line of names is skipped, and
    so are lines that begin with `#`.

    Raises:
        OSError: the file cannot be read.
        ValueError: the file does not hold such a table; the message names it.
    """
    lines = [line for line in Path(path).read_text("utf-8").splitlines() if line.strip()]
    lines = [line for line in lines if not line.lstrip().startswith("#")]
    try:
        float(lines[0].split(",")[0])
    except (IndexError, ValueError):
        lines = lines[1:]
    try:
        table = np.array([[float(word) for word in line.split(",")] for line in lines])
        if table.ndim != 2 or table.shape[1] < 3:
            raise ValueError("each line must hold x, y and at least one joint position")
        return WorkplaneData(table[:, :2], np.deg2rad(table[:, 2:]))
    except ValueError as error:
        raise ValueError(f"{path} is not a table of points and joint positions: {error}") from error
