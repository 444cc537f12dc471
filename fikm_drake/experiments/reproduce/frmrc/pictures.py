"""Pictures of planar runs: snapshots of the arm, and the errors of laws below each other."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.conventions import errors_before
from fikm_drake.simulation.run_log import RunLog


def comparison(logs: dict[str, RunLog], shown: str, count: int) -> Figure:
    """Snapshots of one log at the left, as (a) of figures 6 and 7, the errors of all at the right.

    Args:
        logs: runs of one scenario, by the name of the law.
        shown: name of the run whose arm is drawn.
        count: snapshots.
    """
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    grid = figure.add_gridspec(len(logs), 2, width_ratios=(1.05, 1))
    arm = figure.add_subplot(grid[:, 0])
    snapshots(arm, logs[shown], count)
    arm.set_title(f"{shown}: the arm, from light to dark", fontsize=9, loc="left")
    first = None
    for row, (name, log) in enumerate(logs.items()):
        axes = first = figure.add_subplot(grid[row, 1], sharex=first, sharey=first)
        error = 1000 * errors_before(log)
        for series, label in zip(error.T, "xy"):
            axes.plot(log.cycles.time, series, label=label, linewidth=1.2)
        axes.set_title(
            f"{name}: max {np.linalg.norm(error, axis=1).max():.1f} mm", fontsize=9, loc="left"
        )
        axes.tick_params(labelbottom=row == len(logs) - 1)
        axes.set_ylabel("error [mm]")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right", fontsize=8, ncols=2)
    if first is not None:
        first.set_xlabel("time [s]")
    rate = logs[shown].scenario.control_rate
    figure.suptitle(f"{logs[shown].scenario.load_arm().name}, {rate:g} Hz")
    return figure


def snapshots(axes: Axes, log: RunLog, count: int) -> None:
    """Draw a planar arm at `count` instants, later ones darker, with the target's path and its own."""
    arm = log.scenario.load_arm()
    q = log.q
    # The last cycle in which the target moves; the hold would draw the same arm again.
    moving = np.flatnonzero(np.linalg.norm(log.desired - log.desired[-1], axis=1) > 0)
    last = int(moving[-1]) + 2 if len(moving) else len(q) - 1
    chosen = q[np.linspace(0, min(last, len(q) - 1), count).round().astype(int)]
    joints = arm.link_poses(chosen)[..., :2, 3]
    tool = arm.forward_kinematics(chosen)[:, None, :2, 3]
    for k, points in enumerate(np.concatenate([joints, tool], axis=1)):
        shade = k / max(count - 1, 1)
        axes.plot(*points.T, "o-", color=str(0.9 - 0.6 * shade), linewidth=2, markersize=4)
    axes.plot(*log.desired.T, "k--", linewidth=1, label="desired")
    axes.plot(*log.actual.T, color="tab:blue", linewidth=1.8, label="actual")
    axes.plot(0.0, 0.0, "ks", markersize=8)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=9)
