"""An arm without a closed form: the longest self-motion of an iiwa14, learned from traces.

The tool points down. How far the joints can move along a self-motion without leaving their limits, the arc
length of its longest component, tells how much freedom a posture there leaves. Tracing takes a good
part of a second a pose; a map of the workspace takes thousands of poses.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import find_model
from fikm_drake.solvers.regions.trace_self_motion import SelfMotionTracer

Array = NDArray[np.float64]
ARM = "iiwa14"
LOWER, UPPER = (0.45, 0.15), (0.70, 0.60)
"""x and z of the tool [m]; y = 0."""
SIDE = 18
"""Training points: a square of this many by as many."""
FILE = "iiwa14_freedom"


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
