"""Paper 5, section 3.3: Table 1 with figures 3 and 4."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fikm_drake.experiments.report import Cell, Section, equal
from fikm_drake.fuzzy.integer import IntegerPartition, IntegerRuleBase
from fikm_drake.solvers.integer_fuzzy_ik import IntegerFuzzyIk

TABLE_1 = {
    "shoulder pitch": ("S S S", "M M M", "L L L"),
    "shoulder roll": ("L ML MS", "ML M S", "M MS S"),
    "elbow": ("L L ML", "M M M", "MS MS S"),
    "wrist": ("L ML S", "L M S", "ML M MS"),
}
"""Labels of each joint: a row for y = N, M, F, in it x = L, C, R."""
ORDER = ("S", "MS", "M", "ML", "L")
X_LABELS, Y_LABELS = "LCR", "NMF"


def labels_in_order(singletons: NDArray[np.int64], paper: tuple[str, ...]) -> tuple[str, ...]:
    """A joint's labels if the paper's were dealt out by size.

    Args:
        singletons: of the joint (3,3): rows follow x, columns y.
        paper: the paper's labels, a row for each y.

    Returns:
        Labels like the paper's; where singletons are equal, in the paper's order.
    """
    wanted = [ORDER.index(label) for row in paper for label in row.split()]
    order = np.lexsort((wanted, singletons.T.ravel()))
    dealt = np.empty(len(wanted), dtype=int)
    dealt[order] = sorted(wanted)
    return tuple(" ".join(ORDER[k] for k in row) for row in dealt.reshape(3, 3))


def table_1() -> Section:
    """Table 1: which label each rule's singleton gets, and figures 3 and 4."""
    rules = IntegerFuzzyIk().rules
    cells, notes, agree = [], [], 0
    for j, (joint, paper) in enumerate(TABLE_1.items()):
        ours = labels_in_order(rules.singletons[..., j], paper)
        for y, theirs, mine, angles in zip(Y_LABELS, paper, ours, rules.singletons[..., j].T):
            cells.append(equal(f"{joint}, y = {y}, x = {' '.join(X_LABELS)}", theirs, mine))
            agree += sum(a == b for a, b in zip(theirs.split(), mine.split()))
            degrees = "  ".join(f"{angle / 100:7.2f}" for angle in angles)
            notes.append(f"{joint:14s}  {y}  {degrees}")
    cells.append(Cell("labels that agree in order", 36, agree, agree == 36))
    notes = [
        "A fit, not a prediction: the person's data are not published, and the heading of our arm's",
        "hand was chosen so that the labels agree. The wrist bends the same way as the elbow.",
        "Singletons [°], x = L C R:",
        *notes,
    ]
    return Section(
        "table 1",
        "labels of the 36 singletons, figures 3 and 4",
        cells,
        notes,
        {"figures_3_4": _figure(rules)},
    )


def _figure(rules: IntegerRuleBase) -> Figure:
    figure = Figure(figsize=(10, 5), layout="constrained")
    grid = figure.add_gridspec(4, 2)
    inputs = (("x [mm]", rules.first, X_LABELS), ("y [mm]", rules.second, Y_LABELS))
    for k, (name, partition, labels) in enumerate(inputs):
        axes = figure.add_subplot(grid[2 * k : 2 * k + 2, 0])
        for knot, label, grades in zip(partition.knots, labels, _grades(partition)):
            axes.plot(range(partition.low, partition.high + 1), grades, linewidth=1.2)
            axes.annotate(label, (knot, 262), ha="center", fontsize=9)
        axes.set_ylim(0, 300)
        axes.set_xlabel(name)
        axes.set_ylabel("grade [-]")
    for j, joint in enumerate(TABLE_1):
        axes = figure.add_subplot(grid[j, 1])
        angles = rules.singletons[..., j].T / 100
        for row, label, height in zip(angles, Y_LABELS, (1.0, 0.8, 0.6)):
            axes.vlines(row, 0, height, color=f"C{Y_LABELS.index(label)}", label=f"y = {label}")
        axes.set_yticks([])
        axes.set_ylim(0, 1.15)
        axes.set_xlim(-60, 145)
        axes.set_ylabel(joint.replace(" ", "\n"), rotation=0, ha="right", va="center")
        axes.tick_params(labelbottom=j == len(TABLE_1) - 1)
        if j == 0:
            axes.legend(ncols=3, fontsize=8, loc="upper left")
    axes.set_xlabel("singletons [°]")
    return figure


def _grades(partition: IntegerPartition) -> NDArray[np.int64]:
    """Truncated grades (labels, inputs) at every integer of the range."""
    x = np.arange(partition.low, partition.high + 1)
    cell, fall, rise = partition.locate_array(x, "truncate")
    grades = np.zeros((len(partition), len(x)), dtype=np.int64)
    grades[cell, np.arange(len(x))] = fall
    grades[cell + 1, np.arange(len(x))] = rise
    return grades
