"""The thesis's further work: which structure of an ANFIS learns the bounds best, on held-out points."""

from functools import cache

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fikm_drake.experiments.reproduce.anfis.region import ARM
from fikm_drake.experiments.reproduce.anfis.samples import (
    exact,
    fresh_points,
    fresh_values,
    training_points,
    validation_points,
)
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.anfis.structure_search import Structure, search_structures
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs

MEMBERSHIPS, EPOCHS = (4, 6, 8, 10), 25
QUANTITY = "upper"
"""Upper bound of joint 1: the hardest of the three."""
THESIS = "8 x 8 gaussian, order 1"


@cache
def found(inputs: str) -> list[Structure]:
    """All structures, the best by the validation points first; inputs `xy` or `polar`."""
    arm = load_arm(ARM)
    scaled = BoundsInputs(arm, "xy", inputs)
    data, held = training_points(), validation_points()
    return search_structures(
        (scaled(data), exact(data)[QUANTITY]),
        (scaled(held), exact(held)[QUANTITY]),
        (scaled(fresh_points()), fresh_values()[QUANTITY]),
        memberships=MEMBERSHIPS,
        epochs=EPOCHS,
    )


def structures() -> Section:
    """Memberships, kinds and orders compared on points that nothing was learned or chosen from."""
    cells, figure = [], Figure(figsize=(10, 4), layout="constrained")
    for axes, inputs in zip(figure.subplots(1, 2, sharey=True), ("xy", "polar")):
        results = found(inputs)
        for structure in results:
            text = f"{1e3 * structure.held_out:.2f} / {1e3 * structure.held_out_largest:.1f}"
            text += f", {structure.numbers} numbers, {structure.seconds:.1f} s"
            cells.append(Cell(f"{inputs}, {structure}", None, text))
        thesis = next(s for s in results if str(s) == THESIS)
        ratio = results[0].held_out / thesis.held_out
        label = f"{inputs}: held-out rms of the best, over the thesis's structure's [-]"
        cells.append(Cell(label, None, ratio, ratio <= 1.0))
        _draw(axes, results, inputs)
    notes = [
        "Held-out rms / largest error [mrad], numbers to store, CPU time. Sorted by the validation points,",
        f"which chose epoch and structure; {len(fresh_points())} held-out points told. {EPOCHS} epochs of",
        "variable projection each, upper bound of joint 1. The thesis: 8 x 8 Gaussian, order 1, of xy.",
        "Your own data: `fikm-drake train structures DATA.csv`.",
    ]
    return Section(
        "structures", "structures of the ANFIS compared", cells, notes, {"anfis_structures": figure}
    )


def _draw(axes: Axes, results: list[Structure], inputs: str) -> None:
    groups = sorted({(s.anfis.kind, s.anfis.order) for s in results})
    for kind, order in groups:
        own = sorted(
            (s for s in results if (s.anfis.kind, s.anfis.order) == (kind, order)),
            key=lambda s: s.numbers,
        )
        x, y = [s.numbers for s in own], [1e3 * s.held_out for s in own]
        axes.loglog(x, y, "o-", label=f"{kind}, order {order}")
    axes.set_title(f"inputs: {inputs}")
    axes.set_xlabel("numbers to store")
    axes.set_ylabel("held-out rms error [mrad]")
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8)
