"""A small system with everything in it."""

import pytest

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani import FuzzyRule, MamdaniConfig
from fikm_drake.fuzzy.memberships import Gaussian, Trapezoid, Triangle


@pytest.fixture(scope="session")
def make_config():
    """Makes a new config of all choices."""
    return example


def example(**choices):
    """Two inputs, two outputs, all shapes, partial rules, `not`, `or`; a rule fires everywhere."""
    x = FuzzyVariable(
        name="x",
        unit="m",
        lower=0.0,
        upper=1.0,
        memberships={
            "near": Trapezoid(0.0, 0.0, 0.2, 0.5),
            "mid": Triangle(0.2, 0.5, 0.9),
            "far": Gaussian(0.9, 0.15),
        },
    )
    y = FuzzyVariable(
        name="y",
        unit="m",
        lower=-1.0,
        upper=1.0,
        memberships={"low": Triangle(-1.5, -1.0, 0.5), "high": Triangle(-0.4, 1.0, 1.0)},
    )
    angle = FuzzyVariable(
        name="angle",
        unit="deg",
        lower=-90.0,
        upper=90.0,
        memberships={
            "down": Trapezoid(-120.0, -100.0, -60.0, -20.0),
            "level": Triangle(-45.0, 3.0, 33.0),
            "up": Trapezoid(10.0, 70.0, 80.0, 80.0),
        },
    )
    speed = FuzzyVariable(
        name="speed",
        unit="m/s",
        lower=0.0,
        upper=2.0,
        memberships={"slow": Triangle(0.0, 0.0, 1.3), "fast": Triangle(0.5, 1.6, 2.0)},
    )
    rules = [
        FuzzyRule({"x": "near", "y": "low"}, {"angle": "down", "speed": "slow"}),
        FuzzyRule({"x": "mid", "y": "low"}, {"angle": "level", "speed": "fast"}),
        FuzzyRule({"x": "near", "y": "high"}, {"angle": "up", "speed": "fast"}),
        FuzzyRule({"x": "far"}, {"angle": "level"}),
        FuzzyRule({"x": "mid", "y": "not low"}, {"angle": "up"}),
        FuzzyRule({"x": "far", "y": "high"}, {"speed": "slow"}, join="or"),
    ]
    return MamdaniConfig("example", [x, y], [angle, speed], rules, **choices)
