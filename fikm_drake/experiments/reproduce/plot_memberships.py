"""Memberships as a picture."""

import numpy as np
from matplotlib.axes import Axes

from fikm_drake.fuzzy import TriangularPartition


def plot_memberships(axes: Axes, partition: TriangularPartition, xlabel: str) -> None:
    """Draw the grades of a partition over its range and a little beyond."""
    knots = partition.knots
    margin = 0.1 * (knots[-1] - knots[0])
    x = np.unique(np.concatenate([knots, np.linspace(knots[0] - margin, knots[-1] + margin, 400)]))
    for grades, label in zip(partition.grades(x).T, partition.labels):
        axes.plot(x, grades, linewidth=1.2)
        axes.annotate(label, (x[grades.argmax()], 1.02), ha="center", fontsize=8)
    axes.set_ylim(0, 1.12)
    axes.set_xlabel(xlabel)
    axes.set_ylabel("grade [-]")
