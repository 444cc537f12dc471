"""Paper 5, figure 4 read literally: five singletons a joint that the rules share."""

import numpy as np
from numpy.typing import NDArray

from fikm_drake.experiments.reproduce.integer.table_1 import TABLE_1
from fikm_drake.experiments.reproduce.integer.workplane_errors import workplane_errors
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.integer import IntegerRuleBase
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk, tojo_inverse


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
