"""A fuzzy variable: a range and the names of its parts."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from math import nan

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finite
from fikm_drake.fuzzy.membership_stack import MembershipStack
from fikm_drake.fuzzy.memberships import Membership, Triangle
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

NOT = "not "
"""Before a label in the premise of a rule: one minus its grade."""
LEAST_WIDTH = 1e-9
"""Least width of a membership, as a fraction of the range: what is narrower has no area to speak of."""


@dataclass
class FuzzyVariable:
    """A quantity with named memberships.

    Raises:
        ValueError: the range is empty or not finite, there is no membership, or one does not reach
            grade 1 in the range (often a wrong unit) or is a mere point there.

    Attributes:
        name: such as `x`.
        unit: such as `m` or `rad`; empty: no unit.
        lower: lower end of the range; inputs below count as this.
        upper: upper end of the range; inputs above count as this.
        memberships: memberships by label; numbers in the unit of the variable.
        default: the output where no rule fires, inside the range; None: the middle. An input needs
            none.
    """

    name: str = ""
    unit: str = ""
    lower: float = nan
    upper: float = nan
    memberships: dict[str, Membership] = field(default_factory=dict)
    default: float | None = None

    def __post_init__(self) -> None:
        if self.name or self.memberships:  # else a blank that the YAML loader fills in
            self.validate()

    @classmethod
    def from_partition(
        cls, name: str, partition: TriangularPartition, *, unit: str = ""
    ) -> "FuzzyVariable":
        """A variable whose memberships are the triangles of a partition, which sum to one."""
        knots = partition.knots.tolist()
        corners = zip([knots[0], *knots], knots, [*knots[1:], knots[-1]])
        triangles: dict[str, Membership] = {
            label: Triangle(*abc) for label, abc in zip(partition.labels, corners)
        }
        return cls(name, unit, knots[0], knots[-1], triangles)

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels in the order of their cores, whatever their order in the file."""
        middles = {label: sum(shape.core) for label, shape in self.memberships.items()}
        return tuple(sorted(middles, key=lambda label: middles[label]))

    @property
    def axis(self) -> str:
        """Name and unit, such as `x [m]`."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    def grades(self, x: ArrayLike) -> Array:
        """Grades of all memberships, in the order of `labels`.

        Args:
            x: values, any shape (...); outside the range they count as its nearest end.

        Returns:
            Grades in [0, 1], shape (..., n); all NaN where x is NaN.
        """
        values = np.clip(np.asarray(x, dtype=float), self.lower, self.upper)
        stack = MembershipStack([self.memberships[label] for label in self.labels])
        return stack.grades(values.reshape(1, -1)).T.reshape(*values.shape, -1)

    def validate(self) -> None:
        """Raise ValueError, naming the bad value, unless this is a variable."""
        where = f"variable {self.name!r}"
        if not self.name:
            raise ValueError("a variable needs a name")
        self.lower = check_finite(f"{where}: lower", self.lower)
        self.upper = check_finite(f"{where}: upper", self.upper)
        if not self.lower < self.upper:
            raise ValueError(
                f"{where}: lower must be less than upper, got {self.lower} and {self.upper}"
            )
        if not self.memberships:
            raise ValueError(f"{where}: needs at least one membership")
        if self.default is not None:
            self.default = check_finite(f"{where}: default", self.default)
            if not self.lower <= self.default <= self.upper:
                raise ValueError(
                    f"{where}: default must be in [{self.lower}, {self.upper}], got {self.default}"
                )
        for label, shape in self.memberships.items():
            if not label or label.startswith(NOT):
                raise ValueError(f"{where}: a label must not be empty or begin with {NOT!r}")
            if not isinstance(shape, Membership):
                raise ValueError(
                    f"{where}: membership {label!r} must be a Triangle, Trapezoid or Gaussian, "
                    f"got {shape!r}"
                )
            try:
                shape.validate()
            except ValueError as error:
                raise ValueError(f"{where}, membership {label!r}: {error}") from error
            (start, end), (first, last) = shape.support, shape.core
            width = min(end, self.upper) - max(start, self.lower)
            tops = first <= self.upper and last >= self.lower
            if not tops or width < LEAST_WIDTH * (self.upper - self.lower):
                raise ValueError(
                    f"{where}: membership {label!r} must reach grade 1 in the range "
                    f"[{self.lower}, {self.upper}], and not be a point there, got {shape}"
                )
