"""Mamdani inference against its definition, by brute force on a fine grid."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fikm_drake.fuzzy.mamdani import MamdaniSystem
from fikm_drake.fuzzy.memberships import Gaussian

FINE = 18_000
"""Cells of the range of an output; the vertical edge of the example is between two of them."""
points = st.tuples(st.floats(-0.2, 1.2), st.floats(-1.3, 1.3))
choices = st.fixed_dictionaries(
    {
        "norm": st.sampled_from(["minimum", "product"]),
        "implication": st.sampled_from(["minimum", "product"]),
        "aggregation": st.sampled_from(["maximum", "sum"]),
    }
)


def definition(shape, x):
    """A membership by its definition."""
    if isinstance(shape, Gaussian):
        return np.exp(-((x - shape.mean) ** 2) / (2 * shape.sigma**2))
    a, (b, c), d = shape.left, shape.core, shape.right
    parts = [(x >= b) & (x <= c), (x > a) & (x < b), (x > c) & (x < d)]
    return np.select(parts, [1.0, (x - a) / (b - a or 1.0), (d - x) / (d - c or 1.0)], 0.0)


def strengths_by_definition(config, point):
    """How strongly each rule fires."""
    conjunction = {"minimum": min, "product": lambda a, b: a * b}[config.norm]
    disjunction = {"minimum": max, "product": lambda a, b: a + b - a * b}[config.norm]
    strengths = []
    for rule in config.rules:
        grades = []
        for variable, x in zip(config.inputs, point):
            if variable.name in rule.when:
                label = rule.when[variable.name]
                x = min(max(x, variable.lower), variable.upper)
                grade = float(definition(variable.memberships[label.removeprefix("not ")], x))
                grades.append(1.0 - grade if label.startswith("not ") else grade)
        total = grades[0]
        for grade in grades[1:]:
            total = (conjunction if rule.join == "and" else disjunction)(total, grade)
        strengths.append(total)
    return strengths


def aggregate_by_definition(config, variable, strengths):
    """The united membership of an output in the middles of fine cells: places and heights."""
    y = variable.lower + (variable.upper - variable.lower) * (np.arange(FINE) + 0.5) / FINE
    united = np.zeros(FINE)
    for rule, strength in zip(config.rules, strengths):
        if variable.name in rule.then:
            shape = variable.memberships[rule.then[variable.name]]
            cut = np.minimum if config.implication == "minimum" else np.multiply
            join = np.add if config.aggregation == "sum" else np.maximum
            united = join(united, cut(strength, definition(shape, y)))
    return y, united


def height_by_definition(config, variable, strengths):
    """The mean of the middles of the cores, weighted by how strongly each label is concluded on."""
    weights, middles = {}, {}
    for rule, strength in zip(config.rules, strengths):
        if variable.name in rule.then:
            label = rule.then[variable.name]
            join = np.add if config.aggregation == "sum" else np.maximum
            weights[label] = join(weights.get(label, 0.0), strength)
            core = np.clip(variable.memberships[label].core, variable.lower, variable.upper)
            middles[label] = core.mean()
    return sum(weights[k] * middles[k] for k in weights) / sum(weights.values())


@given(choices, points)
def test_strengths(make_config, choices, point):
    config = make_config(**choices)
    expected = strengths_by_definition(config, point)
    np.testing.assert_allclose(MamdaniSystem(config).strengths(point), expected, atol=1e-12)


@given(choices, points)
def test_centroid(make_config, choices, point):
    config = make_config(defuzzification="centroid", **choices)
    values, fired = MamdaniSystem(config)(point)
    strengths = strengths_by_definition(config, point)
    # A sum is exact, so the error is that of the brute force; a maximum is sampled.
    tolerance = 1e-6 if config.aggregation == "sum" else 3e-4
    for variable, value in zip(config.outputs, values):
        y, united = aggregate_by_definition(config, variable, strengths)
        expected = (y * united).sum() / united.sum()
        assert value == pytest.approx(expected, abs=tolerance * (variable.upper - variable.lower))
    assert fired.all()


@given(choices, points)
def test_mean_of_maximum(make_config, choices, point):
    config = make_config(defuzzification="mean_of_maximum", **choices)
    values, _ = MamdaniSystem(config)(point)
    strengths = strengths_by_definition(config, point)
    for variable, value in zip(config.outputs, values):
        y, united = aggregate_by_definition(config, variable, strengths)
        tops = [y[united >= (1.0 - near) * united.max()] for near in (1e-12, 1e-3)]
        # Where two tops are nearly of one height a rounding error decides between them.
        assume(tops[1].max() - tops[1].min() < tops[0].max() - tops[0].min() + 0.2)
        tolerance = 3e-3 * (variable.upper - variable.lower)
        assert value == pytest.approx(tops[0].mean(), abs=tolerance)


@settings(max_examples=40)
@given(choices, points)
def test_first_and_last_of_maximum(make_config, choices, point):
    for k, method in enumerate(("smallest_of_maximum", "largest_of_maximum")):
        config = make_config(defuzzification=method, **choices)
        values, _ = MamdaniSystem(config)(point)
        strengths = strengths_by_definition(config, point)
        for variable, value in zip(config.outputs, values):
            y, united = aggregate_by_definition(config, variable, strengths)
            tops = [y[united >= (1.0 - near) * united.max()][-k] for near in (1e-12, 1e-3)]
            assume(abs(tops[1] - tops[0]) < 0.1 * (variable.upper - variable.lower))
            tolerance = 3e-3 * (variable.upper - variable.lower)
            assert value == pytest.approx(tops[0], abs=tolerance)


@settings(max_examples=40)
@given(choices, points)
def test_bisector(make_config, choices, point):
    config = make_config(defuzzification="bisector", **choices)
    values, _ = MamdaniSystem(config)(point)
    strengths = strengths_by_definition(config, point)
    for variable, value in zip(config.outputs, values):
        y, united = aggregate_by_definition(config, variable, strengths)
        left = united[y < value].sum() / united.sum()
        assert left == pytest.approx(0.5, abs=1e-3)


@given(choices, points)
def test_height(make_config, choices, point):
    config = make_config(defuzzification="height", **choices)
    strengths = strengths_by_definition(config, point)
    expected = [height_by_definition(config, v, strengths) for v in config.outputs]
    np.testing.assert_allclose(MamdaniSystem(config)(point).values, expected, atol=1e-12)


@pytest.mark.parametrize("norm", ["minimum", "product"])
def test_error_of_the_samples(make_config, norm):
    """The centroid of a maximum: a few ten-thousandths of the range, less with more samples."""
    rng = np.random.default_rng(0)
    x = rng.uniform([0.0, -1.0], [1.0, 1.0], (2000, 2))
    exact = MamdaniSystem(make_config(norm=norm, samples=20_001))(x).values
    width = np.array([180.0, 2.0])
    errors = [
        np.abs(MamdaniSystem(make_config(norm=norm, samples=samples))(x).values - exact) / width
        for samples in (51, 201, 801)
    ]
    assert np.max(errors[1]) < 2e-4
    assert np.median(errors[1]) < 2e-5
    assert np.max(errors[2]) < np.max(errors[1]) / 3.0 < np.max(errors[0]) / 9.0
