"""Pictures of fuzzy variables and of what a Mamdani system infers."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani.mamdani_system import MamdaniSystem

POINTS = 501
"""Along the range of a variable."""


def plot_memberships(source: FuzzyVariable | MamdaniSystem) -> Figure:
    """Draw the memberships of a variable, or those of all variables of a system.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.
    """
    if isinstance(source, FuzzyVariable):
        variables = [source]
    else:
        variables = [*source.config.inputs, *source.config.outputs]
    figure = Figure(figsize=(8, 0.6 + 2.0 * len(variables)), layout="constrained")
    FigureCanvasAgg(figure)
    for row, variable in enumerate(variables, start=1):
        _plot_variable(figure.add_subplot(len(variables), 1, row), variable)
    return figure


def plot_surface(
    system: MamdaniSystem,
    output: str | None = None,
    *,
    resolution: int = 101,
    fixed: dict[str, float] | None = None,
) -> Figure:
    """Draw an output over two inputs as a map; where no rule fires it is hatched.

    Args:
        system: a system of two inputs or more.
        output: name of an output; None: the only one there is.
        resolution: points along each input.
        fixed: value of each input that is not on an axis, by name.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.

    Raises:
        ValueError: there is no such output or input, not two inputs are left, or the resolution is
            under 2.
    """
    if resolution < 2:
        raise ValueError(f"resolution must be at least 2, got {resolution}")
    config, fixed = system.config, fixed or {}
    variable = config.output(output)
    names = [v.name for v in config.inputs]
    free = [v for v in config.inputs if v.name not in fixed]
    if not set(fixed) <= set(names) or len(free) != 2:
        raise ValueError(f"fixed must leave two of the inputs {', '.join(names)}, got {fixed}")

    across, up = (np.linspace(v.lower, v.upper, resolution) for v in free)
    grid = dict(zip((v.name for v in free), np.meshgrid(across, up)))
    points = [grid.get(name, np.full((resolution, resolution), fixed.get(name))) for name in names]
    values, fired = system(np.stack(points, axis=-1))
    column = config.outputs.index(variable)

    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    picture = axes.pcolormesh(across, up, values[..., column], shading="nearest", cmap="viridis")
    holes = ~fired[..., column]
    if holes.any():
        axes.contourf(across, up, holes, levels=[0.5, 1.5], colors="none", hatches=["////"])
        axes.set_title("hatched: no rule fires", fontsize=10)
    figure.colorbar(picture, label=variable.axis)
    axes.set_xlabel(free[0].axis)
    axes.set_ylabel(free[1].axis)
    return figure


def _plot_variable(axes: Axes, variable: FuzzyVariable) -> None:
    x = np.linspace(variable.lower, variable.upper, POINTS)
    cores = [shape.core for shape in variable.memberships.values()]
    x = np.union1d(x, np.clip(cores, variable.lower, variable.upper))
    for label, grades in zip(variable.labels, variable.grades(x).T):
        (line,) = axes.plot(x, grades)
        core = np.clip(variable.memberships[label].core, variable.lower, variable.upper)
        axes.annotate(
            label,
            (core.mean(), 1.0),
            xytext=(0, 3),
            textcoords="offset points",
            ha=_alignment(core.mean(), variable),
            color=line.get_color(),
        )
    axes.set_xlim(variable.lower, variable.upper)
    axes.set_ylim(0.0, 1.18)
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.set_xlabel(variable.axis)
    axes.set_ylabel("grade [-]")
    axes.grid(alpha=0.3)


def _alignment(x: float, variable: FuzzyVariable) -> str:
    """Of a label at x, so that it stays inside the axes."""
    return {variable.lower: "left", variable.upper: "right"}.get(x, "center")
