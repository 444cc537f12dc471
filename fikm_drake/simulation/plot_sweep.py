"""A picture of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fikm_drake.files import new_figure, save_figure
from fikm_drake.simulation.sweep_runs import Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_sweep(sweep: Sweep, path: str | Path | None = None, *, value: str = "e_max") -> Figure:
    """Draw a sweep: a heat map over its first two options, and error against motion of all runs.

    With one option the left picture is a line, with none a bar a run.

    Args:
        sweep: the sweep.
        path: where to write the picture; None: nowhere.
        value: the column of the left picture, such as `e_max` [m].

    Raises:
        KeyError: there is no such column.
        OSError: the file cannot be written.
        ValueError: matplotlib does not know the file's type.
    """
    figure = new_figure(11, 4.8)
    left, right = figure.subplots(1, 2)
    options = sweep.option_names
    values = np.array(sweep.column(value), dtype=float)
    if len(options) >= 2:
        _heat_map(figure, left, sweep, options[:2], values)
        left.set_title(f"{value}{'' if len(options) == 2 else ', least over the others'}")
    elif options:
        left.plot(_positions(sweep.column(options[0])), values, "o-")
        left.set_xlabel(options[0])
        left.set_ylabel(value)
    else:
        left.bar([row.name for row in sweep.rows], values)
        left.tick_params(axis="x", rotation=45)
        left.set_ylabel(value)
    right.plot(sweep.column("travel"), 100 * np.array(sweep.column("e_mean")), "o")
    for row in sweep.rows if len(sweep) <= 30 else []:
        if np.isfinite(row.travel):
            right.annotate(row.name, (row.travel, 100 * row.e_mean), fontsize=7)
    right.set_xlabel("way of all joints [rad or m]")
    right.set_ylabel("mean error [cm]")
    right.grid(alpha=0.3)
    right.set_title("error against motion")
    if path is not None:
        save_figure(figure, path)
    return figure


def _heat_map(
    figure: Figure, axes: Axes, sweep: Sweep, options: list[str], values: np.ndarray
) -> None:
    ticks = [list(dict.fromkeys(map(str, sweep.column(name)))) for name in options]
    table = np.full((len(ticks[1]), len(ticks[0])), np.nan)
    for x, y, found in zip(*(sweep.column(name) for name in options), values):
        place = ticks[1].index(str(y)), ticks[0].index(str(x))
        table[place] = np.nanmin([table[place], found]) if np.isfinite(found) else table[place]
    image = axes.imshow(table, origin="lower", aspect="auto", cmap="viridis")
    axes.set_xticks(range(len(ticks[0])), [text[:12] for text in ticks[0]], rotation=45)
    axes.set_yticks(range(len(ticks[1])), [text[:12] for text in ticks[1]])
    axes.set_xlabel(options[0])
    axes.set_ylabel(options[1])
    figure.colorbar(image, ax=axes)


def _positions(values: list) -> list:
    """Numbers as they are, anything else by its text."""
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    return values if numbers else [str(v) for v in values]
