"""Position error over the workplane: labels, AND, rounding, least squares; integers beside floating point."""

from itertools import product

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.integer import interpolate
from fikm_drake.fuzzy.integer.integer_partition import ROUNDINGS
from fikm_drake.fuzzy.integer.integer_rule_base import CONJUNCTIONS, Conjunction
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk, tojo_inverse
from fikm_drake.solvers.workplane.workplane import Workplane
from fikm_drake.solvers.workplane.workplane_inverse import WorkplaneInverse

CLAIMS = {"min": (7.5, 3.3), "product": (2.2, 0.85)}
"""Largest and mean error with 9 x 9 labels [mm]."""
LEAST_RATIO = {"min": 1.9, "product": 3.8}
"""By which the mean error falls when the cells are halved: order h and h²."""
GRIDS = (3, 5, 9, 17, 33)
"""Labels of x and of y; each has half the cells' width of the one before."""
INTEGER_CLAIM = 0.5
"""Largest distance that integers move the tool with 9 x 9 labels [mm]."""
ARMS = {
    "panda": (0.0, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8),
    "iiwa14": (0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0),
    "puma560": (0.0, 0.5, -2.5, 0.0, 0.5, 0.0),
}
"""Other arms, and where every point is searched for from [rad]."""
WORKPLANE = Workplane(origin=[0.35, 0.2, 0.15], yaw=-np.pi / 2, size=[400, 300])
"""In front of those arms."""


def errors() -> Section:
    """Position error over 401 x 301 points."""
    inverse = tojo_inverse()
    cells = [Cell("exact inverse: error, max [mm]", None, _exact(inverse))]
    for size, conjunction in product((3, 9, 33), CONJUNCTIONS):
        ik = IntegerFuzzyIk(labels=(size, size), conjunction=conjunction)
        distance, height = grid_errors(ik, inverse)
        label = f"{size} x {size}, {conjunction}"
        claim = CLAIMS[conjunction] if size == 9 else None
        cells += _max_and_mean(label, distance, claim)
        cells.append(Cell(f"{label}: height over the workplane, max [mm]", None, _largest(height)))
    for conjunction in CONJUNCTIONS:
        ik = IntegerFuzzyIk(labels=(9, 9), conjunction=conjunction, rounding="nearest")
        cells += _max_and_mean(f"9 x 9, {conjunction}, rounded", grid_errors(ik, inverse)[0])
        ik = IntegerFuzzyIk(labels=(9, 9), conjunction=conjunction, least_squares=True)
        distance = grid_errors(ik, inverse)[0]
        cells += _max_and_mean(
            f"9 x 9, {conjunction}, least squares", distance, CLAIMS[conjunction]
        )
    notes = [
        "Error: distance in the plane of the workplane; the paper gives none. Cut off as in the paper unless",
        "it says rounded.",
    ]
    return Section(
        "errors",
        "position error at every whole millimetre",
        cells,
        notes,
        {"integer_error_maps": _maps(inverse)},
    )


def order() -> Section:
    """How the error falls with the width of the cells, in floating point."""
    inverse = tojo_inverse()
    points = inverse.workplane.grid().reshape(-1, 2)
    cells = []
    for conjunction in CONJUNCTIONS:
        found = [_float_errors(inverse, size, conjunction, points) for size in GRIDS]
        for coarse, fine, a, b in zip(GRIDS, GRIDS[1:], found, found[1:]):
            label = f"{conjunction}, {coarse} to {fine} labels"
            ratio = float(a.mean() / b.mean())
            reached = ratio >= LEAST_RATIO[conjunction]
            cells.append(Cell(f"{label}: mean error falls by [-]", None, ratio, reached))
            largest = _largest(a) / _largest(b)
            cells.append(Cell(f"{label}: largest error falls by [-]", None, largest))
    notes = [
        f"Order h for min (claimed: at least {LEAST_RATIO['min']}), h² for product (at least "
        f"{LEAST_RATIO['product']}), of the mean.",
        "The largest error sits in the far right corner, where the arm is most stretched: there the",
        "product comes to h² only from 17 labels on.",
    ]
    return Section("order", "error against the width of the cells", cells, notes)


