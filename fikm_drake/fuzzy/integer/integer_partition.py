"""Triangular memberships of an integer input, with grades from 0 to 255."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from numbers import Integral
from operator import index
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

GRADE = 255
"""The largest grade (section 3.2 of Tojo & Morishita 2010)."""
MOST_LABELS = 33
"""The most memberships of an input."""
LIMIT = 32767
"""Knots are from −LIMIT to LIMIT: 16 bits."""
Rounding = Literal["truncate", "nearest"]
ROUNDINGS: tuple[Rounding, ...] = ("truncate", "nearest")
Integers = NDArray[np.int64]
Number = TypeVar("Number", int, Integers)


class IntegerPartition:
    """A range of integers divided by knots, each the peak of one triangular membership.

    Between two knots, one membership rises from 0 to 255 and one falls. Rounding `truncate` cuts
    the decimals off both grades, as the paper does: they add up to 255 or 254. Rounding `nearest`
    rounds the rising grade and takes the falling one as its complement to 255. An input outside
    the range counts as the nearest end of it. An instance never changes.
    """

    __slots__ = ("_knot_list", "_knots", "_last")

    def __init__(self, knots: Sequence[int]) -> None:
        """Makes a partition.

        Args:
            knots: peaks of the memberships in the unit of the input, 2 to 33 integers of 16 bits,
                strictly increasing.

        Raises:
            ValueError: the knots are not as described.
        """
        try:
            values = [index(knot) for knot in knots]
        except TypeError as error:
            raise ValueError(f"knots must be integers, got {list(knots)}") from error
        if not 2 <= len(values) <= MOST_LABELS:
            raise ValueError(f"there must be 2 to {MOST_LABELS} knots, got {len(values)}")
        for knot in values:
            if abs(knot) > LIMIT:
                raise ValueError(f"knots must be from {-LIMIT} to {LIMIT}, got {knot}")
        for left, right in zip(values, values[1:]):
            if not left < right:
                raise ValueError(f"knots must increase strictly, got {left} followed by {right}")
        self._knot_list = values
        self._knots = np.array(values, dtype=np.int64)
        self._knots.flags.writeable = False
        self._last = len(values) - 1

    @classmethod
    def even(cls, low: int, high: int, count: int) -> IntegerPartition:
        """A partition whose knots are evenly spaced, each rounded to an integer.

        Raises:
            ValueError: as of the constructor, or the range is too short for so many knots.
        """
        if not isinstance(count, Integral) or not 2 <= count <= MOST_LABELS:
            raise ValueError(f"there must be 2 to {MOST_LABELS} labels, got {count!r}")
        return cls([int(knot) for knot in np.rint(np.linspace(low, high, count))])

    @property
    def knots(self) -> Integers:
        """Peaks of the memberships, shape (n,), read-only."""
        return self._knots

    @property
    def low(self) -> int:
        """The least input of the range."""
        return self._knot_list[0]

    @property
    def high(self) -> int:
        """The largest input of the range."""
        return self._knot_list[-1]

    def __len__(self) -> int:
        return self._last + 1

    def __repr__(self) -> str:
        return f"IntegerPartition({self._knot_list})"

    def locate(self, x: int, rounding: Rounding) -> tuple[int, int, int]:
        """Finds the two memberships that a value belongs to, in Python integers.

        Args:
            x: the value.
            rounding: of the grades.

        Returns:
            (cell, fall, rise): membership `cell` has grade `fall`, membership `cell` + 1 has grade
            `rise`.
        """
        knots = self._knot_list
        x = min(max(x, knots[0]), knots[-1])
        cell = bisect_right(knots, x, 1, self._last) - 1
        left = knots[cell]
        return cell, *_grades(x - left, knots[cell + 1] - left, rounding)

    def locate_array(self, x: Integers, rounding: Rounding) -> tuple[Integers, Integers, Integers]:
        """Does what `locate` does for every element of an array of integers, to the last bit."""
        knots = self._knots
        x = np.clip(x, knots[0], knots[-1])
        cell = np.searchsorted(knots[1:-1], x, side="right")
        left = knots[cell]
        return cell, *_grades(x - left, knots[cell + 1] - left, rounding)


def _grades(offset: Number, width: Number, rounding: Rounding) -> tuple[Number, Number]:
    """The falling and the rising grade at `offset` from the left end of a cell."""
    if rounding == "nearest":
        rise = (GRADE * offset + width // 2) // width
        return GRADE - rise, rise
    return GRADE * (width - offset) // width, GRADE * offset // width


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise ValueError, naming the choices, unless the value is one of them."""
    if value not in choices:
        raise ValueError(f"{name} must be one of {choices}, got {value!r}")
