"""A zero-order Sugeno rule base of two inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.triangular_partition import TriangularPartition


class RuleBase:
    """Rules "IF x is A AND y is B THEN z is w", one for every pair of memberships.

    Equations 16-19 of Xu and Nechyba (1993): a rule's truth is the product of its two grades and
    the output is the sum of truth times consequent. The memberships of each input sum to one, and
    at most two are not zero, so this sum is the bilinear interpolation of the consequents. That is
    how it is computed: four rules are looked at, however many there are. An instance never changes.
    """

    def __init__(
        self,
        first: TriangularPartition,
        second: TriangularPartition,
        consequents: ArrayLike,
        names: tuple[str, str, str] = ("x", "y", "z"),
    ) -> None:
        """Makes a rule base.

        Args:
            first: memberships of the first input (n1).
            second: memberships of the second input (n2).
            consequents: output of each rule, shape (n1, n2), in the unit of the output; the rows
                follow the first input.
            names: names of the first input, the second input and the output.

        Raises:
            ValueError: the consequents have another shape or are not finite, or there are not
                three names.
        """
        array = np.array(consequents, dtype=float)
        if array.shape != (len(first), len(second)):
            raise ValueError(
                f"consequents must have shape {(len(first), len(second))}, got {array.shape}"
            )
        for value in array[~np.isfinite(array)]:
            raise ValueError(f"consequents must be finite, got {value}")
        if len(names) != 3:
            raise ValueError(f"names must be three (two inputs, one output), got {names}")
        array.flags.writeable = False

        self._first = first
        self._second = second
        self._consequents = array
        self._names = names
        self._rows: list[list[float]] = array.tolist()

    @property
    def first(self) -> TriangularPartition:
        """Memberships of the first input."""
        return self._first

    @property
    def second(self) -> TriangularPartition:
        """Memberships of the second input."""
        return self._second

    @property
    def consequents(self) -> Array:
        """Outputs of the rules, shape (n1, n2), read-only; rows follow the first input."""
        return self._consequents

    @property
    def names(self) -> tuple[str, str, str]:
        """Names of the two inputs and of the output."""
        return self._names

    @property
    def size(self) -> int:
        """Number of rules, n1 n2 (equation 16)."""
        return self._consequents.size

    def __repr__(self) -> str:
        x, y, z = self._names
        n1, n2 = self._consequents.shape
        return f"<{type(self).__name__} {z}({x}, {y}), {n1} x {n2} rules>"

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Infers the output for arrays of inputs.

        Args:
            x: first input, any shape.
            y: second input, any shape that broadcasts with that of x.

        Returns:
            The output, of the broadcast shape; NaN where an input is NaN. Inputs outside their
            range count as the nearest end of it.
        """
        i, f = self._first.locate_array(x)
        j, g = self._second.locate_array(y)
        w = self._consequents
        low = (1.0 - g) * w[i, j] + g * w[i, j + 1]
        high = (1.0 - g) * w[i + 1, j] + g * w[i + 1, j + 1]
        return (1.0 - f) * low + f * high

    def evaluate(self, x: float, y: float) -> float:
        """Infers one output in plain floats, for a control loop (about a microsecond).

        Args:
            x: first input.
            y: second input.

        Returns:
            The output, the same number that calling the rule base gives.
        """
        i, f = self._first.locate(x)
        j, g = self._second.locate(y)
        low = self._rows[i]
        high = self._rows[i + 1]
        if g == 0.0:  # as it often is, and the same number
            return (1.0 - f) * low[j] + f * high[j]
        k = j + 1
        h = 1.0 - g
        return (1.0 - f) * (h * low[j] + g * low[k]) + f * (h * high[j] + g * high[k])

    def scaled(self, first_factor: float = 1.0, output_factor: float = 1.0) -> RuleBase:
        """Changes the range of the first input and of the output, exactly.

        This is the remark of section 3 of Xu and Nechyba (1993): since dθ is proportional to dr,
        the range of dr may be stretched when the consequents are stretched alike.

        Args:
            first_factor: the knots of the first input are multiplied by it; finite, positive.
            output_factor: the consequents are multiplied by it; finite.

        Returns:
            A new rule base, s(x, y) = output_factor * self(x / first_factor, y).

        Raises:
            ValueError: a factor is not as described.
        """
        return RuleBase(*self._scaled_parts(first_factor, output_factor), names=self._names)

    def _scaled_parts(
        self, first_factor: float, output_factor: float
    ) -> tuple[TriangularPartition, TriangularPartition, Array]:
        if not (math.isfinite(first_factor) and first_factor > 0.0):
            raise ValueError(f"first_factor must be finite and positive, got {first_factor}")
        if not math.isfinite(output_factor):
            raise ValueError(f"output_factor must be finite, got {output_factor}")
        first = TriangularPartition(first_factor * self._first.knots, self._first.labels)
        return first, self._second, output_factor * self._consequents

    def rules(self) -> list[str]:
        """Readable rules in the order of equation 17, the second input running fastest."""
        x, y, z = self._names
        return [
            f"IF {x} is {a} AND {y} is {b} THEN {z} is {w:.4g}"
            for a, row in zip(self._first.labels, self._rows)
            for b, w in zip(self._second.labels, row)
        ]

    def table(self, digits: int = 4) -> str:
        """The rule base as a grid like Table II: rows follow the first input.

        Args:
            digits: decimals of the consequents.

        Returns:
            Lines of equal length: a line of labels, then one line a membership of the first input.
        """
        x, y, _ = self._names
        header = [f"{x} \\ {y}", *self._second.labels]
        # Adding zero to the rounded value turns -0.0000 into 0.0000.
        body = [
            [label, *(f"{round(w, digits) + 0.0:.{digits}f}" for w in row)]
            for label, row in zip(self._first.labels, self._rows)
        ]
        return aligned([header, *body])


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Rows of equally many cells as lines of equal length, columns to the right."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in rows
    )
