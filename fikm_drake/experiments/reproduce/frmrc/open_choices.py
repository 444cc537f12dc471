"""Paper 3: what it leaves open, each read in more than one way, and what each reading gives."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.column_reach import column_reach
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.task import Task
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import LawLike
from fikm_drake.laws.pseudo_inverse import PseudoInverse
from fikm_drake.simulation.scenario import load_scenario

PATHS = ("line", "circle")
HOLD = 50
"""Cycles after the end."""


def laws(arm: DhArm) -> dict[str, LawLike]:
    """One thing read in another way, each; the first is ours of the paper's own inference."""
    reach = column_reach(arm.jacobian_range(), Task("xy"))
    paper = FuzzyRateControl("paper", reach=reach)
    own = {
        f"D = {D:g} m": FuzzyRateControl("paper", reach=reach, error_range=D)
        for D in (0.05, 0.2, 0.4)
    }
    gains = {f"gain {g:g}": FuzzyRateControl("paper", reach=reach, gain=g) for g in (1.0, 1.2, 1.7)}
    return {
        "ours: OR by the largest, reach of each joint, D = .1 m, gain 1.4": paper,
        "OR by the sum": FuzzyRateControl(reach=reach, gain=1.4),
        "universe of J: one for all joints": FuzzyRateControl(
            "paper", reach=np.full(3, reach.max())
        ),
        "universe of J: the column at the posture": FuzzyRateControl("paper"),
        **own,
        **gains,
        "joints from the tool to the base": _Reversed(FuzzyRateControl("paper", reach=reach[::-1])),
    }


class _Reversed:
    """The joints asked in the other order."""

    def __init__(self, law: FuzzyRateControl) -> None:
        self._law = law

    def __call__(self, J: Array, dr: Array) -> Array:
        return self._law(J[..., ::-1], dr)[..., ::-1]


def follow(law: LawLike, arm: DhArm, start: Array, targets: Array) -> tuple[float, float]:
    """Largest error after and before the step [m] of a plain resolved-rate loop over targets (T,2)."""
    q, after, before = np.array(start), [], []
    for target in [*targets, *[targets[-1]] * HOLD]:
        error = target - arm.forward_kinematics(q)[:2, 3]
        q = q + law(arm.jacobian(q)[3:5], error)
        before.append(np.linalg.norm(error))
        after.append(np.linalg.norm(target - arm.forward_kinematics(q)[:2, 3]))
    return float(max(after)), float(max(before))


def readings() -> Section:
    """Universes, OR, gain, order of the joints: largest errors on figures 6 and 7."""
    arm = load_arm("kim_lee3r")
    cells, found = [], {}
    for path in PATHS:
        scenario = load_scenario(f"frmrc_{path}")
        start, targets = scenario.start(), scenario.targets()
        reference = follow(PseudoInverse(), arm, start, targets)
        after, before = (1e3 * error for error in reference)
        label = f"{path}, pseudo-inverse: max error [mm]"
        cells.append(Cell(label, None, after, before=before))
        for name, law in laws(arm).items():
            after, before = follow(law, arm, start, targets)
            found[path, name] = before / reference[1]
            label = f"{path}, {name}: max error [mm]"
            cells.append(Cell(label, None, 1e3 * after, before=1e3 * before))
    notes = [
        "Lost: the numbers of figure 4 (universes of dr, J and dθ), how the rows are joined, in which order",
        "the joints are asked. One thing changed at a time. The paper claims errors of the pseudo-inverse's",
        "order: told by the picture. One universe of J for all joints asks the joints near the tool for too",
        "little, a D below the error of tracking cuts it off; the sum of the rows in place of the largest,",
        "and universes that follow the posture, are better on both paths.",
    ]
    picture = {"frmrc_readings": _figure(found, list(laws(arm)))}
    return Section(
        "readings", "what the paper leaves open, read in other ways", cells, notes, picture
    )


def _figure(found: dict[tuple[str, str], float], names: list[str]) -> Figure:
    figure = Figure(figsize=(9, 4.4), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(names))[::-1]
    for path, marker in zip(PATHS, "os"):
        axes.semilogx([found[path, name] for name in names], rows, marker, label=path)
    axes.axvline(1.0, color="black", linewidth=1)
    axes.set_yticks(rows, names)
    axes.set_xlabel("max error before the step over the pseudo-inverse's [-]")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure
