"""A page where sliders move the inputs of a fuzzy system."""

from __future__ import annotations

import json
from collections.abc import Callable
from html import escape
from pathlib import Path
from string import Template

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.files import write_whole
from fikm_drake.fuzzy.teaching.explanation import Explanation, FuzzyView, ViewedVariable
from fikm_drake.fuzzy.teaching.fuzzy_view import fuzzy_view

STEPS = {1: 101, 2: 33, 3: 11}
"""Steps of each slider by how many there are: all combinations are computed beforehand."""
CURVE = 101
"""Points of a membership."""

Drawing = Callable[[Array, Array], Array]
"""Inputs (N,d) and outputs (N,k) to the corners of a line (N,p,2), such as an arm; NaN: nothing."""


def write_rules_page(
    system: object,
    path: str | Path,
    *,
    title: str = "",
    drawing: Drawing | None = None,
    caption: str = "",
    steps: int | None = None,
) -> None:
    """Write a page, one file without a network, where sliders move the inputs of a fuzzy system.

    It shows the memberships, how strongly each rule fires, the united conclusions, the outputs, for two
    inputs a map to click on, and a drawing such as an arm. All numbers are computed here, at the steps of
    the sliders.

        ik = fd.IntegerFuzzyIk(labels=(5, 5))
        draw = fd.arm_drawing(fd.load_arm("tojo4dof"), lambda x, angles: ik.to_radians(angles))
        fd.write_rules_page(ik, "rules.html", drawing=draw)

    Args:
        system: what `fuzzy_view` takes, of at most three inputs.
        path: of the file.
        title: its heading; by default what the system prints as.
        drawing: inputs (N,d) and outputs (N,k), NaN where no rule fires, to a line's corners (N,p,2).
        caption: over the drawing.
        steps: of each slider; by default 101 for one, 33 for two and 11 for three.

    Raises:
        ValueError: naming the bad value and the valid ones.
        OSError: the file cannot be written.
    """
    view = fuzzy_view(system)
    if len(view.inputs) not in STEPS:
        raise ValueError(f"a page has at most 3 inputs, got {len(view.inputs)}")
    count = STEPS[len(view.inputs)] if steps is None else steps
    check_counts(2, steps=count)
    axes = [_slider(variable, count) for variable in view.inputs]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    values = view.values(points)
    told = [view.explain(point) for point in points]
    data = {
        "inputs": [_input(variable, axis) for variable, axis in zip(view.inputs, axes)],
        "outputs": [_output(view, k, told[0]) for k in range(len(view.outputs))],
        "rules": [escape(rule.text) for rule in told[0].rules],
        "strengths": [_sparse([rule.strength for rule in one.rules]) for one in told],
        "values": [[_number(x) for x in row] for row in values],
        **_conclusions(view, told),
    }
    if drawing is not None:
        data["drawing"] = _drawing(np.asarray(drawing(points, values), dtype=float), caption)
    template = Path(__file__).with_name("templates") / "rules_page.html"
    # No "</script>" inside the script, whatever a label is.
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False).replace("</", "<\\/")
    heading = escape(title or repr(system).strip("<>"))
    page = Template(template.read_text("utf-8")).substitute(title=heading, data=text)
    write_whole(path, page)


def _slider(variable: ViewedVariable, count: int) -> Array:
    even = np.linspace(variable.lower, variable.upper, count)
    return np.unique(variable.step * np.rint(even / variable.step)) if variable.step else even


def _input(variable: ViewedVariable, values: Array) -> dict[str, object]:
    assert variable.grades is not None
    curve = np.union1d(np.linspace(variable.lower, variable.upper, CURVE), variable.tops)
    table = variable.grades(curve).T
    memberships = [
        {"label": escape(label), "grades": _short(grades), "top": float(curve[grades.argmax()])}
        for label, grades in zip(variable.labels, table)
    ]
    return {
        **_ends(variable),
        "values": [_number(value) for value in values],
        "start": 2 * len(values) // 5,
        "curve": _short(curve),
        "memberships": memberships,
    }


def _output(view: FuzzyView, k: int, told: Explanation) -> dict[str, object]:
    return {**_ends(view.outputs[k]), "span": [] if told.span is None else _short(told.span)}


def _ends(variable: ViewedVariable) -> dict[str, object]:
    return {"axis": escape(variable.axis), "lower": variable.lower, "upper": variable.upper}


def _conclusions(view: FuzzyView, told: list[Explanation]) -> dict[str, object]:
    """Memberships or numbers of the rules, where they are the same at every point."""
    first = told[0]
    if first.span is not None:
        said = [_short(np.asarray(rule.conclusion)) for rule in first.rules]
        return {"conclusions": said, "cuts_off": first.cuts_off, "adds": first.adds}
    if any(rule.conclusion != now.conclusion for rule, now in zip(first.rules, told[-1].rules)):
        return {}  # those of an ANFIS move
    return {"numbers": [float(np.asarray(rule.conclusion)) for rule in first.rules]}


def _sparse(strengths: list[float]) -> list[list[float]]:
    return [[k, round(strength, 4)] for k, strength in enumerate(strengths) if strength > 5e-5]


def _drawing(lines: Array, caption: str) -> dict[str, object]:
    if lines.ndim != 3 or lines.shape[-1] != 2:
        raise ValueError(f"drawing must give corners (N, p, 2), got shape {lines.shape}")
    shown = np.asarray(np.isfinite(lines).all(axis=(1, 2)))
    if not shown.any():
        raise ValueError("drawing must give a finite line somewhere, all are NaN")
    found = lines[shown]
    return {
        "caption": escape(caption),
        "low": found.min(axis=(0, 1)).tolist(),
        "high": found.max(axis=(0, 1)).tolist(),
        "lines": [_short(line) if good else None for line, good in zip(lines, shown)],
    }


def _number(x: float) -> float | None:
    return float(f"{x:.6g}") if np.isfinite(x) else None


def _short(values: Array) -> list:
    """Numbers with as many digits as a picture shows."""
    array = np.asarray(values, dtype=float)
    digits = 4 - int(np.floor(np.log10(max(np.abs(array).max(initial=0.0), 1e-12))))
    return np.round(array, digits).tolist()
