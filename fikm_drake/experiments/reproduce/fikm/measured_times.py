"""Paper 1, section 5.2: what a law costs in numpy today."""

from collections.abc import Callable
from statistics import median

import numpy as np

from fikm_drake.experiments.benchmarks.interleaved import interleaved
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

DAMPING = 0.05
ROUNDS, CALLS = 40, 200


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


def _laws(J: np.ndarray, dr: np.ndarray) -> dict[str, Callable[[], np.ndarray]]:
    step = FuzzyMapping().step
    damping = DAMPING**2 * np.eye(len(J))
    return {
        "fuzzy mapping": lambda: step(J, dr),
        "damped least squares": lambda: J.T @ np.linalg.solve(J @ J.T + damping, dr),
        "pseudo-inverse": lambda: np.linalg.pinv(J) @ dr,
    }
