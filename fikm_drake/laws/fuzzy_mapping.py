"""The fuzzy inverse kinematic mapping: (J, dr) to a joint step (Xu & Nechyba 1993)."""

from dataclasses import dataclass, field, replace
from functools import cache
from math import hypot, inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_below_one, check_counts, check_not_negative
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.kinematics.native.kernel import kernel
from fikm_drake.kinematics.native.native_step import NativeStep
from fikm_drake.laws.conjugate_gradients import conjugate_gradients, conjugate_gradients_of_one
from fikm_drake.laws.law import as_arrays
from fikm_drake.laws.normal_equations import (
    LARGEST_GROWTH,
    normal_equations,
    normal_equations_of_one,
)
from fikm_drake.laws.rule_generation.generate import generate_rule_base

METHODS = ("indirect", "direct")

MOST_ERROR_DAMPING = 1.0
"""What an error adds to the damping at the most [-]: the norm of S is at most 1, so more would only slow the
arm."""


@dataclass
class FuzzyMapping:
    """The fuzzy inverse kinematic mapping, a pure law `mapping(J, dr) -> joint_step`.

    With row sums r_i = Σ_j |J_ij| and column sums c_j = Σ_i |J_ij| (equations 27, 28):

    - `indirect` (equations 32-34): dθ_j = (1/c_j) Σ_i J_ij dr_i / r_i,
      in matrices C⁻¹ Jᵀ R⁻¹ dr;
    - `direct` (equation 29): dθ_j = (1/c_j) Σ_i J_ij² dθ_ij / r_i, where dθ_ij comes from a generated
      rule base over (dr_i, J_ij). Rule bases are generated once for each distinct range of J_ij;
      dr_i is held to their universe.

    Rows and columns whose sum is below `zero_threshold` of the largest give no motion. The paper's
    exact test for zero fails in floating point: a column of rounding errors would be divided by
    its own size.

    Past the paper, for `indirect`: it is the first of the steps that solve dr = J dθ on the scaled
    Jacobian S = R^-½ J C^-½, whose norm is at most 1. `iterations` of conjugate gradients on S go
    further with the same J: as many as J has rows reach the pseudo-inverse weighted by R and C, and
    are replaced by one direct solve of the same minimum wherever it is well conditioned.
    `damping` is of S, so it has no unit. `row_floor` and `column_floor` raise the sums smoothly,
    r_i to √(r_i² + (row_floor · max r)²): a direction in which the arm hardly moves is then pushed
    in proportion, not by the sign of what is left of it, and the law is continuous at c_j = 0.

    `error_damping` κ adds to the damping where the error is long (Levenberg-Marquardt):
    λ² = damping² + min(κ |R⁻¹ dr|, 1)², where dr_i / r_i is the turn that takes away the error of row i
    alone, so that neither unit nor arm's size is in it. Near the target it is nothing; before a target out
    of reach the direction in which the arm can't follow is damped, and the arm does not flail. With it a
    small `damping` is enough, and before a target near a singular posture the arm does not creep.
    `iterated()` is the law for poses and for tracking that the project recommends.

    Attributes:
        method: `indirect` or `direct`.
        iterations: of conjugate gradients; 1 is the paper's law.
        damping: of S [-], with `iterations` of 2 or more.
        error_damping: κ [1/rad], with `iterations` of 2 or more; more is calmer out of reach and slower on
            the way.
        row_floor: fraction of the largest row sum [-]; 0 as in the paper.
        column_floor: fraction of the largest column sum [-]; 0 as in the paper.
        zero_threshold: sums at or below this fraction of the largest row or column sum are zero [-].
        jacobian_range: bounds of |J_ij| for `direct`, a number or (m,n), such as
            `arm.jacobian_range()[rows]`; None: that of the controller's arm and task, or alone that
            of Table II, 1.5.
        dr_max: universe of dr for `direct`, ±dr_max [m] (equation 13).
        max_error: mean inference error at which rule generation stops [rad] (section 2.5).
        generation: method of `generate_rule_base`, `least_squares` or `araki`.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> J = np.array([[-0.5, -0.2], [1.2, 0.4]])
        >>> fd.FuzzyMapping()(J, np.array([0.0, 0.01])).round(4).tolist()
        [0.0044, 0.0042]
    """

    method: str = "indirect"
    iterations: int = 1
    damping: float = 0.0
    error_damping: float = 0.0
    row_floor: float = 0.0
    column_floor: float = 0.0
    zero_threshold: float = 1e-9
    jacobian_range: np.ndarray | None = field(default=None, compare=False)
    dr_max: float = 0.1
    max_error: float = 0.0013
    generation: str = "least_squares"

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method must be one of {METHODS}, got {self.method!r}")
        check_counts(iterations=self.iterations)
        check_below_one("zero_threshold", self.zero_threshold)
        for name in ("damping", "error_damping", "row_floor", "column_floor"):
            check_not_negative(name, getattr(self, name))
        floors = bool(self.row_floor or self.column_floor)
        for name in ("damping", "error_damping"):
            if getattr(self, name) and self.iterations < 2:
                raise ValueError(f"{name} needs iterations of 2 or more: the paper's law has none")
        if self.method == "direct" and (self.iterations > 1 or floors):
            raise ValueError("iterations and floors are of method 'indirect', not of 'direct'")
        self._plain = self.iterations == 1 and not floors
        if self.method == "indirect":
            return
        self._range = np.array(1.5 if self.jacobian_range is None else self.jacobian_range, float)
        if not (np.isfinite(self._range).all() and (self._range >= 0).all()):
            raise ValueError(
                f"jacobian_range must be finite and not negative, got {self._range.tolist()}; "
                "a prismatic joint needs limits"
            )
        # Ranges that differ by rounding only are one; a range of zero needs no rules.
        self._rounded = np.round(self._range, 9)
        self._rules = {
            j_max: generate_rule_base(
                j_max, method=self.generation, max_error=self.max_error, dr_max=self.dr_max
            )
            for j_max in np.unique(self._rounded[self._rounded > 0]).tolist()
        }

    @classmethod
    def iterated(cls) -> "FuzzyMapping":
        """The recommended law for poses and for tracking: no direction is slow, and it is calm out of reach.

        Example:
            >>> import fikm_drake as fd
            >>> fd.FuzzyMapping.iterated().iterations
            6
        """
        return cls(iterations=6, damping=0.02, error_damping=3.0, row_floor=0.05)

    @property
    def rule_bases(self) -> dict[float, RuleBase]:
        """The generated rule bases of `direct` by the range of J_ij; empty for `indirect`."""
        return dict(self._rules) if self.method == "direct" else {}

    @property
    def takes_damping(self) -> bool:
        """Whether `step` makes use of a damping."""
        return self.method == "indirect"

    def __call__(self, J: ArrayLike, dr: ArrayLike, damping: float = 0.0) -> Array:
        """The joint step of one control cycle.

        Args:
            J: Jacobian (…,m,n).
            dr: task error (…,m) in the units of the rows of J.
            damping: more damping of S, such as the supervisor's; with one iteration, which has none,
                it is a floor of the row sums, and `direct` does without [-].

        Returns:
            (…,n) [rad or m].

        Raises:
            ValueError: the shapes do not fit, or |J_ij| exceeds the range of `direct`.
        """
        J, dr = as_arrays(J, dr)
        A = np.abs(J)
        floor = hypot(self.row_floor, damping) if self.iterations == 1 else self.row_floor
        rows = self._reciprocal(A.sum(-1), floor)
        columns = self._reciprocal(A.sum(-2), self.column_floor)
        if self.method == "direct":
            pushes = rows[..., None, :] @ (A * A * self._infer(dr, J))
            return columns * pushes[..., 0, :]
        if self.iterations == 1:
            return columns * ((rows * dr)[..., None, :] @ J)[..., 0, :]
        damped = np.hypot(self._error_damping(dr, rows), hypot(self.damping, damping))
        solved = None
        if self.iterations >= J.shape[-2]:
            solved = normal_equations(J, dr, rows, columns, damped)
            if solved is not None and solved[1].all():
                return solved[0]
        rows, columns = np.sqrt(rows), np.sqrt(columns)
        S = rows[..., :, None] * J * columns[..., None, :]
        step = columns * conjugate_gradients(S, rows * dr, self.iterations, damped[..., None])
        return step if solved is None else np.where(solved[1][..., None], solved[0], step)

    def step(self, J: Array, dr: Array, damping: float = 0.0) -> Array:
        """The same for one J (m,n) and one dr (m,), for a control loop: nothing is checked."""
        if self.method == "direct":
            ranges = self._ranges(J.shape)  # of limits that measured joints may be past
            return self(np.minimum(np.maximum(J, -ranges), ranges), dr)
        native = _native_step()
        solve = self.iterations >= len(J) and self.iterations > 1
        if native and (solve or self.iterations == 1):
            step = native(
                J,
                dr,
                self.row_floor,
                self.column_floor,
                self.zero_threshold,
                self.damping,
                self.error_damping,
                damping,
                LARGEST_GROWTH if solve else 0.0,
            )
            if step is not None:
                return step
        A = np.abs(J)
        m, n = A.shape
        rows, columns = A.dot(_ones(n)), _ones(m).dot(A)
        if self._plain and not damping:
            sums = rows.tolist() + columns.tolist()
            if min(sums) > self.zero_threshold * max(sums):  # no sum is zero
                return (dr / rows).dot(J) / columns
        floor = hypot(self.row_floor, damping) if self.iterations == 1 else self.row_floor
        rows = self._divisors(rows, floor)
        columns = self._divisors(columns, self.column_floor)
        if self.iterations == 1:
            return (dr / rows).dot(J) / columns
        damping = hypot(self.damping, damping)
        if self.error_damping:
            damping = hypot(damping, self.added_damping(dr / rows))
        if self.iterations >= m:
            solved = normal_equations_of_one(J, dr, rows, columns, damping)
            if solved is not None:
                return solved
        rows, columns = np.sqrt(rows), np.sqrt(columns)
        S = J / (rows[:, None] * columns)
        return conjugate_gradients_of_one(S, dr / rows, self.iterations, damping) / columns

    def added_damping(self, turns: Array) -> float:
        """What an error adds to the damping of S, by its turns dr_i / r_i (m,) [rad]; [-]."""
        return min(self.error_damping * sqrt(turns.dot(turns)), MOST_ERROR_DAMPING)

    def _error_damping(self, dr: Array, rows: Array) -> Array | float:
        """The same of errors (…,m), (…,); `rows` are 1 / r_i."""
        if not self.error_damping:
            return 0.0
        with np.errstate(over="ignore"):
            turn = self.error_damping * np.linalg.norm(dr * rows, axis=-1)
        return np.minimum(turn, MOST_ERROR_DAMPING)

    def _divisors(self, sums: Array, floor: float) -> Array:
        """The sums (k,) raised by the floor, infinite for those that are zero."""
        values = sums.tolist()
        largest = max(values)
        zero = self.zero_threshold * largest
        if floor and largest:
            sums = np.hypot(sums, floor * largest)
        elif min(values) <= zero:
            sums[sums <= zero] = inf
        return sums

    def _reciprocal(self, sums: Array, floor: float) -> Array:
        """1 / the sums (…,k), raised by the floor; 0 for those that are zero."""
        largest = sums.max(axis=-1, keepdims=True)
        if floor:
            sums = np.hypot(sums, floor * largest)
        zero = self.zero_threshold * largest
        return np.divide(1.0, sums, out=np.zeros_like(sums), where=sums > zero)

    def _infer(self, dr: Array, J: Array) -> Array:
        """dθ_ij (…,m,n) of the rule bases (equation 19); zero where the range is zero."""
        ranges = self._ranges(J.shape[-2:])
        if (np.abs(J) > ranges * (1 + 1e-9) + 1e-9).any():
            raise ValueError(
                f"|J| reaches {np.abs(J).max():.4g}, beyond jacobian_range {self._range.tolist()}"
            )
        dr = np.broadcast_to(dr[..., None], np.broadcast_shapes(dr.shape + (1,), J.shape))
        dtheta = np.zeros(dr.shape)
        J = np.broadcast_to(J, dr.shape)
        for j_max, rules in self._rules.items():
            chosen = ranges == j_max
            dtheta[..., chosen] = rules(dr[..., chosen], J[..., chosen])
        return dtheta

    def _ranges(self, shape: tuple[int, ...]) -> Array:
        """The ranges of |J_ij| (m,n); ValueError if they are another arm's."""
        try:
            return np.broadcast_to(self._rounded, shape)
        except ValueError:
            raise ValueError(
                f"jacobian_range has shape {self._rounded.shape}, J has rows and columns {shape}"
            ) from None


_ones = cache(np.ones)


_made = cache(NativeStep)


def _native_step() -> NativeStep | None:
    loaded = kernel()
    return _made(loaded) if loaded else None


def fit_to_range(law: Any, task: Any) -> Any:
    """A `direct` mapping whose range was left open, with rules for that of a task; else the law.

    Args:
        law: any law.
        task: has `jacobian_range()`, bounds of |J_ij| (m,n).

    Raises:
        ValueError: the task knows no bounds of its Jacobian.
    """
    if (
        not isinstance(law, FuzzyMapping)
        or law.method != "direct"
        or law.jacobian_range is not None
    ):
        return law
    if not hasattr(task, "jacobian_range"):
        raise ValueError(
            f"method 'direct' needs jacobian_range: {type(task).__name__} knows no bounds of its J"
        )
    return replace(law, jacobian_range=task.jacobian_range())
