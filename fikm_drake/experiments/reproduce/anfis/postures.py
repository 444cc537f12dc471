"""Figures 3.7, 3.8 and 3.12: the arm along its self-motion at one point."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.region import ARM, A, B, Trajectory
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.self_motion.trace_self_motion import trace_self_motion

POSTURES = 4
NEAR = 0.02
"""A joint this near to a limit is told as being at it [rad]."""


def figure_3_7() -> Section:
    """Trajectory A at 79 %."""
    return _section("figure 3.7", A, 79.0, ("θ3", "θ1 and θ2"))


def figure_3_8() -> Section:
    """Trajectory A at 10 %."""
    note = [
        "Neither end is singular: the last links are not in line, though at the upper end within 0.06",
        "rad of it. The thesis walks along a fixed vector u, whose projection nearly vanishes where the",
        "self-motion is nearly at right angles to u; such a walk stalls, and looks like a singularity.",
    ]
    return _section("figure 3.8", A, 10.0, ("singularity", "θ2"), note)


def figure_3_12() -> Section:
    """Trajectory B at 20 %."""
    return _section("figure 3.12", B, 20.0, ("θ1", "singularity"))


def _section(
    key: str,
    trajectory: Trajectory,
    percent: float,
    paper: tuple[str, str],
    notes: list[str] | None = None,
) -> Section:
    arm, point = load_arm(ARM), trajectory.at(percent)
    component = trace_self_motion(arm, point, "xy").components[0]
    ends = component.q[[0, -1]]
    low, high = ends if ends[0, 0] < ends[1, 0] else ends[::-1]
    reached = arm.forward_kinematics(component.q)[:, :2, 3] - point
    residual = float(np.abs(reached).max())
    cells = [
        Cell("ends θ1 below", paper[0], _at_limits(arm, low)),
        Cell("ends θ1 above", paper[1], _at_limits(arm, high)),
        Cell("posture at the lower end [rad]", None, _text(low)),
        Cell("posture at the upper end [rad]", None, _text(high)),
        Cell("length of the self-motion [rad]", None, component.length),
        Cell("tool off its point on the way, at most [m]", None, residual, residual <= 1e-11),
    ]
    figure = Figure(figsize=(11, 3.4), layout="constrained")
    for axes, length in zip(
        figure.subplots(1, POSTURES, sharey=True), np.linspace(0.0, component.length, POSTURES)
    ):
        _draw(axes, arm, component.at(min(float(length), component.length)), trajectory)
    figure.suptitle(f"self-motion at {percent:g} % of trajectory {trajectory.name}")
    title = f"the arm at {percent:g} % of trajectory {trajectory.name}"
    return Section(
        key, title, cells, notes or [], {key.replace(" ", "_").replace(".", "_"): figure}
    )


def _at_limits(arm: DhArm, q: Array) -> str:
    """The limits that a posture is at or near."""
    names = [
        f"θ{j + 1} {side}"
        for j in range(3)
        for side, limit in (("lower", arm.lower[j]), ("upper", arm.upper[j]))
        if abs(q[j] - limit) < NEAR
    ]
    return " and ".join(names)


def _text(q: Array) -> str:
    return " ".join(f"{x:.4f}" for x in q)


def _draw(axes: Axes, arm: DhArm, q: Array, trajectory: Trajectory) -> None:
    joints = np.vstack([arm.link_poses(q)[:, :2, 3], arm.forward_kinematics(q)[None, :2, 3]])
    axes.plot(*np.transpose(trajectory.corners), "k--", lw=0.8)
    axes.plot(joints[:, 0], joints[:, 1], "-o", color="tab:orange", lw=3, mfc="white")
    axes.plot(*joints[-1], "ks", ms=5)
    axes.set_title("θ = " + ", ".join(f"{x:.2f}" for x in q), fontsize=9)
    axes.set_xlabel("x [m]")
    axes.set_aspect("equal")
    axes.set_xlim(-2.6, 3.0)
    axes.set_ylim(-0.3, 4.4)
    axes.grid(alpha=0.3)
