"""Triangular memberships that sum to one over a range."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array


def _letters(index: int) -> str:
    """Spreadsheet column name of a zero-based index: A, B, ..., Z, AA, AB, ..."""
    name = ""
    index += 1
    while index:
        index, letter = divmod(index - 1, 26)
        name = chr(ord("A") + letter) + name
    return name


class TriangularPartition:
    """A range divided by knots, each the peak of one triangular membership.

    Neighbouring memberships cross at one half and all grades sum to one, as in figure 4 of
    Xu and Nechyba (1993). Beyond the outermost knots the outermost membership has grade one.
    An instance never changes.
    """

    __slots__ = ("_knot_list", "_knots", "_labels", "_last")

    def __init__(self, knots: ArrayLike, labels: Sequence[str] | None = None) -> None:
        """Makes a partition.

        Args:
            knots: peaks of the memberships, shape (n,), n >= 2, finite, strictly increasing; in
                the unit of the input.
            labels: n different names; A, B, C, ... by default.

        Raises:
            ValueError: the knots or the labels are not as described.
        """
        array = np.array(knots, dtype=float)
        if array.ndim != 1 or array.size < 2:
            raise ValueError(f"knots must be at least 2 values in one row, got shape {array.shape}")
        for value in array[~np.isfinite(array)]:
            raise ValueError(f"knots must be finite, got {value}")
        with np.errstate(over="ignore"):
            widths = np.diff(array)
        for k in np.flatnonzero(~(widths > 0.0)):
            raise ValueError(
                f"knots must increase strictly, got {array[k]} followed by {array[k + 1]}"
            )
        for k in np.flatnonzero(np.isinf(widths)):
            raise ValueError(f"knots {array[k]} and {array[k + 1]} are too far apart for a double")
        array.flags.writeable = False

        names = tuple(map(_letters, range(array.size)) if labels is None else labels)
        if len(names) != array.size:
            raise ValueError(f"got {len(names)} labels {names} for {array.size} knots")
        if len(set(names)) != len(names):
            raise ValueError(f"labels must differ from one another, got {names}")

        self._knots = array
        self._labels = names
        self._knot_list: list[float] = array.tolist()
        self._last = array.size - 1

    @property
    def knots(self) -> Array:
        """Peaks of the memberships, shape (n,), read-only."""
        return self._knots

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the memberships."""
        return self._labels

    def __len__(self) -> int:
        return self._last + 1

    def __repr__(self) -> str:
        return f"TriangularPartition({self._knot_list}, labels={list(self._labels)})"

    def locate(self, x: float) -> tuple[int, float]:
        """Finds the two memberships that a value belongs to, in plain floats.

        Args:
            x: the value.

        Returns:
            (index, fraction): membership `index` has grade 1 - fraction, membership index + 1 has
            grade fraction, in [0, 1]. NaN in gives NaN as the fraction, with a valid index.
        """
        knots = self._knot_list
        index = bisect_right(knots, x, 1, self._last) - 1
        left = knots[index]
        fraction = (x - left) / (knots[index + 1] - left)
        # Written so that NaN, which fails both comparisons, passes through.
        if fraction < 0.0:
            return index, 0.0
        if fraction > 1.0:
            return index, 1.0
        return index, fraction

    def locate_array(self, x: ArrayLike) -> tuple[NDArray[np.intp], Array]:
        """Does what `locate` does for every element of an array, to the last bit.

        Args:
            x: values, any shape.

        Returns:
            (index, fraction), both of the shape of x.
        """
        x = np.asarray(x, dtype=float)
        knots = self._knots
        index = np.searchsorted(knots[1:-1], x, side="right")
        left = knots[index]
        return index, np.clip((x - left) / (knots[index + 1] - left), 0.0, 1.0)

    def grades(self, x: ArrayLike) -> Array:
        """Grades of all memberships.

        Args:
            x: values, any shape (...).

        Returns:
            Grades in [0, 1] that sum to one, shape (..., n); all NaN where x is NaN.
        """
        index, fraction = self.locate_array(x)
        index, fraction = np.asarray(index)[..., None], np.asarray(fraction)[..., None]
        grades = np.zeros((*index.shape[:-1], len(self)))
        np.put_along_axis(grades, index, 1.0 - fraction, axis=-1)
        np.put_along_axis(grades, index + 1, fraction, axis=-1)
        return np.where(np.isnan(fraction), np.nan, grades)
