"""Past paper 3: does a pass over the joints ever make the error longer?"""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl

CASES, SEED = 20_000, 0
SHAPES = ((2, 3), (3, 7), (6, 7), (6, 3))
"""Rows and columns of J; each has its share of the cases."""
GAINS = (0.1, 1.0, 1.5, 1.99)
ROUNDING = 1e-12
"""A relative growth that only rounding makes [-]."""


def descent() -> Section:
    """One pass of each variant on random Jacobians and errors, some of them beyond D."""
    cells = []
    for gain in GAINS:
        for universes, reach in (("of the posture", None), ("fixed, too small", 0.5)):
            count = longer("smooth", gain, reach)
            label = f"smooth, gain {gain:g}, universes {universes}: passes that make |dr| longer"
            cells.append(Cell(label, None, count, count == 0))
    count = longer("paper", 1.4, None)
    cells.append(Cell("paper, gain 1.4: passes that make |dr| longer", None, count))
    notes = [f"Of {CASES} random J and dr each, columns and errors of lengths over four decades."]
    return Section("descent", "passes that make the error longer", cells, notes)


def longer(variant: str, gain: float, reach: float | None) -> int:
    """How many of `CASES` random cases leave |dr − J dθ| longer than |dr|."""
    rng = np.random.default_rng(SEED)
    count = 0
    for m, n in SHAPES:
        J, dr = _cases(rng, CASES // len(SHAPES), m, n)
        law = FuzzyRateControl(variant, gain=gain, reach=None if reach is None else [reach] * n)
        left = dr - (J @ law(J, dr)[..., None])[..., 0]
        before, after = np.linalg.norm(dr, axis=1), np.linalg.norm(left, axis=1)
        count += int((after > (1.0 + ROUNDING) * before).sum())
    return count


def _cases(rng: np.random.Generator, count: int, m: int, n: int) -> tuple[Array, Array]:
    J = rng.normal(size=(count, m, n)) * 10.0 ** rng.uniform(-3.0, 1.0, (count, 1, n))
    return J, rng.normal(size=(count, m)) * 10.0 ** rng.uniform(-4.0, 0.0, (count, 1))
