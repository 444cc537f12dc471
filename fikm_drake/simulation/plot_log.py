"""A picture of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fikm_drake.control.status import ControllerStatus
from fikm_drake.files import new_figure, save_figure
from fikm_drake.simulation.tracking_log import TrackingLog

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHADES = {
    ControllerStatus.OSCILLATING: "tab:orange",
    ControllerStatus.LIMITED: "tab:red",
    ControllerStatus.INVALID_INPUT: "black",
}


def plot_log(log: TrackingLog, path: str | Path | None = None) -> Figure:
    """Draw error, gain and joints over time and the path in the plane or in space.

    Cycles whose status is oscillating, limited or invalid input are shaded.

    Args:
        log: the run.
        path: where to write the picture (.png, .pdf, .svg); None: nowhere.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.

    Raises:
        OSError: the file cannot be written.
        ValueError: matplotlib does not know the file's type.
    """
    figure = new_figure(11, 7)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1))
    error = figure.add_subplot(grid[0, 0])
    gain = figure.add_subplot(grid[1, 0], sharex=error)
    joints = figure.add_subplot(grid[2, 0], sharex=error)
    _plot_error(error, log)
    _plot_gain(gain, log)
    _plot_joints(joints, log)
    for axes in (error, gain, joints):
        _shade(axes, log)
        axes.grid(alpha=0.3)
    error.tick_params(labelbottom=False)
    gain.tick_params(labelbottom=False)
    joints.set_xlabel("time [s]")
    in_space = log.desired.shape[1] == 3
    _plot_path(figure.add_subplot(grid[:, 1], projection="3d" if in_space else None), log)
    arm = log.scenario.load_arm().name
    figure.suptitle(f"{arm}, {log.scenario.control_rate:g} Hz")
    if path is not None:
        save_figure(figure, path)
    return figure


def _plot_error(axes: Axes, log: TrackingLog) -> None:
    metrics = log.metrics()
    axes.plot(log.time, 100 * np.linalg.norm(log.error, axis=1), color="tab:blue")
    axes.set_ylabel("error [cm]")
    axes.set_ylim(bottom=0)
    axes.set_title(
        f"max {100 * metrics.e_max:.2f} cm, mean {100 * metrics.e_mean:.2f} cm, "
        f"end {100 * metrics.e_ss:.3f} cm",
        fontsize=10,
    )


def _plot_gain(axes: Axes, log: TrackingLog) -> None:
    axes.step(log.time, log.gain, where="post", color="tab:green")
    axes.set_ylabel("gain K [-]")
    axes.set_ylim(bottom=0)


def _plot_joints(axes: Axes, log: TrackingLog) -> None:
    revolute = log.scenario.load_arm().chain.revolute
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


def _plot_path(axes: Axes, log: TrackingLog) -> None:
    waypoints = np.array(log.scenario.waypoints)
    axes.plot(*waypoints.T, "k--", linewidth=1, label="desired")
    axes.plot(*log.actual.T, color="tab:blue", linewidth=1.8, label="actual")
    axes.plot(*log.actual[:1].T, "o", color="tab:blue", markersize=5, label="start")
    axes.plot(*waypoints[-1:].T, "kx", markersize=7, label="target")
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


def _shade(axes: Axes, log: TrackingLog) -> None:
    period = 1.0 / log.scenario.control_rate
    for status, colour in SHADES.items():
        # Edges of each run of cycles with this status.
        edges = np.flatnonzero(np.diff(np.concatenate([[0], log.status == status, [0]])))
        for k, (start, stop) in enumerate(edges.reshape(-1, 2)):
            label = status.name.lower().replace("_", " ") if k == 0 else None
            axes.axvspan(start * period, stop * period, color=colour, alpha=0.18, lw=0, label=label)
