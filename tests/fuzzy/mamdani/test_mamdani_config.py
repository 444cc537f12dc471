"""Mamdani systems as data."""

import dataclasses

import pytest

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani import FuzzyRule, MamdaniSystem
from fikm_drake.fuzzy.memberships import Triangle


def extra_rule(*arguments, **options):
    return lambda config: config.rules.append(FuzzyRule(*arguments, **options))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda config: config.inputs.clear(), "needs at least one input"),
        (lambda config: config.outputs.clear(), "needs at least one output"),
        (lambda config: config.rules.clear(), "needs at least one rule"),
        (
            lambda config: config.outputs.pop(),
            r"rule 1, then: no variable 'speed'; there are: angle",
        ),
        (lambda config: setattr(config, "norm", "min"), r"norm must be one of .* got 'min'"),
        (
            lambda config: setattr(config, "implication", ""),
            r"implication must be one of .* got ''",
        ),
        (lambda config: setattr(config, "aggregation", "max"), "aggregation must be one of"),
        (lambda config: setattr(config, "defuzzification", "mom"), "got 'mom'"),
        (
            lambda config: setattr(config, "samples", 1),
            "samples must be an integer of at least 2, got 1",
        ),
        (lambda config: setattr(config, "samples", 9.5), "at least 2, got 9.5"),
        (
            lambda config: setattr(config.inputs[1], "name", "x"),
            r"names of variables must differ from one another, got \['x', 'x', 'angle', 'speed'\]",
        ),
        (
            lambda config: config.inputs[0].memberships.update(deg=Triangle(0.0, 45.0, 90.0)),
            "variable 'x': membership 'deg' must reach grade 1",
        ),
        (
            extra_rule({"x": "close"}, {"angle": "up"}),
            "rule 7, when: 'x' has no label 'close'; there are: near, mid, far",
        ),
        (
            extra_rule({"z": "near"}, {"angle": "up"}),
            "rule 7, when: no variable 'z'; there are: x, y",
        ),
        (
            extra_rule({"x": "near"}, {"angle": "not up"}),
            "rule 7, then: 'angle' has no label 'not up'",
        ),
        (extra_rule({}, {"angle": "up"}), "rule 7, when: needs at least one of: x, y"),
        (extra_rule({"x": "near"}, {}), "rule 7, then: needs at least one of: angle, speed"),
        (
            extra_rule({"x": "near"}, {"angle": "up"}, "xor"),
            r"rule 7: join must be one of \('and', 'or'\), got 'xor'",
        ),
        (extra_rule({"x": "far"}, {"angle": "level"}), "rule 7 is the same as an earlier one"),
        (
            lambda config: config.outputs.append(
                FuzzyVariable("idle", "", 0.0, 1.0, {"on": Triangle(0.0, 0.5, 1.0)})
            ),
            "no rule concludes on output 'idle'",
        ),
    ],
)
def test_refuses(make_config, change, message):
    config = make_config()
    change(config)
    with pytest.raises(ValueError, match=message):
        MamdaniSystem(config)


def test_holes(make_config):
    config = make_config()
    assert config.holes("angle") == config.holes("speed") == []
    config.rules.pop()
    assert config.holes("speed") == [
        {"x": "mid", "y": "high"},
        {"x": "far", "y": "low"},
        {"x": "far", "y": "high"},
    ]
    config.rules = [
        FuzzyRule({"x": "near", "y": "not low"}, {"angle": "up"}),
        FuzzyRule({"x": "far", "y": "high"}, {"angle": "level"}, join="or"),
    ]
    assert config.holes("angle") == [{"x": "near", "y": "low"}, {"x": "mid", "y": "low"}]
    assert len(config.holes("speed")) == 6


def test_an_output_is_named_where_there_are_several(make_config):
    system = MamdaniSystem(make_config())
    for method in (system.holes, system.grid):
        with pytest.raises(ValueError, match="output must be one of: angle, speed, got None"):
            method()
        with pytest.raises(ValueError, match="output must be one of: angle, speed, got 'torque'"):
            method("torque")


def test_a_rule_that_is_replaced(make_config):
    rule = make_config().rules[0]
    assert dataclasses.replace(rule, join="or").holds({"x": "near", "y": "high"})
    assert not rule.holds({"x": "near", "y": "high"})
