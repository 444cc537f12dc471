"""The two conventions of a tracking error: to the target of a cycle, after its step or before it.

Paper 1's figures are met after the step, paper 3 plots what is there before it; neither says so. With a
target that moves by v T a cycle the two differ by about that much, which is most of either.
"""

from dataclasses import dataclass

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.report import Cell, at_most
from fikm_drake.simulation.run_log import RunLog

NOTE = [
    "After step: the error that a cycle's step leaves to that cycle's target; before step: what it finds.",
    "The paper does not say which it plots. Claimed is the first; on the second: meets, or misses.",
]


@dataclass(frozen=True)
class Errors:
    """Errors of a run [m] by one convention."""

    e_max: float
    """The largest over path and hold [m]."""
    e_mean: float
    """The mean [m]."""
    e_ss: float
    """In the last cycle [m]."""

    @classmethod
    def of(cls, error: Array) -> "Errors":
        """The errors of desired minus actual, a row a cycle (N,m) [m]."""
        length = np.linalg.norm(error, axis=1)
        return cls(float(length.max()), float(length.mean()), float(length[-1]))


def errors_before(log: RunLog) -> Array:
    """Desired minus actual at the start of each cycle (N,m) [m]."""
    return log.error_before[:-1]


def both(log: RunLog) -> tuple[Errors, Errors]:
    """Errors of a run after each step, and before it."""
    return Errors.of(log.cycles.error), Errors.of(errors_before(log))


def error_texts(log: RunLog) -> tuple[str, str]:
    """e_max / e_mean / e_ss [cm] as text, after each step and before it."""
    after, before = (
        f"{100 * e.e_max:.3f} / {100 * e.e_mean:.3f} / {100 * e.e_ss:.4f}" for e in both(log)
    )
    return after, before


def error_cells(log: RunLog, paper: tuple[float, float], prefix: str = "") -> list[Cell]:
    """e_max and e_mean [cm] beside the paper's, by both conventions."""
    after, before = both(log)
    return [
        at_most(f"{prefix}{name} [cm]", figure, 100 * ours, 100 * found)
        for name, figure, ours, found in zip(
            ("e_max", "e_mean"),
            paper,
            (after.e_max, after.e_mean),
            (before.e_max, before.e_mean),
        )
    ]
