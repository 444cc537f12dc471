"""The five rules of fuzzy resolved motion rate control (Kim & Lee 1993, section 2, Table 1).

A joint k and a row i of the task are described by a = dr_i / D, held to [−1, 1], and j = J_ik / L_k:
D is the universe of the error, L_k ≥ |J_k| that of the joint's column. With the memberships of
figure 4, as we read them,

    dr: N = max(−a, 0), Z = 1 − |a|, P = max(a, 0);    J: N = (1 − j) / 2, P = (1 + j) / 2,

and the product as AND, the rules push the joint towards P by N_J N_dr + P_J P_dr, towards N by
P_J N_dr + N_J P_dr, and towards Z by Z_dr. The first two differ by a · j. What is left open is how
the rows of the task are joined (the paper's OR):

- `paper`: the largest of the rows for each of P, N and Z (Zadeh's OR), then the mean of the peaks
  1, −1 and 0 weighted by them (height method). It can step the wrong way.
- `smooth`: the sum of the rows, Σ_i a_i j_i, which is J_kᵀ dr / (D L_k): a scalar product, so the step
  is never the wrong way, and it is continuous.

Each comes for arrays, (m,N) columns and errors of N cases, and for lists of m floats, the fast way
for one case. Results are dθ_k for a gain of 1 [rad or m]: the pushes times D / L_k. P and N of
`paper` are twice the grades, which saves the halves.
"""

from collections.abc import Callable, Sequence
from operator import mul

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

Many = Callable[[Array, Array, Array, float], Array]
One = Callable[[Sequence[float], Sequence[float], float, float], float]

PEAKS = {"N": -1.0, "Z": 0.0, "P": 1.0}
"""Where the memberships of dθ peak, as a fraction of its universe [-]."""
TABLE_1 = {("N", "N"): "P", ("N", "P"): "N", ("P", "N"): "N", ("P", "P"): "P"}
"""Rules 1 to 4: labels of J and of dr to that of dθ. Rule 5: if dr is Z, dθ is Z."""


def rate_rules() -> RuleBase:
    """Table 1 over dr / D and J / L, all universes [−1, 1]; one row's push is its output, a · j."""
    error = TriangularPartition([PEAKS[label] for label in "NZP"], labels="NZP")
    column = TriangularPartition([PEAKS[label] for label in "NP"], labels="NP")
    consequents = [[PEAKS[TABLE_1.get((J, dr), "Z")] for J in "NP"] for dr in "NZP"]
    return RuleBase(error, column, consequents, names=("dr", "J", "dθ"))


def rule_texts() -> list[str]:
    """The five rules as the paper reads them."""
    rules = [f"IF J is {J} AND dr is {dr} THEN dθ is {out}" for (J, dr), out in TABLE_1.items()]
    return [*rules, "IF dr is Z THEN dθ is Z"]


def smooth_many(column: Array, error: Array, inverse: Array, error_range: float) -> Array:
    """The sum of the rows, J_kᵀ dr / L_k²: columns and errors (m,N), 1 / L_k (N,) to dθ_k (N,)."""
    step = np.einsum("ij,ij->j", column, error)
    step *= inverse
    step *= inverse
    return step


def smooth_one(
    column: Sequence[float], error: Sequence[float], inverse: float, error_range: float
) -> float:
    """As `smooth_many`, for one case."""
    return sum(map(mul, column, error)) * inverse * inverse


def paper_many(column: Array, error: Array, inverse: Array, error_range: float) -> Array:
    """Zadeh's OR of the rows and the height method: as `smooth_many`."""
    a = np.clip(error / error_range, -1.0, 1.0)
    size, push = np.abs(a), a * (column * inverse)
    P, N, Z = (size + push).max(axis=0), (size - push).max(axis=0), 1.0 - size.min(axis=0)
    return error_range * inverse * (P - N) / (P + N + 2.0 * Z)


def paper_one(
    column: Sequence[float], error: Sequence[float], inverse: float, error_range: float
) -> float:
    """As `paper_many`, for one case."""
    P = N = Z = 0.0
    for c, e in zip(column, error):
        a = min(max(e / error_range, -1.0), 1.0)
        size, push = abs(a), a * c * inverse
        # The new one first, so that a column of NaN gives NaN.
        P, N, Z = max(size + push, P), max(size - push, N), max(1.0 - size, Z)
    return error_range * inverse * (P - N) / (P + N + 2.0 * Z)


INFERENCE: dict[str, tuple[Many, One]] = {
    "paper": (paper_many, paper_one),
    "smooth": (smooth_many, smooth_one),
}
"""Both forms of each variant."""
