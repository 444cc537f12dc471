"""Mamdani inference against its definition, integrated by brute force on a fine grid."""

import numpy as np
import pytest
from hypothesis import strategies as st

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani import FuzzyRule, MamdaniConfig
from fikm_drake.fuzzy.memberships import Gaussian, Trapezoid, Triangle

FINE = 40_001


def definition(shape, x):
    """A membership by its definition, one value at a time."""
    if isinstance(shape, Gaussian):
        return np.exp(-((x - shape.mean) ** 2) / (2 * shape.sigma**2))
    a, (b, c), d = shape.left, shape.core, shape.right
    parts = [(x >= b) & (x <= c), (x > a) & (x < b), (x > c) & (x < d)]
    return np.select(parts, [1.0, (x - a) / (b - a or 1.0), (d - x) / (d - c or 1.0)], 0.0)


def brute_force(config, point):
    """The outputs of one point, straight from the text books."""
    conjunction = {"minimum": min, "product": lambda a, b: a * b}[config.norm]
    disjunction = {"minimum": max, "product": lambda a, b: a + b - a * b}[config.norm]
    strengths = []
    for rule in config.rules:
        grades = []
        for variable, x in zip(config.inputs, point):
            label = rule.when.get(variable.name)
            if label is None:
                continue
            x = min(max(x, variable.lower), variable.upper)
            grade = float(definition(variable.memberships[label.removeprefix("not ")], x))
            grades.append(1.0 - grade if label.startswith("not ") else grade)
        total = grades[0]
        for grade in grades[1:]:
            total = (conjunction if rule.join == "and" else disjunction)(total, grade)
        strengths.append(total)
    values = []
    for variable in config.outputs:
        y = np.linspace(variable.lower, variable.upper, FINE)
        united, weights, middles = np.zeros(FINE), {}, {}
        for rule, strength in zip(config.rules, strengths):
            if variable.name not in rule.then:
                continue
            label = rule.then[variable.name]
            shape = variable.memberships[label]
            cut = np.minimum if config.implication == "minimum" else np.multiply
            join = np.add if config.aggregation == "sum" else np.maximum
            united = join(united, cut(strength, definition(shape, y)))
            weights[label] = join(weights.get(label, 0.0), strength)
            middles[label] = np.clip(shape.core, variable.lower, variable.upper).mean()
        if config.defuzzification == "height":
            value = sum(weights[k] * middles[k] for k in weights) / sum(weights.values())
        elif config.defuzzification == "centroid":
            value = np.trapezoid(y * united, y) / np.trapezoid(united, y)
        else:
            value = y[united >= united.max() - 1e-12].mean()
        values.append(value)
    return values


@pytest.fixture
def config():
    first = FuzzyVariable(
        "x",
        "m",
        0.0,
        1.0,
        {
            "near": Trapezoid(0.0, 0.0, 0.2, 0.5),
            "mid": Triangle(0.2, 0.5, 0.9),
            "far": Gaussian(0.9, 0.15),
        },
    )
    second = FuzzyVariable(
        "y", "m", -1.0, 1.0, {"low": Triangle(-1.5, -1.0, 0.5), "high": Triangle(-0.4, 1.0, 1.0)}
    )
    angle = FuzzyVariable(
        "angle",
        "deg",
        -90.0,
        90.0,
        {
            "down": Trapezoid(-120.0, -100.0, -60.0, -20.0),
            "level": Triangle(-45.0, 3.0, 33.0),
            "up": Triangle(10.0, 70.0, 90.0),
        },
    )
    speed = FuzzyVariable(
        "speed", "m/s", 0.0, 2.0, {"slow": Triangle(0.0, 0.0, 1.3), "fast": Triangle(0.5, 1.6, 2.0)}
    )
    return MamdaniConfig(
        name="example",
        inputs=[first, second],
        outputs=[angle, speed],
        rules=[
            FuzzyRule({"x": "near", "y": "low"}, {"angle": "down", "speed": "slow"}),
            FuzzyRule({"x": "mid", "y": "low"}, {"angle": "level", "speed": "fast"}),
            FuzzyRule({"x": "near", "y": "high"}, {"angle": "up", "speed": "fast"}),
            FuzzyRule({"x": "far"}, {"angle": "level"}),
            FuzzyRule({"x": "mid", "y": "not low"}, {"angle": "up"}),
            FuzzyRule({"x": "far", "y": "high"}, {"speed": "slow"}, join="or"),
        ],
    )


def choices():
    return st.fixed_dictionaries(
        {
            "norm": st.sampled_from(["minimum", "product"]),
            "implication": st.sampled_from(["minimum", "product"]),
            "aggregation": st.sampled_from(["maximum", "sum"]),
            "defuzzification": st.sampled_from(["centroid", "mean_of_maximum", "height"]),
        }
    )
