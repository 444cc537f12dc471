"""The thesis's trajectories, and feasible regions along them."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.self_motion.interval_table import TURNING_POINT, FeasibleInterval
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer


@dataclass(frozen=True)
class Trajectory:
    """Straight sides from corner to corner; each side is the same share of the whole."""

    name: str
    """A letter."""
    corners: tuple[tuple[float, float], ...]
    """(x, y) [m], in order."""

    def at(self, percent: ArrayLike) -> Array:
        """Points (…,2) [m] at shares (…) of the trajectory [%]."""
        shares = np.linspace(0.0, 100.0, len(self.corners))
        x, y = np.transpose(self.corners)
        percent = np.asarray(percent, dtype=float)
        return np.stack([np.interp(percent, shares, x), np.interp(percent, shares, y)], axis=-1)


A = Trajectory("A", ((-1.0, 2.0), (1.0, 2.0), (1.0, 4.0), (-1.0, 4.0), (-1.0, 2.0)))
"""Table 3.2: a square."""
B = Trajectory("B", ((-2.0, 1.0), (2.5, 1.0), (2.5, 2.0), (-2.0, 2.0), (-2.0, 1.0)))
"""Table 3.3: a rectangle that leaves the workspace."""
C = Trajectory("C", ((-0.5, 2.5), (1.5, 3.0), (1.5, 1.5), (-0.5, 2.5)))
"""Figure 4.15: a triangle. The thesis draws it and gives no numbers; these are ours."""


ARM = "hassantabar3r"
SAMPLES = 161
"""Points of a trajectory: one each 0.625 %, so the corners are among them."""
COLOURS = {
    "joint 1": "tab:red",
    "joint 2": "tab:blue",
    "joint 3": "tab:green",
    TURNING_POINT: "black",
}
"""Colours of the borders, by what ends the region there."""


@dataclass(frozen=True)
class Region:
    """Feasible intervals along a trajectory."""

    trajectory: Trajectory
    percent: Array
    """(N,) share of the trajectory [%]."""
    intervals: list[list[list[FeasibleInterval]]]
    """Intervals of each point, of each joint."""

    def bounds(self, joint: int) -> tuple[Array, Array]:
        """Lower and upper bound (N,) of a joint (from 0) [rad], NaN where infeasible."""
        found = [at[joint] for at in self.intervals]
        lower = np.array([parts[0].lower if parts else np.nan for parts in found])
        return lower, np.array([parts[-1].upper if parts else np.nan for parts in found])

    def components(self) -> int:
        """The most intervals of joint 1 at a point."""
        return max(len(at[0]) for at in self.intervals)


@cache
def region(trajectory: Trajectory) -> Region:
    """The region of the thesis's arm along a trajectory, by tracing each point's self-motion."""
    percent = np.linspace(0.0, 100.0, SAMPLES)
    tracer = SelfMotionTracer(load_arm(ARM), "xy")
    motions = [tracer.trace(point) for point in trajectory.at(percent)]
    intervals = [[motion.intervals(joint) for joint in range(3)] for motion in motions]
    return Region(trajectory, percent, intervals)


def plot_region(axes: Axes, found: Region, joint: int, arm: DhArm) -> None:
    """Draw the region of a joint; the colour of a border tells which limit ends it."""
    lower, upper = found.bounds(joint)
    axes.fill_between(found.percent, lower, upper, color="0.8")
    for side, bound in (("lower_end", lower), ("upper_end", upper)):
        ends = [getattr(at[joint][0], side) if at[0] else "" for at in found.intervals]
        for name, colour in COLOURS.items():
            chosen = [end.startswith(name) for end in ends]
            axes.plot(found.percent, np.where(chosen, bound, np.nan), ".", color=colour, ms=3)
    infeasible = np.isnan(lower)
    axes.fill_between(
        found.percent,
        0,
        1,
        where=infeasible.tolist(),
        color="0.45",
        transform=axes.get_xaxis_transform(),
    )
    for limit in (arm.lower[joint], arm.upper[joint]):
        axes.axhline(limit, color="black", ls="--", lw=0.8)
    axes.set_ylabel(f"θ{joint + 1} [rad]")
    axes.grid(alpha=0.3)


def plot_regions(found: Region) -> Figure:
    """The regions of the three joints, one above the other."""
    arm = load_arm(ARM)
    figure = Figure(figsize=(9, 8), layout="constrained")
    rows = figure.subplots(3, 1, sharex=True)
    for joint, axes in enumerate(rows):
        plot_region(axes, found, joint, arm)
    rows[-1].set_xlabel(f"share of trajectory {found.trajectory.name} [%]")
    handles = [
        *(
            Line2D([], [], color=colour, marker=".", ls="", label=name)
            for name, colour in COLOURS.items()
        ),
        Line2D([], [], color="black", ls="--", lw=0.8, label="limits"),
        Line2D([], [], color="0.8", lw=6, label="feasible"),
        Line2D([], [], color="0.45", lw=6, label="infeasible"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=7, frameon=False)
    return figure


def stretches(percent: Array, mask: Bools) -> str:
    """The stretches of a trajectory where a mask is true, as text [%]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    runs = zip(percent[edges[::2]], percent[edges[1::2] - 1])
    return ", ".join(f"{low:.2f}-{high:.2f}" for low, high in runs)
