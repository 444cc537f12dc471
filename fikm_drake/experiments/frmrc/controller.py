"""Past paper 3: the law in the main controller, on paper 1's line of the 7-joint arm."""

import dataclasses

from fikm_drake.experiments.frmrc.laws import FIXED, ONE, PAPER, RMRC, THREE, laws
from fikm_drake.experiments.report import Cell, Section
from fikm_drake.simulation.simulate import simulate
from fikm_drake.simulation.tracking_scenario import load_scenario
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig

SCENARIO = "table6_5s"


def controller() -> Section:
    """The same Diagram, the law swapped by one argument: arm7, the line of 93.5 cm in 5 s."""
    scenario = load_scenario(SCENARIO)
    plain = dataclasses.replace(scenario, config=FuzzyIkConfig.resolved_rate())
    found = laws(scenario.load_arm(), "position")
    cells = []
    for name in (PAPER, FIXED, ONE, THREE, RMRC):
        for title, run in (("gain 1, no filters", plain), ("paper 1's gain and filters", scenario)):
            m = simulate(run, law=found[name]).metrics()
            text = f"{100 * m.e_max:.3f} / {100 * m.e_mean:.3f} / {100 * m.e_ss:.4f}"
            claim = m.e_ss < 1e-5 if name in (ONE, THREE) and run is plain else None
            cells.append(Cell(f"{name}, {title}", None, text, claim))
    notes = [
        "Error after the step: max / mean / at the end [cm]; the last is claimed, below 0.001 cm.",
        "`FuzzyIkConfig.resolved_rate()` is the first of the two configs: a law that takes the whole",
        "error at once is only slowed by the gain and the filters of paper 1.",
    ]
    return Section("controller", "the 7-joint arm in the main controller", cells, notes)
