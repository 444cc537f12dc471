"""A rule base dθ(dr, J) together with the account of how it was generated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition


@dataclass(frozen=True)
class Split:
    """A membership that the generator added (figure 5 of Xu and Nechyba, 1993).

    Attributes:
        epoch: number of sweeps over the data made before it.
        input: "dr" or "J".
        knot: peak of the new membership in the positive half of the range [unit of the input]; its
            mirror image -knot is added with it.
        error_before: inference error of the last sweep before it [unit of the output].
    """

    epoch: int
    input: str
    knot: float
    error_before: float


class GeneratedRuleBase(RuleBase):
    """Rules for dθ ≈ dr / J over |dr| <= dr_max, |J| <= j_max (equation 4).

    The inputs are dr, one component of the task error [m or rad], and J, one element of the
    Jacobian [m/rad, or the matching ratio]; the output is dθ [rad or m].

    Attributes:
        method: "araki" or "least_squares".
        j_max: half the range of J.
        dr_max: half the range of dr.
        max_error: the error that was asked for [unit of dθ].
        error: the error that the method compared with max_error. For "araki" the in-sweep error of
            the last epoch, each vector taken just before its own update; for "least_squares" the
            same as table_error.
        table_error: mean absolute error of the finished rules over the whole table of equation 12.
        history: `error` after each epoch.
        splits: the memberships added, in order; empty for "least_squares".
    """

    def __init__(
        self,
        first: TriangularPartition,
        second: TriangularPartition,
        consequents: ArrayLike,
        *,
        method: str,
        max_error: float,
        error: float,
        table_error: float,
        history: Sequence[float] = (),
        splits: Sequence[Split] = (),
    ) -> None:
        """Makes the rule base; see the class for the arguments and RuleBase for the errors."""
        super().__init__(first, second, consequents, names=("dr", "J", "dtheta"))
        self.method = method
        self.max_error = max_error
        self.error = error
        self.table_error = table_error
        self.history = tuple(history)
        self.splits = tuple(splits)

    @property
    def dr_max(self) -> float:
        """Half the range of dr [unit of dr]."""
        return float(self.first.knots[-1])

    @property
    def j_max(self) -> float:
        """Half the range of J [unit of J]."""
        return float(self.second.knots[-1])

    @property
    def converged(self) -> bool:
        """Whether `error` is below `max_error`; if not, a bound of the method stopped it."""
        return self.error < self.max_error

    def scaled(self, first_factor: float = 1.0, output_factor: float = 1.0) -> GeneratedRuleBase:
        """Changes the range of dr and of dθ, as RuleBase.scaled does.

        All errors are scaled with the output. They remain errors with respect to dr / J only if
        both factors are equal; section 3 of the paper doubles both.

        Args:
            first_factor: factor of the range of dr; finite, positive.
            output_factor: factor of dθ; finite.

        Returns:
            A new rule base of the same kind.

        Raises:
            ValueError: a factor is not as described.
        """
        scale = abs(output_factor)
        return GeneratedRuleBase(
            *self._scaled_parts(first_factor, output_factor),
            method=self.method,
            max_error=scale * self.max_error,
            error=scale * self.error,
            table_error=scale * self.table_error,
            history=[scale * error for error in self.history],
            splits=[
                replace(
                    split,
                    knot=split.knot * (first_factor if split.input == "dr" else 1.0),
                    error_before=scale * split.error_before,
                )
                for split in self.splits
            ],
        )
