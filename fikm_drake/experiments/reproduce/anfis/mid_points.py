"""Figures 3.16-3.19: the middle of θ1's region, and where it puts the other joints."""

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.anfis.region import ARM, A, plot_region, region
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R

SHOWN = 61.0
"""Share of the trajectory in figure 3.16 [%]."""


def figure_3_16() -> Section:
    """Figures 3.16-3.19: the middle of θ1 is inside the others' regions, not in their middles."""
    arm, found = load_arm(ARM), region(A)
    geometry, points = Planar3R(arm), A.at(found.percent)
    middles = np.mean([found.bounds(joint) for joint in range(3)], axis=1).T
    q = geometry.postures(points, middles[:, 0])[:, 0]
    inside = bool(geometry.is_inside(q).all())
    error = float(np.abs(arm.forward_kinematics(q)[:, :2, 3] - points).max())
    away = np.abs(q - middles).max(axis=0)
    shown = int(np.argmin(np.abs(found.percent - SHOWN)))
    cells = [
        Cell(
            "middle of θ1 leaves θ2, θ3 within their limits",
            "yes",
            "yes" if inside else "no",
            inside,
        ),
        Cell("tool off the trajectory, at most [m]", None, error, error <= 1e-12),
        *(
            Cell(
                f"θ{j} off the middle of its own region, at most [rad]", "not 0", float(away[j - 1])
            )
            for j in (2, 3)
        ),
        *(
            Cell(
                f"θ{j} at {found.percent[shown]:.2f} %: region, value [rad]",
                None,
                "{:.4f}-{:.4f}, {:.4f}".format(
                    *(float(bound[shown]) for bound in found.bounds(j - 1)), q[shown, j - 1]
                ),
            )
            for j in (1, 2, 3)
        ),
    ]
    figure = Figure(figsize=(9, 8), layout="constrained")
    rows = figure.subplots(3, 1, sharex=True)
    for joint, axes in enumerate(rows):
        plot_region(axes, found, joint, arm)
        axes.plot(found.percent, q[:, joint], "k-", lw=1.5, label="at the middle of θ1")
        axes.plot(found.percent, middles[:, joint], "k:", lw=1.2, label="middle of its own region")
        axes.axvline(SHOWN, color="0.5", lw=0.8)
    rows[1].legend(loc="best", fontsize=9)
    rows[-1].set_xlabel("share of trajectory A [%]")
    return Section(
        "figure 3.16",
        "middle of θ1's region along trajectory A, figures 3.16-3.19",
        cells,
        pictures={"figures_3_16_19": figure},
    )
