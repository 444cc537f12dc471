"""A picture of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fikm_drake.files import new_figure, save_figure
from fikm_drake.simulation.run_log import RunLog

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHADES = {
    "OSCILLATING": "tab:orange",
    "LIMITED": "tab:red",
    "INVALID_INPUT": "black",
    "STUCK": "tab:purple",
    "NOT_FOLLOWING": "tab:brown",
    "BLOCKED": "tab:olive",
    "RESTART_SEARCH": "tab:pink",
}
"""Colours of what needs a look, by the status's name."""


def plot_log(log: RunLog, path: str | Path | None = None) -> Figure:
    """Draw error, gain or torque, and joints over time, and the path in the plane or in space.

    Cycles whose status needs a look (`SHADES`) are shaded, and the clearance is drawn where there is one.

    Args:
        log: a scenario's run.
        path: where to write the picture (.png, .pdf, .svg); None: nowhere.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.

    Raises:
        OSError: the file cannot be written.
        ValueError: matplotlib does not know the file's type, or the log has no scenario.
    """
    figure = new_figure(11, 7)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1))
    error = figure.add_subplot(grid[0, 0])
    middle = figure.add_subplot(grid[1, 0], sharex=error)
    joints = figure.add_subplot(grid[2, 0], sharex=error)
    _plot_error(error, log)
    _plot_middle(middle, log)
    _plot_joints(joints, log)
    for axes in (error, middle, joints):
        _shade(axes, log)
        axes.grid(alpha=0.3)
    if error.get_legend_handles_labels()[1]:
        error.legend(fontsize=8, loc="upper right")
    error.tick_params(labelbottom=False)
    middle.tick_params(labelbottom=False)
    joints.set_xlabel("time [s]")
    in_space = log.desired.shape[1] != 2
    _plot_path(figure.add_subplot(grid[:, 1], projection="3d" if in_space else None), log)
    robot = log.scenario.load_robot().name
    figure.suptitle(f"{robot}, {log.scenario.control_rate:g} Hz")
    if path is not None:
        save_figure(figure, path)
    return figure


def _plot_error(axes: Axes, log: RunLog) -> None:
    metrics = log.metrics()
    error = log.error_after
    turns = error.shape[1] == 6
    axes.plot(log.time, 100 * np.linalg.norm(error[:, -3:], axis=1), color="tab:blue")
    axes.set_ylabel("error [cm]")
    axes.set_ylim(bottom=0)
    axes.set_title(
        f"max {100 * metrics.e_max:.2f} cm, mean {100 * metrics.e_mean:.2f} cm, "
        f"end {100 * metrics.e_ss:.3f} cm",
        fontsize=10,
    )
    if turns:
        right = axes.twinx()
        right.plot(
            log.time, np.rad2deg(np.linalg.norm(error[:, :3], axis=1)), "--", color="tab:cyan"
        )
        right.set_ylabel("turn [°]")
        right.set_ylim(bottom=0)


def _plot_middle(axes: Axes, log: RunLog) -> None:
    """The gain where there is one, else the commanded speeds; the clearance where there is one."""
    if "clearance" in log:
        right = axes.twinx()
        right.plot(log.time, 1000 * log.clearance, "--", color="tab:gray")
        right.set_ylabel("clearance [mm]")
        known = log.clearance[np.isfinite(log.clearance)]
        right.set_ylim(bottom=1000 * float(known.min(initial=0.0)))
    if "gain" in log and log["gain"].shape[1] == 1:
        axes.step(log.time, log.gain, where="post", color="tab:green")
        axes.set_ylabel("gain K [-]")
        axes.set_ylim(bottom=0)
        return
    axes.plot(log.time, log.velocity, linewidth=1)
    axes.set_ylabel("joint speeds [rad/s or m/s]")


def _plot_joints(axes: Axes, log: RunLog) -> None:
    revolute = [label.endswith("_rad") for label in log.info.columns["q"]]
    for i, q in enumerate(log.q.T):
        axes.plot(log.time, q, label=f"$q_{{{i + 1}}}$", linewidth=1.2)
    axes.set_ylabel("joints q [rad]" if all(revolute) else "joints q [rad, m]")
    axes.legend(
        ncols=8,
        fontsize=8,
        handlelength=1.2,
        columnspacing=1.0,
        loc="upper left",
        bbox_to_anchor=(0, -0.28),
        frameon=False,
    )


def _plot_path(axes: Axes, log: RunLog) -> None:
    corners = log.scenario.target_motion().corners
    actual = log.actual[:, -3:]
    axes.plot(*corners.T, "k--", linewidth=1, label="desired")
    axes.plot(*actual.T, color="tab:blue", linewidth=1.8, label="actual")
    axes.plot(*actual[:1].T, "o", color="tab:blue", markersize=5, label="start")
    axes.plot(*corners[-1:].T, "kx", markersize=7, label="target")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    if isinstance(axes, Axes3D):
        axes.set_zlabel("z [m]")
        axes.locator_params(nbins=5)
        axes.set_box_aspect(None, zoom=0.85)  # else the label of z is cut off
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize=9)
    axes.grid(alpha=0.3)


def _shade(axes: Axes, log: RunLog) -> None:
    if "status" not in log:
        return
    period, names = 1.0 / log.scenario.control_rate, np.array(log.status_names)
    for status, colour in SHADES.items():
        # Edges of each run of cycles with this status.
        edges = np.flatnonzero(np.diff(np.concatenate([[0], names == status, [0]])))
        for k, (start, stop) in enumerate(edges.reshape(-1, 2)):
            label = status.lower().replace("_", " ") if k == 0 else None
            axes.axvspan(start * period, stop * period, color=colour, alpha=0.18, lw=0, label=label)
