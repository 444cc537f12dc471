"""The rule viewer: which rules fire how strongly at a point, what each says, what comes of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.checks import check_counts
from fikm_drake.files import new_figure
from fikm_drake.fuzzy.teaching.explanation import Explanation, ViewedRule, ViewedVariable
from fikm_drake.fuzzy.teaching.fuzzy_view import fuzzy_view
from fikm_drake.fuzzy.teaching.plots import output_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INPUT, OUTPUT, VALUE = "tab:blue", "tab:orange", "tab:red"
POINTS = 301


def plot_rules(
    system: object, point: ArrayLike, output: str | None = None, *, most: int = 6
) -> Figure:
    """Draw the rules that fire at a point, a row each, the strongest first, and the result below.

    A row shows the membership of each input in the rule's premise with the grade of the input, then what
    the rule says: its conclusion cut off or scaled, or its number as a line as high as the rule fires. The
    last row shows the united conclusions, or all numbers with their weights, and the output.

        fd.plot_rules(fd.load_mamdani("labvolt_theta3"), [0.4, 0.1]).savefig("rules.png")
        fd.plot_rules(fd.GainSupervision(num_rows=3, num_joints=7), [1.2, 4.0])

    Args:
        system: what `fuzzy_view` takes.
        point: one number an input, in its unit.
        output: name of an output; None: the only one there is.
        most: rules that are drawn; the last row is of all.

    Returns:
        The matplotlib figure; pyplot is not touched, so nothing has to be closed.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    check_counts(most=most)
    view = fuzzy_view(system)
    told = view.explain(np.asarray(point, dtype=float), output_number(view, output))
    shown = told.strongest(most)
    rows, columns = len(shown) + 1, len(view.inputs) + 1
    figure = new_figure(0.8 + 2.6 * columns, 1.0 + 1.35 * rows)
    grid = figure.subplots(rows, columns, squeeze=False)
    for row, rule in enumerate(shown):
        for axes, variable in zip(grid[row], view.inputs):
            _draw_premise(axes, variable, rule, told.point[variable.name])
        _draw_conclusion(grid[row][-1], told, rule)
        grid[row][0].set_ylabel(f"{rule.strength:.3f}", rotation=0, ha="right", va="center")
        if row + 1 < len(shown):
            for axes in grid[row]:
                axes.set_xticklabels([])
    for axes, variable in zip(grid[-1], view.inputs):
        axes.axis("off")
        value = f"{variable.axis} = {told.point[variable.name]:.4g}"
        axes.text(0.5, 0.5, value, ha="center", va="center", color=INPUT, transform=axes.transAxes)
    _draw_result(grid[-1][-1], told)
    firing = len(told.strongest())
    title = f"{firing} of {len(told.rules)} rules fire"
    title += f", the strongest {len(shown)} shown" if firing > len(shown) else ""
    figure.suptitle(f"{title}; strengths on the left", fontsize=10)
    return figure


def _draw_premise(axes: Axes, variable: ViewedVariable, rule: ViewedRule, value: float) -> None:
    _frame(axes, variable)
    if variable.name not in rule.when:
        axes.text(0.5, 0.5, "(any)", ha="center", va="center", transform=axes.transAxes)
        return
    label, negated = rule.when[variable.name]
    assert variable.grades is not None
    inside = float(np.clip(value, variable.lower, variable.upper))
    line = np.linspace(variable.lower, variable.upper, POINTS)
    x = np.union1d(line, [*variable.tops, inside])
    grades = variable.grades(x)[:, variable.labels.index(label)]
    grades = 1.0 - grades if negated else grades
    grade = grades[np.searchsorted(x, inside)]
    axes.plot(x, grades, color=INPUT)
    axes.fill_between(x, np.minimum(grades, grade), color=INPUT, alpha=0.25, linewidth=0)
    axes.plot([inside, inside], [0.0, grade], color=VALUE)
    axes.plot([inside], [grade], "o", color=VALUE, markersize=4)
    text = f"{variable.name} is {'not ' if negated else ''}{label}: {grade:.3f}"
    axes.set_title(text, fontsize=8, pad=2)


def _draw_conclusion(axes: Axes, told: Explanation, rule: ViewedRule) -> None:
    _frame_output(axes, told)
    said = rule.text.rpartition(" THEN ")[2]
    axes.set_title(said if len(said) < 42 else said[:40] + " …", fontsize=8, pad=2)
    if rule.said is not None and told.span is not None:
        axes.plot(told.span, rule.conclusion, color=OUTPUT, linewidth=0.8)
        axes.fill_between(told.span, rule.said, color=OUTPUT, alpha=0.5, linewidth=0)
    else:
        _stem(axes, float(np.asarray(rule.conclusion)), rule.strength)


def _draw_result(axes: Axes, told: Explanation) -> None:
    _frame_output(axes, told)
    if told.span is not None and told.united is not None:
        axes.fill_between(told.span, told.united, color=OUTPUT, alpha=0.5, linewidth=0)
        axes.set_ylim(0.0, max(1.08, 1.05 * float(told.united.max())))
    else:
        for rule in told.strongest():
            _stem(axes, float(np.asarray(rule.conclusion)), rule.strength)
    axes.axvline(told.value, color=VALUE)
    how = told.method if told.fired else "no rule fires: default"
    axes.set_title(f"{how}: {told.value:.4g}", fontsize=8, pad=2, color=VALUE)
    axes.set_xlabel(told.output.axis, fontsize=8)


def _stem(axes: Axes, number: float, strength: float) -> None:
    axes.plot([number, number], [0.0, strength], color=OUTPUT, linewidth=3, solid_capstyle="butt")
    axes.plot([number], [strength], "o", color=OUTPUT, markersize=4)


def _frame_output(axes: Axes, told: Explanation) -> None:
    """The output's range, and the numbers of the rules that fire, which may be outside."""
    _frame(axes, told.output)
    if told.span is None:
        numbers = [float(np.asarray(rule.conclusion)) for rule in told.strongest()]
        least, most = min([*numbers, told.output.lower]), max([*numbers, told.output.upper])
        margin = 0.03 * (most - least)
        axes.set_xlim(least - margin, most + margin)


def _frame(axes: Axes, variable: ViewedVariable) -> None:
    axes.set_xlim(variable.lower, variable.upper)
    axes.set_ylim(0.0, 1.08)
    axes.set_yticks([0.0, 1.0])
    axes.locator_params(axis="x", nbins=4)
    axes.tick_params(labelsize=7)
