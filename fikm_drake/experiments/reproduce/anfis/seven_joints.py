"""An arm without a closed form: the longest self-motion of an iiwa14, learned from traces.

The tool points down. How far the joints can move along a self-motion without leaving their limits, the arc
length of its longest component, tells how much freedom a posture there leaves. Tracing takes a good
part of a second a pose; a map of the workspace takes thousands of poses.
"""

import time
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.samples import rms_and_max
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import find_model
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer

ARM = "iiwa14"
LOWER, UPPER = (0.45, 0.15), (0.70, 0.60)
"""x and z of the tool [m]; y = 0."""
SIDE = 18
"""Training points: a square of this many by as many."""
FILE = "iiwa14_freedom"
FRESH, SEED = 40, 1
"""Poses to test on."""
MAP = 200
"""Side of the map that ANFIS draws."""
RMS = 0.02
"""Claimed error over fresh poses [rad]."""


def longest_self_motion(tracer: SelfMotionTracer, x: float, z: float) -> float:
    """Arc length of the longest component [rad] with the tool at (x, 0, z) [m], pointing down."""
    target = np.diag([1.0, -1.0, -1.0, 1.0])
    target[:3, 3] = x, 0.0, z
    return max((component.length for component in tracer.trace(target).components), default=0.0)


def traced(points: Array, progress: Callable[[float], None] | None = None) -> Array:
    """Arc lengths (N,) [rad] at points (N,2): x and z [m]."""
    tracer = SelfMotionTracer(load_arm(ARM), "pose")
    lengths = np.empty(len(points))
    for i, (x, z) in enumerate(points.tolist()):
        lengths[i] = longest_self_motion(tracer, x, z)
        if progress:
            progress((i + 1) / len(points))
    return lengths


def train_freedom(progress: Callable[[float], None] | None = None) -> Anfis:
    """Trace the training points and learn from them; a minute or two."""
    ticks = [np.linspace(low, high, SIDE) for low, high in zip(LOWER, UPPER)]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 2)
    anfis = Anfis((6, 6), names=("x", "z", "longest_self_motion"))
    lengths = traced(points, progress)
    return anfis.fit(points, lengths, method="variable_projection", ridge=1e-9)


def load_freedom() -> Anfis:
    """The ANFIS that comes with the library, written by `fikm-drake train freedom`."""
    return Anfis.load(find_model(FILE, folder="learned", kind="learned model"))


def freedom() -> Section:
    """An arm without a closed form: error over fresh poses, and speed against tracing."""
    anfis = load_freedom()
    fresh = np.random.default_rng(SEED).uniform(LOWER, UPPER, (FRESH, 2))
    start = time.process_time()
    wanted = traced(fresh)
    tracing = (time.process_time() - start) / FRESH
    error = anfis.predict(fresh) - wanted
    ticks = [np.linspace(low, high, MAP) for low, high in zip(LOWER, UPPER)]
    grid = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 2)
    start = time.process_time()
    lengths = anfis.predict(grid)
    predicting = (time.process_time() - start) / len(grid)
    rms, largest = rms_and_max(error)
    cells = [
        Cell(f"rms error, {FRESH} fresh poses [rad]", None, rms, rms <= RMS),
        Cell("largest error [rad]", None, largest),
        Cell("longest self-motion there, from [rad]", None, float(wanted.min())),
        Cell("to [rad]", None, float(wanted.max())),
        Cell("CPU time of tracing a pose [ms]", None, 1e3 * tracing),
        Cell(f"of ANFIS, {len(grid)} poses at once [ms]", None, 1e3 * predicting),
        Cell("times faster", None, tracing / predicting, tracing >= 1000.0 * predicting),
    ]
    notes = [
        f"{ARM}, tool down, x {LOWER[0]:g}-{UPPER[0]:g} m, z {LOWER[1]:g}-{UPPER[1]:g} m, seed {SEED};",
        f"learned from {SIDE**2} traced poses by `fikm-drake train freedom`.",
    ]
    return Section(
        "freedom",
        "a 7-joint arm without closed form: how far its joints can move with the tool held",
        cells,
        notes,
        {"freedom": _map(ticks, lengths)},
    )


def _map(ticks: list[Array], lengths: Array) -> Figure:
    figure = Figure(figsize=(4.6, 6), layout="constrained")
    axes = figure.subplots()
    filled = axes.contourf(*ticks, lengths.reshape(MAP, MAP).T, levels=20)
    figure.colorbar(filled, ax=axes, label="longest self-motion [rad]")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")
    axes.set_aspect("equal")
    return figure
