"""Paper 5: what it leaves open, each read in more than one way, and what each reading gives."""

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.integer.errors import workplane_errors
from fikm_drake.experiments.reproduce.integer.table_1 import (
    TABLE_1,
    labels_in_order,
    shared_singletons,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.integer import IntegerPartition, IntegerRuleBase
from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.workplane.integer_fuzzy_ik import tojo_inverse
from fikm_drake.solvers.workplane.workplane_inverse import HEADING, TiltedPlaneInverse

LABELS = 36
"""Of Table 1."""
FIGURE_9 = (200, 150)
"""Our circle's centre [mm]."""


@dataclass(frozen=True)
class Choice:
    """One way to read what is lost; the default is ours."""

    heading: tuple[float, float] = HEADING
    """Of the person's hand at the near and the far edge [rad]."""
    size: float = 1.0
    """Lengths of the person's arm over ours [-]."""
    nearer: float = 0.0
    """The desk is so much nearer to the person than ours [m]."""
    inset: float = 0.0
    """The outer peaks of figure 3 lie this share of the desk inside its edges [-]."""
    shared: bool = False
    """Figure 4: rules with one label share one singleton."""
    rounding: Rounding = "truncate"
    """Of the grades and of equation 5."""
    resolution: float = 0.01
    """One step of the joints' angles [°]."""

    def inverse(self) -> TiltedPlaneInverse:
        """The person as a model."""
        table, workplane = load_arm("tojo4dof").table, tojo_inverse().workplane
        joints = [replace(row, a=self.size * row.a) for row in table.joints]
        tool = replace(table.tool, a=self.size * table.tool.a)
        workplane.origin[0] -= self.nearer
        arm = DhArm(replace(table, joints=joints, tool=tool))
        return TiltedPlaneInverse(arm, workplane, heading=self.heading)

    def rules(self, inverse: TiltedPlaneInverse) -> IntegerRuleBase:
        """Its nine rules."""
        first, second = (self._peaks(end) for end in inverse.workplane.size)
        peaks = np.stack(np.meshgrid(first.knots, second.knots, indexing="ij"), axis=-1)
        steps = np.rint(np.rad2deg(inverse(peaks)) / self.resolution).astype(np.int64)
        if self.shared:
            steps = shared_singletons(steps)
        return IntegerRuleBase(first, second, steps, rounding=self.rounding)

    def _peaks(self, end: int) -> IntegerPartition:
        """Three labels over 0 to `end` [mm]."""
        edge = round(self.inset * end)
        return IntegerPartition([edge, round(end / 2), end - edge])


READINGS: dict[str, dict[str, Choice]] = {
    "heading of the hand": {
        "ours, −1.01 to −.41 rad": Choice(),
        "constant, −.71": Choice(heading=(-0.71, -0.71)),
        "straight ahead, 0": Choice(heading=(0.0, 0.0)),
        "−1.2 to −.2": Choice(heading=(-1.2, -0.2)),
        "−.41 to −1.01": Choice(heading=(-0.41, -1.01)),
    },
    "arm and place": {
        "arm 5 % shorter": Choice(size=0.95),
        "arm 10 % longer": Choice(size=1.1),
        "desk 50 mm nearer": Choice(nearer=0.05),
        "desk 20 mm further": Choice(nearer=-0.02),
    },
    "figure 3: outer peaks": {
        "1/12 of the desk inside its edges": Choice(inset=1 / 12),
        "1/6 inside": Choice(inset=1 / 6),
    },
    "figure 4: singletons": {"five a joint, shared": Choice(shared=True)},
    "decimals": {"rounded": Choice(rounding="nearest")},
    "step of an angle": {
        ".1°": Choice(resolution=0.1),
        "1°": Choice(resolution=1.0),
    },
}
"""By what is lost; the first is ours, each other changes one thing."""
CIRCLES = (50, 100, 150)
"""Radii of figure 9's circle, which the paper does not give [mm]."""


def errors(choice: Choice, points: NDArray[np.int64] | None = None) -> tuple[int, Array]:
    """How many labels agree with Table 1 in order, and the tool's error at points (…,2), (…) [mm]."""
    inverse = choice.inverse()
    rules = choice.rules(inverse)
    agree = 0
    for j, paper in enumerate(TABLE_1.values()):
        found = labels_in_order(rules.singletons[..., j], paper)
        agree += sum(
            a == b for ours, text in zip(found, paper) for a, b in zip(ours.split(), text.split())
        )
    where = inverse.workplane.grid(2) if points is None else points
    steps, _ = rules.infer_batch(where[..., 0], where[..., 1])
    return agree, workplane_errors(inverse, where, np.deg2rad(choice.resolution * steps))[0]


def readings() -> Section:
    """The person's arm, figures 3 and 4, decimals, steps, the circle: labels that agree, and errors."""
    cells, found = [], {}
    for lost, choices in READINGS.items():
        for name, choice in choices.items():
            agree, distance = errors(choice)
            found[f"{lost}: {name}"] = agree, float(distance.max()), float(distance.mean())
            claim = agree == LABELS if choice == Choice() else None
            label = f"{lost}: {name}"
            cells.append(Cell(f"{label}: labels of {LABELS} that agree", LABELS, agree, claim))
            text = f"{distance.max():.1f} / {distance.mean():.1f}"
            cells.append(Cell("   error over the desk, max / mean [mm]", None, text))
    for radius in CIRCLES:
        angle = np.deg2rad(np.arange(361))
        ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        points = np.rint(ring + np.array(FIGURE_9)).astype(np.int64)
        _, distance = errors(Choice(), points)
        label = f"figure 9: circle of {radius} mm: error, max / mean [mm]"
        cells.append(Cell(label, None, f"{distance.max():.1f} / {distance.mean():.1f}"))
    notes = [
        "Lost: the person's joint angles and arm, the numbers of figures 3 and 4, whether equation 5 is cut",
        "off or rounded and in which steps, the circle of figure 9 and the line of figure 11. Given, and not",
        "varied: nine points, AND by min, grades to 255 cut off, the desk of 400 x 300 mm.",
        "One thing changed at a time; every other millimetre. Heading, arm and place stand for the person's",
        "joint angles: Table 1 tells the headings apart, and much less the arms and places. The error is",
        "that of nine rules, whoever the person is; it is several times larger where singletons are shared.",
    ]
    picture = {"integer_readings": _figure(found)}
    return Section(
        "readings", "what the paper leaves open, read in other ways", cells, notes, picture
    )


def _figure(found: dict[str, tuple[int, float, float]]) -> Figure:
    """Labels that agree, and errors, a row a reading."""
    figure = Figure(figsize=(12, 5), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    rows = np.arange(len(found))[::-1]
    agree, largest, mean = np.transpose(list(found.values()))
    left.barh(rows, agree)
    left.axvline(LABELS, color="black", linewidth=1)
    left.set_xlabel(f"labels of Table 1 that agree, of {LABELS}")
    left.set_yticks(rows, list(found))
    right.plot(largest, rows, "o", label="max")
    right.plot(mean, rows, "s", label="mean")
    right.set_xlabel("error over the desk [mm]")
    right.set_xscale("log")
    right.legend()
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure
