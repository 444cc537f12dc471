"""Paper 4, tables 3 and 4: error and time of each method."""

from fikm_drake.experiments.reproduce.labvolt.runs import (
    FEW,
    MANY,
    PAPER,
    RANDOM_START,
    bare,
    few,
    many,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.solvers.labvolt.solve import TOLERANCE

HYBRID_SHARE = 99.9
"""What `hybrid_sqp` is claimed to solve at least [%]."""


def table_3() -> Section:
    """Table 3: error of the tool."""
    runs = many()
    cells = []
    for name, run in runs.items():
        error = 1e6 * run.error
        paper = PAPER[name][0]
        cells.append(
            Cell(
                f"{name}: error [µm]",
                _pair(*paper) if paper else None,
                _pair(error.mean(), error.std()),
            )
        )
    for name, run in runs.items():
        share = 100.0 * run.solved / MANY
        claim = {
            "exact": share == 100.0,
            "cascade": share == 100.0,
            "hybrid_sqp": share >= HYBRID_SHARE,
        }
        cells.append(
            Cell(f"{name}: solved to {1e9 * TOLERANCE:g} nm [%]", None, share, claim.get(name))
        )
    notes = [
        f"{MANY} seeded targets, of postures uniform inside the limits.",
        "The closed form is exact: algorithm 1 errs by rounding alone, so SQP after it has nothing to do",
        "but to choose a posture. The paper's micrometres come from elsewhere: see `rounding`.",
        "What is left of the error of the SQP is its local minima. In relative angles it has none from the",
        "middle of the limits: there the plain SQP needs no fuzzy start, see `starts`.",
        f"`{RANDOM_START}`: the same program; the paper does not say where its SQP starts.",
    ]
    return Section("table 3", "error of the tool, average ± standard deviation", cells, notes)


def table_4() -> Section:
    """Table 4: time."""
    cells = []
    for name, run in few().items():
        time, paper = run.milliseconds, PAPER[name][1]
        how = "bare" if name == RANDOM_START else "through `solve`"
        cells.append(
            Cell(
                f"{name}: time, {how} [ms]",
                _pair(*paper) if paper else None,
                _pair(time.mean(), time.std()),
            )
        )
    for name, time in bare().items():
        label = f"{name}: time, bare [ms]"
        cells.append(Cell(label, None, _pair(float(time.mean()), float(time.std()))))
    notes = [
        "Bare: the program alone, to be compared with each other; `solve` around it reads and checks too.",
        f"CPU time of one call a target, {FEW} targets; half a millisecond of each is numpy for one target,",
        "which `solve` shares among many: see `fikm-drake benchmark labvolt`. Nothing is claimed here.",
    ]
    return Section("table 4", "time of one target, average ± standard deviation", cells, notes)


def _pair(mean: float, deviation: float) -> str:
    return f"{mean:.3g} ± {deviation:.3g}"
