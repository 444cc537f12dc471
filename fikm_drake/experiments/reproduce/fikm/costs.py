"""Paper 1, section 5.2: operations of a cycle (Table VII), and what a law costs in numpy today."""

from collections.abc import Callable
from dataclasses import astuple, dataclass, replace
from functools import partial
from statistics import median

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.experiments.benchmarks.interleaved import interleaved
from fikm_drake.experiments.reproduce.conventions import both
from fikm_drake.experiments.reproduce.report import Cell, Section, equal
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_mapping import METHODS, FuzzyMapping
from fikm_drake.simulation.scenario import load_scenario
from fikm_drake.simulation.simulate import simulate

TABLE_7 = {
    "P560, closed form": (53, 26, 10, 8, 2, 176),
    "P560, fuzzy": (93, 64, 6, 0, 0, 144),
    "7 joints, pseudo-inverse": (498, 362, 12, 0, 0, 679),
    "7 joints, fuzzy": (246, 173, 12, 0, 0, 364),
    "8 joints, pseudo-inverse": (561, 410, 14, 0, 0, 768),
    "8 joints, fuzzy": (289, 204, 14, 0, 0, 427),
}
COUNTED = ("P560, fuzzy", "7 joints, fuzzy", "8 joints, fuzzy")
"""Rows whose mapping is counted from the arm; all of the others is typed from the literature."""
MANY = 10_000
"""So many joints that only the limit of a ratio is left."""
COLUMNS = ("mult./div.", "add./sub.", "sin/cos", "inverse f.", "sqrt", "units")


@dataclass(frozen=True)
class OperationCount:
    """Arithmetic operations and what they cost in the paper's units (equation 55)."""

    multiplications: int = 0
    additions: int = 0
    sines: int = 0
    inverse_functions: int = 0
    square_roots: int = 0

    def __add__(self, other: "OperationCount") -> "OperationCount":
        return OperationCount(*(a + b for a, b in zip(astuple(self), astuple(other))))

    @property
    def units(self) -> float:
        """Units of computing power."""
        return (
            self.multiplications
            + self.additions / 3
            + 5 * self.sines
            + 7 * self.inverse_functions
            + 4 * self.square_roots
        )


def mapping_count(pattern: Bools, unit_columns: int = 0) -> OperationCount:
    """Operations of equations 27, 28 and 32-34 for a Jacobian with this pattern of non-zeros.

    Each element that is not zero is multiplied by dr_i and divided by r_i, and enters three sums;
    each column is divided by c_j, but those whose only element is 1.

    Args:
        pattern: (m,n), True where an element can differ from zero.
        unit_columns: how many columns are a single 1.
    """
    m, n = pattern.shape
    elements = int(pattern.sum())
    return OperationCount(
        multiplications=2 * elements + n - unit_columns,
        additions=(elements - m) + 2 * (elements - n),
    )


def general_jacobian_count(n: int) -> OperationCount:
    """The Jacobian of a general arm with twists of 0 and ±90° (section 5.2, after Orin, Schrader)."""
    return OperationCount(30 * n - 55, 15 * n - 38, 2 * n - 2)


def pseudo_inverse_count(n: int) -> OperationCount:
    """The pseudo-inverse solution after the Jacobian (equation 56, after Nakamura)."""
    return OperationCount(33 * n + 112, 33 * n + 64)


def puma_pattern(arm: DhArm) -> tuple[Bools, int]:
    """Pattern (6,6) of the Puma's Jacobian as in equation 51, found from the arm, and its unit columns.

    At the wrist point and in the last link's frame, by (θ1, θ2, θ2 + θ3, θ4, θ5, θ6): with θ2 + θ3
    held, joint 3 turns against joint 2, whose axis is parallel.
    """
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (50, arm.num_joints))
    J = arm.jacobian(q)
    J[..., 1] -= J[..., 2]
    R = np.swapaxes(arm.forward_kinematics(q)[:, :3, :3], -1, -2)
    J = np.concatenate([R @ J[:, 3:], R @ J[:, :3]], axis=1)  # rows [v; ω], as the paper has them
    pattern = np.asarray((np.abs(J) > 1e-9).any(axis=0))
    single = pattern.sum(axis=0) == 1
    unit = np.isclose(np.abs(J).sum(axis=1), 1.0).all(axis=0)
    return pattern, int((single & unit).sum())


def counts() -> dict[str, OperationCount]:
    """Table VII, row by row."""
    pattern, unit_columns = puma_pattern(load_arm("puma560"))
    # Equations 47 and 49 (closed form after Paul and Zhang, with the rotation matrix) and 52.
    closed_form = OperationCount(37, 22, 4, 6 + 2, 2) + OperationCount(16, 4, 6)
    puma_jacobian = OperationCount(46, 19, 6)
    rows = {
        "P560, closed form": closed_form,
        "P560, fuzzy": puma_jacobian + mapping_count(pattern, unit_columns),
    }
    for n in (7, 8):
        jacobian = general_jacobian_count(n)
        general = np.ones((6, n), dtype=bool)
        rows[f"{n} joints, pseudo-inverse"] = jacobian + pseudo_inverse_count(n)
        rows[f"{n} joints, fuzzy"] = jacobian + mapping_count(general)
    return rows


def table_7() -> Section:
    """Table VII: operations of a cycle, counted."""
    cells = []
    for name, count in counts().items():
        ours = (*astuple(count), round(count.units))
        cells += [
            equal(f"{name}: {column}", paper, mine)
            if name in COUNTED
            else Cell(f"{name}: {column} (typed)", paper, mine)
            for column, paper, mine in zip(COLUMNS, TABLE_7[name], ours)
        ]
    return Section("table 7", "operations of a cycle", cells, notes=_notes())


def saving(n: int) -> tuple[float, float]:
    """Pseudo-inverse over fuzzy for n joints and 6 rows: the law alone, the whole cycle [-]."""
    jacobian, pseudo = general_jacobian_count(n), pseudo_inverse_count(n)
    fuzzy = mapping_count(np.ones((6, n), dtype=bool))
    return pseudo.units / fuzzy.units, (jacobian + pseudo).units / (jacobian + fuzzy).units


def _notes() -> list[str]:
    law, cycle = saving(7)
    limit, _ = saving(MANY)
    return [
        f"Pseudo-inverse over fuzzy, 7 joints: the law alone {law:.2f}, the whole cycle {cycle:.2f}; the",
        f"paper's 'two and a half times' is the law alone as n grows: {limit:.2f}.",
        "Cells marked (typed) are formulas of the literature that the paper cites, for the Jacobian and the",
        "other methods, and claim nothing; the Puma's zeros and the mapping's operations are counted here",
        "from the arm.",
    ]


def saving_cells() -> list[Cell]:
    """The '2.5 times' of section 5.2 as cells."""
    law, cycle = saving(7)
    return [
        Cell("pseudo-inverse over fuzzy, the law alone, n → ∞", 2.5, saving(MANY)[0]),
        Cell("the same for 7 joints", None, law),
        Cell("the whole cycle with its Jacobian, 7 joints", None, cycle),
    ]


DAMPING = 0.05
ROUNDS, CALLS = 40, 200
APART = 0.01
"""The most that direct and indirect are claimed to differ by [cm]."""


def times() -> Section:
    """The law alone in numpy beside damped least squares and the pseudo-inverse; nothing is claimed."""
    arm = load_arm("arm7")
    J6 = arm.jacobian(np.linspace(0.1, 0.7, 7))
    cells = []
    for rows, J in (("3 rows", np.ascontiguousarray(J6[3:])), ("6 rows", J6)):
        costs = interleaved(_laws(J, np.full(len(J), 0.01)), rounds=ROUNDS, repeats=CALLS)
        fuzzy = costs["fuzzy mapping"]
        for name, cost in costs.items():
            ratio = median(c / f for c, f in zip(cost, fuzzy))
            text = f"{1e6 * median(cost):.1f} µs, {ratio:.1f} times the fuzzy mapping"
            cells.append(Cell(f"{rows}, {name}", None, text))
    notes = [f"CPU time of a call, median of {ROUNDS} interleaved rounds, 7 joints."]
    return Section("times", "measured cost of the law alone", cells, notes)


