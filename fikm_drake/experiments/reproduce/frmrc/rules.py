"""Paper 3, section 2: the five rules and their memberships."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.plot_memberships import plot_memberships
from fikm_drake.experiments.reproduce.report import Section, equal
from fikm_drake.laws.rate_inference import INFERENCE, PEAKS, rate_rules, rule_texts

TABLE_1 = {("N", "N"): "P", ("N", "Z"): "Z", ("N", "P"): "N"}
TABLE_1 |= {("P", "N"): "N", ("P", "Z"): "Z", ("P", "P"): "P"}
"""Labels of J and dr to that of dθ, as printed."""
DIRECTION = 20
"""Direction of the column of J in the picture of two rows [°]."""


def table_1() -> Section:
    """Table 1 with figure 4."""
    rules = rate_rules()
    label = {peak: name for name, peak in PEAKS.items()}
    cells = []
    for (J, dr), expected in TABLE_1.items():
        peak = rules.evaluate(PEAKS[dr], PEAKS[J])
        cells.append(equal(f"dθ where J is {J} and dr is {dr}", expected, label.get(peak)))
    notes = [
        *rule_texts(),
        "Figure 4 has no numbers: the universes are our reading, D for dr, for J the length L that the",
        "joint's column can reach, for dθ T = gain D / L. With the product as AND a row pushes as in the",
        "picture of the surface. The paper's OR takes the larger of two rows, which is not smooth and can",
        "push the wrong way; the sum of the rows cannot.",
    ]
    return Section(
        "table 1", "the five rules, figure 4", cells, notes, {"frmrc_figure_4": _figure()}
    )


def _figure() -> Figure:
    rules = rate_rules()
    figure = Figure(figsize=(11, 6.4), layout="constrained")
    (error, column), (surface, pushes) = figure.subplots(2, 2)
    plot_memberships(error, rules.first, "dr / D, dθ / T [-]")
    plot_memberships(column, rules.second, "J / L [-]")
    grid = np.linspace(-1.0, 1.0, 101)
    image = surface.contourf(grid, grid, rules(grid, grid[:, None]), levels=20, cmap="RdBu_r")
    figure.colorbar(image, ax=surface, label="dθ / T of one row [-]")
    surface.set_xlabel("dr / D [-]")
    surface.set_ylabel("J / L [-]")
    angle = np.linspace(-180.0, 180.0, 721)
    dr = 0.5 * _directions(angle)
    J = _directions(np.full_like(angle, DIRECTION))
    for variant, (infer, _) in INFERENCE.items():
        pushes.plot(angle, infer(J, dr, np.ones_like(angle), 1.0), label=variant)
    pushes.axhline(0.0, color="k", linewidth=0.8)
    for edge in (DIRECTION - 90, DIRECTION + 90):
        pushes.axvline(edge, color="k", linestyle="--", linewidth=0.8)
    pushes.set_title(f"|dr| = D / 2, J at {DIRECTION}°; dashed: dr across J", fontsize=9)
    pushes.set_xticks(range(-180, 181, 45))
    pushes.set_xlabel("direction of dr [°]")
    pushes.set_ylabel("dθ / T of two rows [-]")
    pushes.legend(loc="upper left")
    pushes.grid(alpha=0.3)
    return figure


def _directions(angle: Array) -> Array:
    """Unit vectors (2,N) at angles (N,) [°]."""
    return np.stack([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
