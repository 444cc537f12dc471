"""Past paper 3: the law in the main controller, out of reach, and whether a pass makes an error longer."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.experiments.reproduce.conventions import error_texts
from fikm_drake.experiments.reproduce.fikm.ablation import LAST, OPTIMUM, UNREACHABLE
from fikm_drake.experiments.reproduce.frmrc.laws import ONE, PAPER, RMRC, THREE, laws
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.simulation.scenario import load_scenario
from fikm_drake.simulation.simulate import simulate

LINE = "table6_5s"


def controller() -> Section:
    """The same Diagram, the law swapped by one argument: arm7, the line of 93.5 cm in 5 s."""
    scenario = load_scenario(LINE)
    plain = scenario.with_config(FuzzyIkConfig().resolved_rate())
    found = laws(scenario.load_arm(), "position")
    cells = []
    for name, law in found.items():
        for title, run in (("gain 1, no filters", plain), ("paper 1's gain and filters", scenario)):
            log = simulate(run, law=law)
            after, before = error_texts(log)
            claim = log.metrics().e_ss < 1e-5 if name in (ONE, THREE) and run is plain else None
            cells.append(Cell(f"{name}, {title}", None, after, claim, before=before))
    notes = [
        "Error: max / mean / at the end [cm]; the last is claimed after the step, below 0.001 cm.",
        "The first of the two configs is `FuzzyIkConfig().resolved_rate()`. A law that takes the whole",
        "error at once is only slowed by the gain and the filters of paper 1; one that takes little of it",
        "gains by them.",
    ]
    return Section("controller", "the 7-joint arm in the main controller", cells, notes)


def out_of_reach() -> Section:
    """A target half a metre out of reach of the stretched 4-joint arm: does the arm come to rest?"""
    scenario = load_scenario(UNREACHABLE)
    plain = scenario.with_config(FuzzyIkConfig().resolved_rate())
    found = laws(scenario.load_arm(), "xy") | {"damped least squares": DampedLeastSquares()}
    cells = []
    for name, law in found.items():
        log = simulate(plain, law=law)
        beyond = 1000 * (log.metrics().e_ss - OPTIMUM)
        motion = float(np.abs(log.cycles.joint_step[-LAST:]).max())
        smooth = name not in (PAPER, RMRC, "damped least squares")
        claim = bool(abs(beyond) < 1e-3 and motion < 1e-6) if smooth else None
        cells.append(Cell(name, None, f"{beyond:.3g} / {motion:.2g}", claim))
    notes = [
        "Error over the optimum [mm] / largest joint step of the last second [rad], gain 1, no filters;",
        "claimed below 0.001 and 0.000001. A pass that never makes the error longer has nowhere to go",
        "where Jᵀ dr = 0; the pseudo-inverse and damped least squares overshoot there for ever.",
    ]
    return Section("out of reach", "a target 0.5 m out of reach, 9 s", cells, notes)


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
        law = FuzzyRateControl(
            variant, gain=gain, reach=None if reach is None else np.full(n, reach)
        )
        left = dr - (J @ law(J, dr)[..., None])[..., 0]
        before, after = np.linalg.norm(dr, axis=1), np.linalg.norm(left, axis=1)
        count += int((after > (1.0 + ROUNDING) * before).sum())
    return count


def _cases(rng: np.random.Generator, count: int, m: int, n: int) -> tuple[Array, Array]:
    J = rng.normal(size=(count, m, n)) * 10.0 ** rng.uniform(-3.0, 1.0, (count, 1, n))
    return J, rng.normal(size=(count, m)) * 10.0 ** rng.uniform(-4.0, 0.0, (count, 1))
