"""Paper 5, section 4.2: what more joints cost (Table 2), and that the C is exact."""

import numpy as np

from fikm_drake.experiments.reproduce.integer.compiled import (
    FLAGS,
    find_compiler,
    find_valgrind,
    instructions,
    mismatches,
    passes_self_test,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.integer import SHAPES, IntegerRuleBase
from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.fuzzy.integer.write_c import Shape
from fikm_drake.solvers.workplane.integer_fuzzy_ik import tojo_inverse
from fikm_drake.solvers.workplane.workplane_inverse import TiltedPlaneInverse

TABLE_2 = {4: 175, 8: 350, 12: 510, 24: 1040}
"""Joints: calculation time on a processor of 16 bits at 25 MHz [µs]."""
LARGEST_SHARE = 0.2
"""Claimed of the shared cell's instructions over the rule loop's, 4 joints."""
LARGEST_GROWTH = 3.5
"""Claimed of the shared cell's instructions, 24 joints over 4."""
SAME_GROWTH = 0.05
"""The rule loop is claimed to grow within this fraction of the paper's times."""
VARIANTS: tuple[tuple[Conjunction, Rounding], ...] = (("min", "truncate"), ("product", "nearest"))
"""The paper's arithmetic, and the most accurate."""


def operations(labels: int, joints: int, shape: Shape) -> int:
    """Additions, subtractions, multiplications, divisions and comparisons in one call of the C.

    With `min` and truncation, for a point inside a cell, the mean over all cells. Loads, stores,
    addresses and the counting of loops come on top.

    Args:
        labels: of x, and as many of y.
        joints: the number of outputs.
        shape: of the C.
    """
    inside = 4  # comparisons with the ends of both ranges
    if shape == "shared_cell":
        search = labels + (labels - 2)  # comparisons and steps down, both inputs
        grades = 2 * (2 + 2 + 3)  # offset and width; a rising grade; a falling one
        weights = 4 + 3  # of four rules, and their sum
        return inside + search + grades + weights + joints * (4 + 3 + 2)
    # A label below the value takes 4 operations, one above it 2; the two of the cell 4 and 5 more.
    grades = 2 * (3 * labels + 9)
    return inside + joints * (grades + 4 * labels**2 + 2)


def table_2() -> Section:
    """Table 2: the growth from 4 to 24 joints, beside the paper's times."""
    cells = [Cell(f"{n} joints: time [µs]", time, None) for n, time in TABLE_2.items()]
    counted = {shape: {n: float(operations(3, n, shape)) for n in JOINTS} for shape in SHAPES}
    cells += _costs("operations", counted)
    notes = [
        "Rules of Table 1, min, cut off. Operations are counted from the structure of the C; the paper's",
        "times grow as those of the rule loop, which does all rules anew for every joint.",
    ]
    if find_compiler() is None or find_valgrind() is None:
        notes.append("Instructions are not counted: that takes a C compiler `cc` and valgrind.")
        return Section("table 2", "cost of 4 to 24 joints", cells, notes)
    found = {shape: {n: instructions(many_joints(n), shape) for n in JOINTS} for shape in SHAPES}
    cells += _costs("instructions", found, LARGEST_GROWTH)
    share = found["shared_cell"][4] / found["rule_loop"][4]
    cells.append(
        Cell(
            f"4 joints: instructions, shared cell over rule loop [-], at most {LARGEST_SHARE:g}",
            None,
            share,
            share <= LARGEST_SHARE,
        )
    )
    wide = instructions(many_joints(4, labels=(33, 33)), "shared_cell")
    cells.append(Cell("shared_cell, 33 x 33 labels, instructions: 4 joints", None, wide))
    notes.append(f"Instructions: executed on this machine, counted by valgrind, cc {FLAGS[-1]}.")
    return Section("table 2", "cost of 4 to 24 joints", cells, notes)


def _costs(
    what: str, counts: dict[Shape, dict[int, float]], claim: float | None = None
) -> list[Cell]:
    """Counts of both shapes by the number of joints, and their growth."""
    cells = [
        Cell(f"{shape}, {what}: {n} joints", None, count)
        for shape, by_joints in counts.items()
        for n, count in by_joints.items()
    ]
    loop, cell = (counts[shape][24] / counts[shape][4] for shape in ("rule_loop", "shared_cell"))
    paper = TABLE_2[24] / TABLE_2[4]
    same = abs(loop - paper) <= SAME_GROWTH * paper
    cells.append(Cell(f"rule_loop, {what}: 24 joints over 4 [-]", paper, loop, same))
    label = f"shared_cell, {what}: 24 joints over 4 [-]"
    if claim is None:
        return [*cells, Cell(label, None, cell)]
    return [*cells, Cell(f"{label}, at most {claim:g}", None, cell, cell <= claim)]


def export() -> Section:
    """The C beside Python at every whole millimetre, 4 to 24 joints."""
    if find_compiler() is None:
        return Section("export", "C99 beside Python", [], ["Not run: there is no C compiler `cc`."])
    cells = []
    for n in JOINTS:
        for conjunction, rounding in VARIANTS:
            rules = many_joints(n, labels=(9, 9), conjunction=conjunction, rounding=rounding)
            for shape in SHAPES:
                label = f"{n} joints, {conjunction}, {rounding}, {shape}"
                wrong = mismatches(rules, shape)
                cells.append(Cell(f"{label}: mismatches", None, wrong, wrong == 0))
                good = passes_self_test(rules, shape)
                cells.append(
                    Cell(f"{label}: self-test", None, "passed" if good else "failed", good)
                )
    return Section("export", "C99 beside Python at 401 x 301 points, 9 x 9 labels", cells)


JOINTS = (4, 8, 12, 24)
"""Joints of Table 2."""
ASIDE = 0.01
"""From one arm's shoulder to the next one's [m]."""
RESOLUTION = 0.01
"""One step of the angles [°]."""


def many_joints(
    joints: int,
    *,
    labels: tuple[int, int] = (3, 3),
    conjunction: Conjunction = "min",
    rounding: Rounding = "truncate",
) -> IntegerRuleBase:
    """Rules for arms of 4 joints side by side that reach for the same point.

    Args:
        joints: a positive multiple of 4.
        labels: of x and of y.
        conjunction: `min` or `product`.
        rounding: `truncate` or `nearest`.
    """
    own, positions = tojo_inverse(), []
    for k in range(joints // 4):
        workplane = own.workplane
        workplane.origin[1] += ASIDE * k
        inverse = TiltedPlaneInverse(own.chain, workplane)
        first, second, found = inverse.singletons(labels, conjunction, least_squares=False)
        positions.append(found)
    steps = np.rint(np.rad2deg(np.concatenate(positions, axis=-1)) / RESOLUTION)
    return IntegerRuleBase(
        first, second, steps.astype(np.int64), conjunction=conjunction, rounding=rounding
    )
