"""Paper 5, section 3.3: Table 1 with figures 3 and 4."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fikm_drake.experiments.reproduce.integer.errors import workplane_errors
from fikm_drake.experiments.reproduce.report import Cell, Section, equal
from fikm_drake.fuzzy.integer import IntegerPartition, IntegerRuleBase
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk, tojo_inverse

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
    wanted = np.array([ORDER.index(label) for row in paper for label in row.split()])
    order = np.lexsort((wanted, singletons.T.ravel()))
    dealt = np.empty(len(wanted), dtype=int)
    dealt[order] = np.sort(wanted)
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
        {"integer_singletons": _figure(rules)},
    )


def _figure(rules: IntegerRuleBase) -> Figure:
    figure = Figure(figsize=(10, 5), layout="constrained")
    grid = figure.add_gridspec(1, 2)
    left, right = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    inputs = (("x [mm]", rules.first, X_LABELS), ("y [mm]", rules.second, Y_LABELS))
    for axes, (name, partition, labels) in zip(left.subplots(2), inputs):
        for knot, label, grades in zip(partition.knots, labels, _grades(partition)):
            axes.plot(range(partition.low, partition.high + 1), grades, linewidth=1.2)
            axes.annotate(label, (knot, 262), ha="center", fontsize=9)
        axes.set_ylim(0, 300)
        axes.set_xlabel(name)
        axes.set_ylabel("grade [-]")
    rows = right.subplots(len(TABLE_1), sharex=True)
    for j, (axes, joint) in enumerate(zip(rows, TABLE_1)):
        for k, label in enumerate(Y_LABELS):
            angles = rules.singletons[:, k, j] / 100
            axes.vlines(angles, 0, 1 - 0.2 * k, color=f"C{k}", label=f"y = {label}")
        axes.set_yticks([])
        axes.set_ylim(0, 1.15)
        axes.set_ylabel(joint.replace(" ", "\n"), rotation=0, ha="right", va="center")
    rows[0].legend(ncols=3, fontsize=7, loc="lower left")
    rows[-1].set_xlabel("singletons [°]")
    return figure


def _grades(partition: IntegerPartition) -> NDArray[np.int64]:
    """Truncated grades (labels, inputs) at every integer of the range."""
    x = np.arange(partition.low, partition.high + 1)
    cell, fall, rise = partition.locate_array(x, "truncate")
    grades = np.zeros((len(partition), len(x)), dtype=np.int64)
    grades[cell, np.arange(len(x))] = fall
    grades[cell + 1, np.arange(len(x))] = rise
    return grades


def figure_4() -> Section:
    """What is lost if all rules with one label of Table 1 share one singleton, their mean."""
    ik, inverse = IntegerFuzzyIk(), tojo_inverse()
    rules = ik.rules
    shared = IntegerRuleBase(rules.first, rules.second, shared_singletons(rules.singletons))
    points = inverse.workplane.grid()
    cells = []
    for name, variant in (("each rule its own", rules), ("five a joint, shared", shared)):
        angles, _ = variant.infer_batch(points[..., 0], points[..., 1])
        distance, _ = workplane_errors(inverse, points, ik.to_radians(angles))
        cells.append(Cell(f"{name}: error, max [mm]", None, float(distance.max())))
        cells.append(Cell(f"{name}: error, mean [mm]", None, float(distance.mean())))
    notes = ["The nine rules need singletons of their own; everything else here gives them these."]
    return Section("figure 4", "five singletons a joint or nine", cells, notes)


def shared_singletons(singletons: NDArray[np.int64]) -> NDArray[np.int64]:
    """Singletons (3,3,4) with all of one joint and label of Table 1 replaced by their mean."""
    shared = singletons.copy()
    for j, rows in enumerate(TABLE_1.values()):
        labels = np.array([row.split() for row in rows]).T
        for label in np.unique(labels):
            shared[labels == label, j] = np.rint(singletons[labels == label, j].mean())
    return shared
