"""Paper 3, section 2: the five rules and their memberships."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.experiments.plot_memberships import plot_memberships
from fikm_drake.experiments.report import Section, equal
from fikm_drake.laws.rate_inference import INFERENCE, PEAKS, rate_rules, rule_texts

TABLE_1 = {("N", "N"): "P", ("N", "Z"): "Z", ("N", "P"): "N"}
TABLE_1 |= {("P", "N"): "N", ("P", "Z"): "Z", ("P", "P"): "P"}
"""Labels of J and dr to that of dθ, as printed."""


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
        "Rows and columns of figure 4 have no numbers; the universes are our reading: D for dr, for J",
        "the length that the joint's column can reach. The product is the AND, so that a row's push is",
        "the surface at the right; with the minimum there is a dead band, and errors are far larger.",
    ]
    return Section(
        "table 1", "the five rules, figure 4", cells, notes, {"frmrc_figure_4": _figure()}
    )


def _figure() -> Figure:
    rules = rate_rules()
    figure = Figure(figsize=(11, 6.4), layout="constrained")
    (error, column), (surface, pushes) = figure.subplots(2, 2)
    plot_memberships(error, rules.first, "dr / D [-] (and dθ / T)")
    plot_memberships(column, rules.second, "J / L [-]")
    grid = np.linspace(-1.0, 1.0, 101)
    image = surface.contourf(grid, grid, rules(grid, grid[:, None]), levels=20, cmap="RdBu_r")
    figure.colorbar(image, ax=surface, label="dθ / T of one row [-]")
    surface.set_xlabel("dr / D [-]")
    surface.set_ylabel("J / L [-]")
    # A joint whose column lies along (1, 1), and errors of one length in all directions.
    angle = np.linspace(-np.pi, np.pi, 721)
    error_vectors = 0.5 * np.stack([np.cos(angle), np.sin(angle)])
    along = np.full_like(error_vectors, np.sqrt(0.5))
    for variant, (infer, _) in INFERENCE.items():
        push = infer(along, error_vectors, np.ones_like(angle), 1.0)
        pushes.plot(np.degrees(angle), push, label=variant)
    pushes.axhline(0.0, color="k", linewidth=0.8)
    for edge in (-45, 135):
        pushes.axvline(edge, color="k", linestyle="--", linewidth=0.8)
    pushes.set_xticks(range(-180, 181, 45))
    pushes.set_xlabel("direction of dr, |dr| = D / 2 [°]; J along 45°, right way between the dashes")
    pushes.set_ylabel("dθ / T of two rows [-]")
    pushes.legend()
    pushes.grid(alpha=0.3)
    return figure
