"""Paper 1: what it leaves open of its controller, how each may be read, and what each reading gives."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.fikm import paths
from fikm_drake.experiments.reproduce.fikm.rollout import AVERAGES, UNKNOWN, Reading, rollout
from fikm_drake.experiments.reproduce.fikm.tracking import TABLE_6
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.simulation.scenario import Scenario, load_scenario

READINGS: dict[str, Reading] = {
    "ours": Reading(),
    "figure 6: S M B at 0, .5, 1 of the average (big: above it)": Reading(
        breakpoints=(0.0, 0.5, 1.0)
    ),
    "figure 6: S M B at .5, 1, 1.5": Reading(breakpoints=(0.5, 1.0, 1.5)),
    "figure 6: S M B at 0, 1, 4": Reading(breakpoints=(0.0, 1.0, 4.0)),
    "average: of the ten before": Reading(average=AVERAGES[1]),
    "before ten are known: average of those": Reading(unknown=UNKNOWN[1]),
    "an average and a gain for each dr_i": Reading(by_rows=True),
    "K_applied at first 0": Reading(initial_gain=0.0),
    "K_applied at first 2.6": Reading(initial_gain=2.6),
    "dr at first the first error itself": Reading(first_error="first"),
}
"""Each changes one thing against ours."""


@dataclass(frozen=True)
class Wanted:
    """A path and what the paper has of it."""

    key: str
    scenario: Scenario
    e_max: float
    """[cm]"""
    e_mean: float
    """[cm]"""

    def targets(self) -> Array:
        """One a cycle (T,1,m) [m]."""
        return self.scenario.targets()[:, None, :]


def wanted() -> list[Wanted]:
    """Table VI's lines and the curves of our choice."""
    lines = [
        Wanted(f"line, {t} s", load_scenario(f"table6_{t}s"), *TABLE_6[t][:2]) for t in TABLE_6
    ]
    return [
        *lines,
        Wanted("figure 13", paths.curve_2_joints(), 2.27, 0.61),
        Wanted("figure 16", paths.curve_4_joints(), 3.49, 1.06),
        Wanted("figure 19", paths.complex_path_7_joints(), 1.98, 0.70),
        Wanted("figure 21", paths.curve_7_joints(), 0.71, 0.45),
    ]


def readings() -> Section:
    """Every parameter that the paper does not give, its readings, and the errors of each."""
    goals = wanted()
    cells, shares = [], {}
    for name, reading in READINGS.items():
        after: list[list[float]] = []
        before: list[list[float]] = []
        for goal in goals:
            scenario = goal.scenario
            starts = scenario.start()[None]
            run = rollout(scenario.load_arm(), starts, goal.targets(), reading=reading)
            for found, errors in ((after, run.after), (before, run.before)):
                found.append([100 * float(errors.max()), 100 * float(errors.mean())])
        limits = np.array([(goal.e_max, goal.e_mean) for goal in goals])
        texts, met = [], []
        for found in (after, before):
            inside = np.array(found) <= limits
            met.append(int(inside.sum()))
            texts.append(" ".join(f"{a:.2f}/{b:.2f}" for a, b in found))
        shares[name] = np.stack([np.array(after) / limits, np.array(before) / limits])
        claim = None if name != "ours" else met[0] == limits.size
        cells.append(
            Cell(f"{name}: of {limits.size} figures met", limits.size, met[0], claim, before=met[1])
        )
        cells.append(Cell("   e_max/e_mean [cm], after the step", None, texts[0]))
        cells.append(Cell("   the same, before the step", None, texts[1]))
    paper = " ".join(f"{goal.e_max:.2f}/{goal.e_mean:.2f}" for goal in goals)
    notes = [
        "Columns of e_max/e_mean: " + ", ".join(goal.key for goal in goals) + ".",
        f"The paper's: {paper}.",
        "Lost: the numbers of figure 6, how the average starts and whether the present error is in it,",
        "whether the gain is one for all rows, K and dr before the first cycle, and the convention of the",
        "error. Given, and not varied: Table I, the window of ten, four sign changes, the filters, 50 Hz.",
        "The text calls an error above its average big. Read so (B full at the average) K is 0.8 in ordinary",
        "tracking, and most figures fail; the figures are met where an error counts as medium there.",
    ]
    return Section(
        "readings",
        "what the paper leaves open, one thing changed at a time",
        cells,
        notes,
        {"fikm_readings": _figure(goals, shares)},
    )


def _figure(goals: list[Wanted], shares: dict[str, Array]) -> Figure:
    """Errors over the paper's, a row a reading; left of 1 they meet it."""
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    rows = np.arange(len(shares))[::-1]
    for panel, k, name in zip(panels, range(2), ("e_max", "e_mean")):
        for g, goal in enumerate(goals):
            for c, (marker, when) in enumerate((("o", "after"), ("x", "before"))):
                x = [share[c, g, k] for share in shares.values()]
                label = f"{goal.key}, {when} the step"
                panel.plot(x, rows + 0.06 * (g - 3), marker, color=f"C{g}", ms=5, label=label)
        panel.axvline(1.0, color="black", linewidth=1)
        panel.set_xlabel(f"{name} over the paper's [-]")
        panel.grid(alpha=0.3)
    panels[0].set_yticks(rows, list(shares))
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return figure
