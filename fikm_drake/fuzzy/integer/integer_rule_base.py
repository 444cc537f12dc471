"""Inference in integers: two inputs, any number of outputs."""

from __future__ import annotations

from operator import index
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Bools
from fikm_drake.fuzzy.integer.integer_partition import (
    ROUNDINGS,
    IntegerPartition,
    Integers,
    Rounding,
    check_choice,
)

Conjunction = Literal["min", "product"]
CONJUNCTIONS: tuple[Conjunction, ...] = ("min", "product")
LARGEST = 2**31 - 1
"""Largest value of a singleton: 32 bits."""
SPAN = 2**16 - 1
"""Largest difference between two singletons of an output: the C tables hold 16 bits."""


class IntegerRuleBase:
    """Rules "IF x is A AND y is B THEN outputs are singletons", one for every pair of memberships.

    Equation 5 of Tojo and Morishita (2010) in integers: the output is least + Σ ω (s − least) / Σ ω,
    with ω the rule's grade and `least` the output's smallest singleton, so that no number is
    negative and cutting decimals off means the same in every language. All numbers fit 32 bits
    without a sign. An instance never changes.

    `infer` (Python integers) and `infer_batch` (numpy) give the same integers.
    """

    def __init__(
        self,
        first: IntegerPartition,
        second: IntegerPartition,
        singletons: ArrayLike,
        *,
        conjunction: Conjunction = "min",
        rounding: Rounding = "truncate",
    ) -> None:
        """Makes a rule base.

        Args:
            first: memberships of the first input (n1).
            second: memberships of the second input (n2).
            singletons: integers (n1, n2, outputs) of 32 bits in the unit of the outputs.
            conjunction: `min` as in the paper, or `product`.
            rounding: `truncate` as in the paper, or `nearest`; of the grades and of the outputs.

        Raises:
            ValueError: an argument is not as described, or the singletons of an output differ by
                more than 65535.
        """
        check_choice("conjunction", conjunction, CONJUNCTIONS)
        check_choice("rounding", rounding, ROUNDINGS)
        table = checked_integers("singletons", singletons)
        shape = (len(first), len(second))
        if table.ndim != 3 or table.shape[:2] != shape or table.shape[2] < 1:
            raise ValueError(
                f"singletons must have shape (*{shape}, outputs), got {np.shape(singletons)}"
            )
        for value in (int(table.min()), int(table.max())):
            if abs(value) > LARGEST:
                raise ValueError(f"singletons must be from {-LARGEST} to {LARGEST}, got {value}")
        least = table.min(axis=(0, 1))
        offsets = table - least
        for j in np.flatnonzero(offsets.max(axis=(0, 1)) > SPAN):
            raise ValueError(
                f"singletons of output {j + 1} must differ by at most {SPAN}, "
                f"got {offsets[..., j].max()}; choose a coarser unit"
            )
        table.flags.writeable = False
        self._first = first
        self._second = second
        self._conjunction: Conjunction = conjunction
        self._rounding: Rounding = rounding
        self._singletons = table
        self._least = least
        self._offsets = offsets
        self._least_list: list[int] = least.tolist()
        self._rows: list[list[list[int]]] = offsets.tolist()

    @property
    def first(self) -> IntegerPartition:
        """Memberships of the first input."""
        return self._first

    @property
    def second(self) -> IntegerPartition:
        """Memberships of the second input."""
        return self._second

    @property
    def conjunction(self) -> Conjunction:
        """AND of a rule."""
        return self._conjunction

    @property
    def rounding(self) -> Rounding:
        """Rounding of the grades and of the outputs."""
        return self._rounding

    @property
    def singletons(self) -> Integers:
        """Outputs of the rules (n1, n2, outputs), read-only."""
        return self._singletons

    @property
    def least(self) -> Integers:
        """The smallest singleton of each output (outputs,)."""
        return self._least.copy()

    @property
    def num_outputs(self) -> int:
        """The number of outputs."""
        return len(self._least_list)

    @property
    def size(self) -> int:
        """The number of rules, n1 n2."""
        return len(self._first) * len(self._second)

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} {len(self._first)} x {len(self._second)} rules, "
            f"{self.num_outputs} outputs, {self._conjunction}, {self._rounding}>"
        )

    def infer(self, x: int, y: int) -> tuple[list[int], bool]:
        """Infers the outputs of one input in Python integers (a few microseconds).

        Args:
            x: first input.
            y: second input.

        Returns:
            The outputs, and True if the input lies outside the rules' range: the outputs are then
            those of the nearest input inside.

        Raises:
            TypeError: an input is not an integer.
        """
        x, y = index(x), index(y)
        i, a, b = self._first.locate(x, self._rounding)
        j, c, d = self._second.locate(y, self._rounding)
        if self._conjunction == "min":
            ac, ad, bc, bd = min(a, c), min(a, d), min(b, c), min(b, d)
        else:
            ac, ad, bc, bd = a * c, a * d, b * c, b * d
        total = ac + ad + bc + bd
        half = total // 2 if self._rounding == "nearest" else 0
        near, far = self._rows[i], self._rows[i + 1]
        outputs = [
            least + (ac * p + ad * q + bc * r + bd * s + half) // total
            for least, p, q, r, s in zip(self._least_list, near[j], near[j + 1], far[j], far[j + 1])
        ]
        inside = (
            self._first.low <= x <= self._first.high and self._second.low <= y <= self._second.high
        )
        return outputs, not inside

    def infer_batch(self, x: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.int64], Bools]:
        """Infers the outputs of arrays of integers, as `infer` does.

        Args:
            x: first input, integers of any shape.
            y: second input, integers of any shape that broadcasts with that of x.

        Returns:
            The outputs (…, outputs) and whether each input lies outside the rules' range (…).

        Raises:
            ValueError: the inputs are not integers or do not broadcast.
        """
        x, y = np.broadcast_arrays(checked_integers("x", x), checked_integers("y", y))
        i, a, b = self._first.locate_array(x, self._rounding)
        j, c, d = self._second.locate_array(y, self._rounding)
        AND = np.minimum if self._conjunction == "min" else np.multiply
        corners = [(i, j, AND(a, c)), (i, j + 1, AND(a, d))]
        corners += [(i + 1, j, AND(b, c)), (i + 1, j + 1, AND(b, d))]
        total = np.asarray(sum(weight for _, _, weight in corners))[..., None]
        sums = np.zeros((*x.shape, self.num_outputs), dtype=np.int64)
        for row, column, weight in corners:
            sums += weight[..., None] * self._offsets[row, column]
        if self._rounding == "nearest":
            sums += total // 2
        outside = (x < self._first.low) | (x > self._first.high)
        outside |= (y < self._second.low) | (y > self._second.high)
        return self._least + sums // total, outside


def checked_integers(name: str, values: ArrayLike) -> Integers:
    """The values as a new array of 64-bit integers; ValueError, naming them, unless they are integers."""
    array = np.asarray(values)
    if array.dtype.kind not in "iu" or not np.can_cast(array.dtype, np.int64):
        raise ValueError(f"{name} must be integers that fit int64, got {array.dtype}")
    return array.astype(np.int64)
