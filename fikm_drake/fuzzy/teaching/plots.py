"""Pictures of memberships, and of an output over the inputs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.files import new_figure
from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.teaching.explanation import FuzzyView, ViewedVariable
from fikm_drake.fuzzy.teaching.fuzzy_view import fuzzy_view, viewed
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 501
"""Along the range of a variable."""
ROOM = 25
"""Labels that have room over an axis; of more, only some are written."""


def plot_memberships(source: FuzzyVariable | TriangularPartition | object) -> Figure:
    """Draw the memberships of a variable or partition, or those of all variables of a system.

        fd.plot_memberships(fd.FuzzyRateControl()).savefig("memberships.png")

    Args:
        source: a variable, a partition, or what `fuzzy_view` takes.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.

    Raises:
        ValueError: it is something else.
    """
    if isinstance(source, FuzzyVariable | TriangularPartition):
        variables = [viewed(source)]
    else:
        view = fuzzy_view(source)
        variables = [v for v in (*view.inputs, *view.outputs) if v.grades is not None]
    figure = new_figure(8, 0.6 + 2.0 * len(variables))
    for row, variable in enumerate(variables, start=1):
        axes = figure.add_subplot(len(variables), 1, row)
        _plot_variable(axes, variable)
    return figure


def plot_surface(
    system: object,
    output: str | None = None,
    *,
    resolution: int = 101,
    fixed: dict[str, float] | None = None,
) -> Figure:
    """Draw an output over two inputs as a map, or over one as a curve.

    Where no rule fires the map is hatched and the curve has a gap.

        fd.plot_surface(fd.load_mamdani("labvolt_theta3"))
        fd.plot_surface(fd.load_mamdani("labvolt_theta3"), fixed={"y": 0.1})

    Args:
        system: what `fuzzy_view` takes.
        output: name of an output; None: the only one there is.
        resolution: points along each input.
        fixed: value of each input that is not on an axis, by name.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.

    Raises:
        ValueError: there is no such output or input, not one or two inputs are left, or the resolution
            is under 2.
    """
    if resolution < 2:
        raise ValueError(f"resolution must be at least 2, got {resolution}")
    view, fixed = fuzzy_view(system), fixed or {}
    column = output_number(view, output)
    names = [v.name for v in view.inputs]
    free = [v for v in view.inputs if v.name not in fixed]
    if not set(fixed) <= set(names) or len(free) not in (1, 2):
        raise ValueError(
            f"fixed must leave one or two of the inputs {', '.join(names)}, got {fixed}"
        )
    figure = new_figure(6.4, 5.2 if len(free) == 2 else 3.6)
    axes = figure.add_subplot()
    axes.set_xlabel(free[0].axis)
    along = [_even(variable, resolution) for variable in free]
    grid = dict(zip((v.name for v in free), np.meshgrid(*along)))
    size = next(iter(grid.values())).shape
    points = [grid.get(name, np.full(size, fixed.get(name, np.nan))) for name in names]
    values = view.values(np.stack(points, axis=-1))[..., column]
    variable = view.outputs[column]
    holes = np.isnan(values)
    note = ", ".join(f"{name} = {value:.4g}" for name, value in fixed.items())
    if len(free) == 1:
        axes.plot(along[0], values, drawstyle="steps-post" if free[0].step else "default")
        axes.set_ylabel(variable.axis)
        axes.grid(alpha=0.3)
        note += ("; " if note else "") + "gap: no rule fires" if holes.any() else ""
    else:
        picture = axes.pcolormesh(*along, values, shading="nearest", cmap="viridis")
        axes.set_ylabel(free[1].axis)
        if holes.any():
            axes.contourf(*along, holes, levels=[0.5, 1.5], colors="none", hatches=["////"])
            note += ("; " if note else "") + "hatched: no rule fires"
        figure.colorbar(picture, label=variable.axis)
    axes.set_title(note, fontsize=10)
    return figure


def output_number(view: FuzzyView, output: str | None) -> int:
    """The number of the output of that name; None: the only one there is.

    Raises:
        ValueError: there is none, or there are several and no name.
    """
    names = [variable.name for variable in view.outputs]
    found = [k for k, name in enumerate(names) if output in (None, name)]
    if len(found) != 1:
        raise ValueError(f"output must be one of: {', '.join(names)}, got {output!r}")
    return found[0]


def _plot_variable(axes: Axes, variable: ViewedVariable) -> None:
    assert variable.grades is not None
    x = _even(variable, POINTS)
    table = variable.grades(x)
    every = -(-len(variable.labels) // ROOM)
    for k, (label, grades) in enumerate(zip(variable.labels, table.T)):
        (line,) = axes.plot(x, grades)
        top = x[grades >= grades.max() - 1e-9]
        middle = 0.5 * (top[0] + top[-1])
        if k % every == 0:
            axes.annotate(
                label,
                (middle, grades.max()),
                xytext=(0, 3),
                textcoords="offset points",
                ha=_alignment(middle, variable),
                color=line.get_color(),
            )
    axes.set_xlim(variable.lower, variable.upper)
    axes.set_ylim(0.0, 1.18)
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.set_xlabel(variable.axis)
    axes.set_ylabel("grade [-]")
    axes.grid(alpha=0.3)


def _even(variable: ViewedVariable, count: int) -> Array:
    """Values along a range, with the tops of memberships between them."""
    x = np.linspace(variable.lower, variable.upper, count)
    if variable.step:
        return np.unique(variable.step * np.rint(x / variable.step))
    return np.union1d(x, variable.tops) if count == POINTS else x


def _alignment(x: float, variable: ViewedVariable) -> str:
    """Alignment of a label at x, so that it stays inside the axes."""
    edge = 0.01 * (variable.upper - variable.lower)
    if x < variable.lower + edge:
        return "left"
    return "right" if x > variable.upper - edge else "center"
