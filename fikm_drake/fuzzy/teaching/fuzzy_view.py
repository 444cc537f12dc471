"""Any fuzzy engine in the form that the pictures need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.fuzzy.fuzzy_variable import NOT, FuzzyVariable
from fikm_drake.fuzzy.integer.integer_partition import GRADE, IntegerPartition, Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import IntegerRuleBase
from fikm_drake.fuzzy.mamdani.mamdani_system import MamdaniSystem
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.teaching.explanation import (
    Explanation,
    FuzzyView,
    ViewedRule,
    ViewedVariable,
)
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

SPAN = 401
"""Points over the range of an output."""


def fuzzy_view(system: object) -> FuzzyView:
    """The common form of a fuzzy system.

        view = fd.fuzzy_view(fd.load_mamdani("labvolt_theta3"))
        print(view.explain([0.4, 0.1]))

    Args:
        system: a `MamdaniSystem`, `RuleBase` (generated ones too), `IntegerRuleBase` or trained `Anfis`; or
            what has one of them as `rules`, such as `GainSupervision`, `FuzzyRateControl`, `IntegerFuzzyIk`.

    Raises:
        ValueError: it is something else, or an ANFIS that has learned nothing yet.
    """
    for kind, view in VIEWS.items():
        if isinstance(system, kind):
            return view(system)
    inner = getattr(system, "rules", None)
    if isinstance(inner, tuple(VIEWS)):
        return fuzzy_view(inner)
    known = ", ".join(kind.__name__ for kind in VIEWS)
    raise ValueError(f"must be one of {known}, or have one as `rules`, got {system!r}")


def viewed(source: FuzzyVariable | TriangularPartition) -> ViewedVariable:
    """A variable, or a partition as one named x, as what is drawn."""
    if isinstance(source, TriangularPartition):
        return _of_partition("x", source)
    bounds = source.lower, source.upper
    cores = [end for shape in source.memberships.values() for end in shape.core]
    tops = tuple(np.clip(cores, *bounds).tolist())
    return ViewedVariable(source.name, source.unit, *bounds, source.labels, source.grades, tops)


class MamdaniView:
    """Rules that conclude on memberships."""

    def __init__(self, system: MamdaniSystem) -> None:
        self._system, self._config = system, system.config
        self._texts = system.rules()
        self.inputs = [viewed(variable) for variable in self._config.inputs]
        self.outputs = [viewed(variable) for variable in self._config.outputs]

    def values(self, points: Array) -> Array:
        """See `FuzzyView`."""
        values, fired = self._system(points)
        return np.where(fired, values, np.nan)

    def explain(self, point: ArrayLike, output: int = 0) -> Explanation:
        """See `FuzzyView`."""
        point = _checked(point, self.inputs)
        config = self._config
        variable, name = config.outputs[output], config.outputs[output].name
        corners = [corner for shape in variable.memberships.values() for corner in shape.support]
        ends = np.clip(corners, variable.lower, variable.upper)
        span = np.union1d(np.linspace(variable.lower, variable.upper, SPAN), ends)
        grades = dict(zip(variable.labels, variable.grades(span).T))
        strengths = self._system.strengths(point)
        imply = np.minimum if config.implication == "minimum" else np.multiply
        rules = []
        for rule, strength, text in zip(config.rules, strengths.tolist(), self._texts):
            if name in rule.then:
                shape = grades[rule.then[name]]
                when = {
                    key: (label.removeprefix(NOT), label.startswith(NOT))
                    for key, label in rule.when.items()
                }
                rules.append(ViewedRule(text, when, strength, shape, imply(strength, shape)))
        said = np.array([rule.said for rule in rules])
        united = said.sum(axis=0) if config.aggregation == "sum" else said.max(axis=0)
        values, fired = self._system(point)
        method = config.defuzzification.replace("_", " ")
        told = _explanation(point, self, output, rules, values[output], bool(fired[output]), method)
        cuts_off, adds = config.implication == "minimum", config.aggregation == "sum"
        return replace(told, span=span, united=united, cuts_off=cuts_off, adds=adds)


class SugenoView:
    """Rules that conclude on numbers, one for every pair of memberships."""

    def __init__(self, rules: RuleBase) -> None:
        self._rules = rules
        x, y, z = rules.names
        self.inputs = [_of_partition(x, rules.first), _of_partition(y, rules.second)]
        self.outputs = [_of_numbers(z, rules.consequents)]

    def values(self, points: Array) -> Array:
        """See `FuzzyView`."""
        return self._rules(points[..., 0], points[..., 1])[..., None]

    def explain(self, point: ArrayLike, output: int = 0) -> Explanation:
        """See `FuzzyView`."""
        point = _checked(point, self.inputs)
        base = self._rules
        a, b = base.first.grades(point[0]), base.second.grades(point[1])
        cases = zip(base.rules(), np.ndindex(base.consequents.shape))
        rules = [
            ViewedRule(
                text,
                _pair(self.inputs, i, j),
                float(a[i] * b[j]),
                float(base.consequents[i, j]),
            )
            for text, (i, j) in cases
        ]
        value = base.evaluate(*point.tolist())
        return _explanation(point, self, output, rules, value, True, "weighted average")


class IntegerView:
    """Rules that conclude on integers."""

    def __init__(self, rules: IntegerRuleBase) -> None:
        self._rules = rules
        inputs = zip("xy", (rules.first, rules.second))
        self.inputs = [_of_integers(name, part, rules.rounding) for name, part in inputs]
        outputs = enumerate(np.moveaxis(rules.singletons, -1, 0), start=1)
        self.outputs = [_of_numbers(f"output {k}", table) for k, table in outputs]

    def values(self, points: Array) -> Array:
        """See `FuzzyView`."""
        whole = np.rint(points).astype(np.int64)
        return self._rules.infer_batch(whole[..., 0], whole[..., 1])[0].astype(float)

    def explain(self, point: ArrayLike, output: int = 0) -> Explanation:
        """See `FuzzyView`."""
        point = np.rint(_checked(point, self.inputs))
        base, name = self._rules, self.outputs[output].name
        x, y = (variable for variable in self.inputs)
        a, b = (_of(variable, value) for variable, value in zip((x, y), point))
        rules = []
        for i, j in np.ndindex(base.singletons.shape[:2]):
            strength = min(a[i], b[j]) if base.conjunction == "min" else a[i] * b[j]
            number = float(base.singletons[i, j, output])
            text = f"IF x is {x.labels[i]} AND y is {y.labels[j]} THEN {name} is {number:.0f}"
            rules.append(ViewedRule(text, _pair(self.inputs, i, j), float(strength), number))
        value = base.infer(*map(int, point))[0][output]
        return _explanation(point, self, output, rules, value, True, "weighted average in integers")


class AnfisView:
    """Rules that conclude on linear functions of the inputs."""

    def __init__(self, anfis: Anfis) -> None:
        self._anfis, self._texts = anfis, anfis.rules()
        lower, upper = anfis.input_range
        ranges = zip(anfis.names, lower.tolist(), upper.tolist(), anfis.memberships)
        self.inputs = [
            ViewedVariable(name, "", low, high, _letters(count), self._grades(k))
            for k, (name, low, high, count) in enumerate(ranges)
        ]
        axes = [np.linspace(low, high, 9) for low, high in zip(lower, upper)]
        corners = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        self.outputs = [_of_numbers(anfis.names[-1], anfis.predict(corners))]

    def _grades(self, k: int) -> Callable[[Array], Array]:
        return lambda values: self._anfis.grades(k, values).T

    def values(self, points: Array) -> Array:
        """See `FuzzyView`."""
        flat = points.reshape(-1, len(self.inputs))
        return self._anfis.predict(flat).reshape(*points.shape[:-1], 1)

    def explain(self, point: ArrayLike, output: int = 0) -> Explanation:
        """See `FuzzyView`."""
        point = _checked(point, self.inputs)
        weights, numbers = self._anfis.rules_at(point)
        shape = self._anfis.memberships
        rules = []
        for text, index in zip(self._texts, np.ndindex(*shape)):
            when = {v.name: (v.labels[i], False) for v, i in zip(self.inputs, index)}
            rules.append(ViewedRule(text, when, float(weights[index]), float(numbers[index])))
        value = float(self._anfis.predict(point[None])[0])
        return _explanation(point, self, output, rules, value, True, "weighted average")


VIEWS: dict[type, type] = {
    MamdaniSystem: MamdaniView,
    RuleBase: SugenoView,
    IntegerRuleBase: IntegerView,
    Anfis: AnfisView,
}
"""Engines and their views."""


def _explanation(
    point: Array,
    view: FuzzyView,
    output: int,
    rules: list[ViewedRule],
    value: float,
    fired: bool,
    method: str,
) -> Explanation:
    inputs = {variable.name: float(x) for variable, x in zip(view.inputs, point)}
    variable = view.outputs[output]
    return Explanation(inputs, variable, tuple(rules), float(value), fired, method)


def _checked(point: ArrayLike, inputs: list[ViewedVariable]) -> Array:
    x = np.asarray(point, dtype=float)
    if x.shape != (len(inputs),) or not np.isfinite(x).all():
        axes = ", ".join(variable.axis for variable in inputs)
        raise ValueError(f"point must be {len(inputs)} finite numbers: {axes}; got {point!r}")
    return x


def _pair(inputs: list[ViewedVariable], i: int, j: int) -> dict[str, tuple[str, bool]]:
    first, second = inputs
    return {first.name: (first.labels[i], False), second.name: (second.labels[j], False)}


def _of_partition(name: str, part: TriangularPartition) -> ViewedVariable:
    knots = tuple(part.knots.tolist())
    return ViewedVariable(name, "", knots[0], knots[-1], part.labels, part.grades, knots)


def _of_integers(name: str, part: IntegerPartition, rounding: Rounding) -> ViewedVariable:
    def grades(x: Array) -> Array:
        cell, fall, rise = part.locate_array(np.rint(x).astype(np.int64), rounding)
        table = np.zeros((len(cell), len(part)))
        rows = np.arange(len(cell))
        table[rows, cell], table[rows, cell + 1] = fall / GRADE, rise / GRADE
        return table

    knots = tuple(part.knots.tolist())
    labels = _letters(len(part))
    return ViewedVariable(name, "", part.low, part.high, labels, grades, knots, step=1.0)


def _of_numbers(name: str, numbers: Array) -> ViewedVariable:
    low, high = float(np.min(numbers)), float(np.max(numbers))
    margin = 0.05 * (high - low) or 0.5
    return ViewedVariable(name, "", low - margin, high + margin)


def _of(variable: ViewedVariable, value: float) -> Array:
    assert variable.grades is not None
    return variable.grades(np.array([value]))[0]


def _letters(count: int) -> tuple[str, ...]:
    return TriangularPartition(np.arange(max(count, 2))).labels[:count]
