"""Fuzzy resolved motion rate control: (J, dr) to a joint step, joint by joint (Kim & Lee 1993)."""

from dataclasses import dataclass, field
from math import sqrt
from operator import mul

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts, check_number, check_positive_finite
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.kinematics.column_reach import column_reach
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.task import Task
from fikm_drake.laws.law import as_arrays
from fikm_drake.laws.rate_inference import INFERENCE, rate_rules, rule_texts
from fikm_drake.laws.rate_table import table_inference

LEAST = 1e-6
"""The longest universe is at least this [m for each rad]: a tool on the only axis does not spin."""
CHUNK = 2048
"""Cases that fit a core's cache."""


@dataclass
class FuzzyRateControl:
    """Fuzzy resolved motion rate control, a law `(J, dr) -> joint_step`.

    The joints are asked one after the other, from the base to the tool. Five rules (`rules`) say
    how far joint k goes for the error that the joints before it have left over (equations 13-15):

        dθ_k = gain · (D / L_k) · push of the rules for dr / D and J_k / L_k,    dr ← dr − J_k dθ_k.

    D is the universe of the error. L_k, that of the joint's column J_k, is the length the column
    can reach, `reach`, as we read the paper; or, without `reach`, the length it has at this posture.
    It is never below a fraction of the largest: a joint with a short lever moves the tool little
    and would have to turn far. `sweeps` go through the joints again with the same J. The fraction
    is `floor` in the last and rises by equal factors to 1 in the first (1, 1/2, 1/4 for three
    sweeps): first the joints share the motion much as the pseudo-inverse has them do, then those
    with short levers mend what is left.

    - `smooth` sums the rules over the rows of the task: dθ_k = gain · J_kᵀ dr / L_k², a Gauss-Seidel
      pass over Jᵀ J. No pass increases |dr − J dθ|, whatever J is. A longer error than D is shortened
      in its own direction; `reach` gives way to a column that is longer.
    - `paper` takes the largest over the rows (Zadeh's OR), as we read the paper: each row is cut at
      D, the step can go the wrong way, and the error dies away more slowly.

    Attributes:
        variant: `smooth` or `paper`.
        gain: of each joint's step, in (0, 2) [-]. More leaves less of the error, and the joints travel
            farther. None: 1.4 for `paper`; for `smooth` 1.3, but 1 for one sweep without `reach`.
        sweeps: passes over the joints in one step.
        reach: L_k of each joint (n,) [m for each rad or m]; `for_arm` knows those of an arm. None:
            the lengths of the columns at hand, for any arm.
        floor: least L_k as a fraction of the largest, in (0, 1] [-].
        error_range: D [m]; it should exceed the error of ordinary tracking.
        table_size: entries a side of a look-up table that replaces the inference of `smooth`, as the
            paper proposes; the nearest entry is taken, so errors below about D / table_size stay. 0: the
            rules themselves, which are cheaper here and exact. An odd number has a zero.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> law = fd.FuzzyRateControl(sweeps=3)
        >>> law(np.diag([1.0, 2.0]), np.array([0.01, 0.02])).round(3).tolist()
        [0.01, 0.01]
    """

    variant: str = "smooth"
    gain: float | None = None
    sweeps: int = 1
    reach: np.ndarray | None = field(default=None, compare=False)
    floor: float = 0.25
    error_range: float = 0.1
    table_size: int = 0

    def __post_init__(self) -> None:
        if self.variant not in INFERENCE:
            raise ValueError(f"variant must be one of {tuple(INFERENCE)}, got {self.variant!r}")
        check_counts(sweeps=self.sweeps)
        stable = "in (0, 2), beyond is not stable"
        check_number("gain", self.joint_gain, stable, lambda x: 0.0 < x < 2.0)
        check_number("floor", self.floor, "in (0, 1]", lambda x: 0.0 < x <= 1.0)
        check_positive_finite("error_range", self.error_range, "m")
        if self.reach is not None:
            self.reach = _checked_reach(self.reach)
        self._many, self._one = INFERENCE[self.variant]
        if self.table_size:
            if self.variant != "smooth":
                raise ValueError(f"table_size needs variant 'smooth', got {self.variant!r}")
            self._many, self._one = table_inference(self.table_size)
        self._gain = self.joint_gain
        self._shorten = self.variant == "smooth"
        self._floors: list[float] = np.geomspace(self.floor, 1.0, self.sweeps)[::-1].tolist()
        self._reaches: list[float] = [] if self.reach is None else self.reach.tolist()

    @property
    def joint_gain(self) -> float:
        """The gain of each joint's step [-]: `gain`, or what it is by default; the paper gives none."""
        if self.gain is not None:
            return self.gain
        exact = self.sweeps == 1 and self.reach is None
        return 1.4 if self.variant == "paper" else 1.0 if exact else 1.3

    @classmethod
    def for_arm(
        cls,
        arm: DhArm,
        variant: str = "smooth",
        *,
        task: str | Task = "position",
        gain: float | None = None,
        sweeps: int = 1,
        floor: float = 0.25,
        error_range: float = 0.1,
        table_size: int = 0,
    ) -> "FuzzyRateControl":
        """The law with the universes L_k of an arm, the lengths that its columns can reach.

        Args:
            arm: the arm.
            variant: `smooth` or `paper`.
            task: the rows that count, as of the controller.
            gain: as of the class.
            sweeps: as of the class.
            floor: as of the class.
            error_range: as of the class [m].
            table_size: as of the class.

        Raises:
            ValueError: a prismatic joint without limits makes a reach infinite, or as above.
        """
        task = task if isinstance(task, Task) else Task(task)
        reach = column_reach(arm.jacobian_range(), task)
        return cls(variant, gain, sweeps, reach, floor, error_range, table_size)

    @property
    def rules(self) -> RuleBase:
        """Table 1 as rules: dr / D and J / L_k to dθ L_k / (gain · D), all in [−1, 1]."""
        return rate_rules()

    @property
    def rule_texts(self) -> list[str]:
        """The five rules in words."""
        return rule_texts()

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step of one control cycle.

        Args:
            J: Jacobian (…,m,n).
            dr: task error (…,m) in the units of the rows of J.

        Returns:
            (…,n) [rad or m].

        Raises:
            ValueError: the shapes do not fit.
        """
        J, dr = as_arrays(J, dr)
        m, n = J.shape[-2:]
        if self.reach is not None and len(self.reach) != n:
            raise ValueError(f"J must have {len(self.reach)} columns, as reach has, got {n}")
        lead = np.broadcast_shapes(J.shape[:-2], dr.shape[:-1])
        J = np.broadcast_to(J, (*lead, m, n)).reshape(-1, m, n)
        dr = np.broadcast_to(dr, (*lead, m)).reshape(-1, m)
        steps = np.empty((len(J), n))
        for start in range(0, len(J), CHUNK):
            chunk = slice(start, start + CHUNK)
            # A structure of arrays: the cases along the last axis.
            columns = np.ascontiguousarray(J[chunk].transpose(2, 1, 0))
            steps[chunk] = self._passes(columns, dr[chunk].T.copy()).T
        return steps.reshape(*lead, n)

    def _passes(self, columns: Array, error: Array) -> Array:
        """Steps (n,N) for columns (n,m,N) and errors (m,N), which are overwritten by what is left."""
        D = self.error_range
        if self._shorten:
            error *= D / np.maximum(np.abs(error).max(axis=0), D)
        universes = np.sqrt(np.einsum("kij,kij->kj", columns, columns))
        if self.reach is not None:
            np.maximum(universes, self.reach[:, None], out=universes)
        largest = np.maximum(universes.max(axis=0), LEAST)
        steps = np.zeros(universes.shape)
        for floor in self._floors:
            inverses = 1.0 / np.maximum(universes, floor * largest)
            for column, inverse, total in zip(columns, inverses, steps):
                step = self._many(column, error, inverse, D)
                step *= self._gain
                total += step
                error -= column * step
        return steps

    def step(self, J: Array, dr: Array) -> Array:
        """As `law(J, dr)` for one J (m,n) and one dr (m,), for a control loop: nothing is checked."""
        columns, error = J.T.tolist(), dr.tolist()
        D, gain, infer = self.error_range, self._gain, self._one
        if self._shorten:
            size = max(map(abs, error))
            if size > D:
                error = [e * (D / size) for e in error]
        universes = [sqrt(sum(map(mul, column, column))) for column in columns]
        if self._reaches:
            universes = [max(u, reach) for u, reach in zip(universes, self._reaches, strict=True)]
        largest = max(LEAST, *universes)
        steps = [0.0] * len(columns)
        for floor in self._floors:
            least = floor * largest
            for k, column in enumerate(columns):
                step = gain * infer(column, error, 1.0 / max(universes[k], least), D)
                steps[k] += step
                error = [e - c * step for e, c in zip(error, column)]
        return np.array(steps)


def _checked_reach(values: ArrayLike) -> Array:
    reach = np.array(values, dtype=float)
    if reach.ndim != 1 or not reach.size:
        raise ValueError(f"reach must be one number a joint, got shape {reach.shape}")
    if not (np.isfinite(reach).all() and (reach >= 0).all()):
        raise ValueError(
            f"reach must be finite and not negative, got {reach.tolist()}; "
            "a prismatic joint needs limits"
        )
    reach.flags.writeable = False
    return reach
