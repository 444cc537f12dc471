"""Paper 3, section 4: the inference from a look-up table, what it costs and what it loses."""

from functools import partial
from statistics import median

import numpy as np

from fikm_drake.experiments.benchmarks.interleaved import interleaved
from fikm_drake.experiments.reproduce.conventions import both
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.rate_table import rate_table
from fikm_drake.simulation.scenario.load import load_scenario
from fikm_drake.simulation.simulate import simulate

SIZES = (17, 65, 257, 1025)
"""Entries a side."""
ROUNDS, CALLS = 30, 200
HOLD = 50
"""Cycles after the end."""


def look_up_table() -> Section:
    """The line of figure 6 and the cost of a step, by the rules and by tables of several sizes."""
    scenario = load_scenario("frmrc_line")
    scenario = scenario.but(target__hold=HOLD / scenario.control_rate)
    laws = {"rules": FuzzyRateControl()}
    laws |= {f"table {size} x {size}": FuzzyRateControl(table_size=size) for size in SIZES}
    cells = []
    for name, law in laws.items():
        after, before = both(simulate(scenario, law=law))
        cells.append(
            Cell(f"{name}: max error [mm]", None, 1e3 * after.e_max, before=1e3 * before.e_max)
        )
        dead = 2e3 * law.error_range / (law.table_size - 1) if law.table_size else 0.0
        rest = 1e3 * after.e_ss
        label = f"{name}: error that stays [mm], at most {dead:.3g}"
        cells.append(Cell(label, "0", rest, rest <= dead + 1e-6))
    arm = load_arm("kim_lee3r")
    J, dr = arm.jacobian([0.4, 0.7, -0.5])[3:5], np.array([0.01, -0.02])
    costs = interleaved(
        {name: partial(law.step, J, dr) for name, law in laws.items()}, rounds=ROUNDS, repeats=CALLS
    )
    for name, cost in costs.items():
        ratio = median(c / rules for c, rules in zip(cost, costs["rules"]))
        text = f"{1e6 * median(cost):.2f} µs, {ratio:.2f} times the rules"
        cells.append(Cell(f"{name}: CPU time of a step", None, text))
    off = [
        float(np.abs(rate_table(s) - np.outer(*[np.linspace(-1, 1, s)] * 2)).max()) for s in SIZES
    ]
    cells.append(Cell("table entries off the product a · j, at most [-]", None, max(off)))
    notes = [
        "The nearest entry, as a small computer takes it: D = 0.1 m over the table is a dead band, in which",
        "the arm rests off its goal, so zero error at the goal takes a fine table. With bilinear",
        "interpolation the rules are themselves a table of 3 x 2 and exact. Nothing is gained in Python: the",
        "rules of all rows are one scalar product, a look-up is two roundings more.",
    ]
    return Section("look-up table", "rules from a look-up table", cells, notes)