def direct() -> Section:
    """Sections 4.1 and 4.2: the mapping by rule bases, direct, and without them, indirect."""
    cells = []
    for seconds in (10, 5, 2):
        scenario = load_scenario(f"table6_{seconds}s")
        errors = {}
        for method in METHODS:
            config = replace(scenario.controller_config(), law=FuzzyMapping(method))
            errors[method] = both(simulate(scenario.with_config(config)))
        for quantity in ("e_max", "e_mean"):
            for method, found in errors.items():
                after, before = (100 * float(getattr(e, quantity)) for e in found)
                label = f"line in {seconds} s, {method}: {quantity} [cm]"
                cells.append(Cell(label, None, after, before=before))
        apart = 100 * abs(errors["direct"][0].e_mean - errors["indirect"][0].e_mean)
        label = f"line in {seconds} s: e_mean of the two apart by [cm], at most {APART:g}"
        cells.append(Cell(label, "nearly none", apart, apart <= APART))
    arm = load_arm("arm7")
    J, dr = np.ascontiguousarray(arm.jacobian(np.linspace(0.1, 0.7, 7))[3:]), np.full(3, 0.01)
    laws = (FuzzyMapping(), FuzzyMapping("direct", jacobian_range=arm.jacobian_range()[3:]))
    calls: dict[str, Callable[[], Array]] = {law.method: partial(law.step, J, dr) for law in laws}
    costs = interleaved(calls, rounds=ROUNDS, repeats=CALLS // 10)
    for name, cost in costs.items():
        cells.append(Cell(f"{name}: CPU time of a call in numpy [µs]", None, 1e6 * median(cost)))
    ratio = median(d / i for d, i in zip(costs["direct"], costs["indirect"]))
    cells.append(Cell("direct over indirect, CPU time [-]", "about 3", ratio))
    indirect = mapping_count(np.ones(J.shape, dtype=bool)).units
    operations = direct_count(*J.shape).units / indirect
    cells.append(Cell("direct over indirect, units of operations [-]", "about 3", operations))
    notes = [
        "Indirect: a little less error, as the paper says. The direct form looks each of the 21 dθ_ij up in",
        "a rule base, where two labels of dr and two of J are not zero. Counted in the paper's units (its",
        "footnote of Table VII), search left out, that is a few times as much; in numpy, where every small",
        "step costs a call, far more.",
    ]
    return Section("direct", "rule bases against the indirect form", cells, notes)


def direct_count(m: int, n: int) -> OperationCount:
    """Operations of the direct form (equations 17, 18 and 29), the search for the cells left out.

    Each dθ_ij takes two grades (a subtraction and a division each) and their complements, four products
    of grades, four with consequents and three sums; then J², its product with dθ_ij and a division by r_i.
    """
    element = OperationCount(2 + 4 + 4 + 3, 2 * 2 + 3)
    sums = OperationCount(n, (m * n - m) + 2 * (m * n - n))
    return OperationCount(m * n * element.multiplications, m * n * element.additions) + sums


def _laws(J: np.ndarray, dr: np.ndarray) -> dict[str, Callable[[], np.ndarray]]:
    step = FuzzyMapping().step
    damping = DAMPING**2 * np.eye(len(J))
    return {
        "fuzzy mapping": lambda: step(J, dr),
        "damped least squares": lambda: J.T @ np.linalg.solve(J @ J.T + damping, dr),
        "pseudo-inverse": lambda: np.linalg.pinv(J) @ dr,
    }