def integers() -> Section:
    """How far integers move the tool from where floating point puts it, 9 x 9 labels."""
    inverse = tojo_inverse()
    points = inverse.workplane.grid()
    cells = []
    for conjunction, rounding in product(CONJUNCTIONS, ROUNDINGS):
        ik = IntegerFuzzyIk(labels=(9, 9), conjunction=conjunction, rounding=rounding)
        q = _float_inference(inverse, 9, conjunction, points.reshape(-1, 2))
        ours = inverse.reached(ik.to_radians(ik.solve_batch(points)[0])).reshape(-1, 3)
        moved = np.linalg.norm(ours - inverse.reached(q), axis=-1)
        label = f"{conjunction}, {rounding}: integers move the tool by"
        largest = _largest(moved)
        cells.append(Cell(f"{label}, max [mm]", None, largest, largest <= INTEGER_CLAIM))
        cells.append(Cell(f"{label}, mean [mm]", None, float(moved.mean())))
    notes = [f"Steps of 0.01°, grades to 255; claimed: at most {INTEGER_CLAIM} mm."]
    return Section("integers", "integers beside floating point, 9 x 9 labels", cells, notes)


def arms() -> Section:
    """Any arm: rules from `solve_batch`, every 10 mm of a workplane."""
    cells = []
    for name, start in ARMS.items():
        inverse = WorkplaneInverse(load_arm(name), WORKPLANE, start)
        for conjunction in CONJUNCTIONS:
            ik = IntegerFuzzyIk(inverse, labels=(9, 9), conjunction=conjunction)
            label = f"{name}, {ik.num_joints} joints, {conjunction}"
            cells += _max_and_mean(label, grid_errors(ik, inverse, every=10)[0])
    return Section("arms", "other arms, 9 x 9 labels", cells)


def _exact(inverse: WorkplaneInverse) -> float:
    points = inverse.workplane.grid()
    return _largest(np.hypot(*workplane_errors(inverse, points, inverse(points))))


def _float_inference(
    inverse: WorkplaneInverse, size: int, conjunction: Conjunction, points: ArrayLike
) -> Array:
    rules = inverse.singletons((size, size), conjunction, least_squares=False)
    return interpolate(*rules, points, conjunction)


def _float_errors(
    inverse: WorkplaneInverse, size: int, conjunction: Conjunction, points: ArrayLike
) -> Array:
    return workplane_errors(inverse, points, _float_inference(inverse, size, conjunction, points))[
        0
    ]


def _max_and_mean(
    label: str, distance: Array, claim: tuple[float, float] | None = None
) -> list[Cell]:
    values = {"max": _largest(distance), "mean": float(distance.mean())}
    if claim is None:
        return [Cell(f"{label}: error, {name} [mm]", None, v) for name, v in values.items()]
    return [
        Cell(f"{label}: error, {name} [mm], at most {most:g}", None, value, value <= most)
        for (name, value), most in zip(values.items(), claim)
    ]


def _largest(values: Array) -> float:
    return float(np.abs(values).max())


def _maps(inverse: WorkplaneInverse) -> Figure:
    """Error over the workplane, 3 x 3 and 9 x 9 labels, min and product."""
    figure = Figure(figsize=(11, 7.5), layout="constrained")
    rows = figure.subplots(2, 2, sharex=True, sharey=True)
    width, depth = inverse.workplane.size
    for axes_row, size in zip(rows, (3, 9)):
        found = []
        for conjunction in CONJUNCTIONS:
            ik = IntegerFuzzyIk(labels=(size, size), conjunction=conjunction)
            found.append(grid_errors(ik, inverse)[0])
        top = max(map(_largest, found))
        for axes, conjunction, distance in zip(axes_row, CONJUNCTIONS, found):
            image = axes.imshow(
                distance.T, origin="lower", extent=(0, width, 0, depth), vmin=0, vmax=top
            )
            axes.set_title(
                f"{size} x {size}, {conjunction}: max {_largest(distance):.1f}, "
                f"mean {distance.mean():.2f} mm",
                fontsize=10,
            )
        figure.colorbar(image, ax=axes_row, label="error [mm]")
    for axes in rows[-1]:
        axes.set_xlabel("x [mm]")
    for axes in rows[:, 0]:
        axes.set_ylabel("y [mm]")
    return figure


def workplane_errors(inverse: WorkplaneInverse, points: ArrayLike, q: Array) -> tuple[Array, Array]:
    """Distance in the workplane's plane and height over it of the tool.

    Args:
        inverse: of the arm at its workplane.
        points: wanted points (…,2) [mm].
        q: joint positions (…,n) [rad].

    Returns:
        Distances (…) and heights (…) [mm].
    """
    reached = inverse.reached(q)
    return np.linalg.norm(reached[..., :2] - np.asarray(points), axis=-1), reached[..., 2]


def grid_errors(
    ik: IntegerFuzzyIk, inverse: WorkplaneInverse, *, every: int = 1
) -> tuple[Array, Array]:
    """`workplane_errors` on the whole workplane at every whole millimetre, or every so many."""
    points = inverse.workplane.grid(every)
    return workplane_errors(inverse, points, ik.to_radians(ik.solve_batch(points)[0]))
