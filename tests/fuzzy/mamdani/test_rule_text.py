"""Rules to read; Table 1 of Elsharif et al."""

import dataclasses

import pytest

from fikm_drake.fuzzy.mamdani import MamdaniSystem, load_mamdani


def test_rules_read_as_sentences(make_config):
    rules = MamdaniSystem(make_config()).rules()
    assert rules[0] == "IF x is near AND y is low THEN angle is down, speed is slow"
    assert rules[3:] == [
        "IF x is far THEN angle is level",
        "IF x is mid AND y is not low THEN angle is up",
        "IF x is far OR y is high THEN speed is slow",
    ]


def test_table(make_config):
    lines = MamdaniSystem(make_config()).table().splitlines()
    assert lines[0].split() == ["rule", "x", "y", "angle", "speed"]
    assert lines[1].split() == ["1", "near", "low", "down", "slow"]
    assert lines[6].split() == ["6", "(or)", "far", "high", "slow"]
    assert len(set(map(len, lines))) == 1


def test_grid(make_config):
    system = MamdaniSystem(make_config())
    rows = [line.split() for line in system.grid("angle").splitlines()]
    assert rows == [
        ["x", "\\", "y", "low", "high"],
        ["near", "down", "up"],
        ["mid", "level", "up"],
        ["far", "level", "level"],
    ]
    speed = [line.split() for line in system.grid("speed").splitlines()]
    assert speed[1:] == [
        ["near", "slow", "fast/slow"],
        ["mid", "fast", "slow"],
        ["far", "slow", "slow"],
    ]


def test_a_grid_needs_two_inputs(make_config):
    config = make_config()
    config.inputs.pop()
    rules = [dataclasses.replace(rule, when={"x": rule.when["x"]}) for rule in config.rules[:2]]
    config.rules = rules
    with pytest.raises(ValueError, match="a grid needs two inputs, got 1"):
        MamdaniSystem(config).grid("angle")


def test_table_1_and_its_holes():
    """Rules 1-9, and the two pairs of labels that the paper leaves out."""
    system = load_mamdani("labvolt_theta3")
    assert [line.split()[1:] for line in system.table().splitlines()[1:]] == [
        ["X1", "Y1", "T1"],
        ["X2", "Y1", "T2"],
        ["X3", "Y1", "T3"],
        ["X1", "Y2", "T1"],
        ["X2", "Y2", "T3"],
        ["X3", "Y2", "T5"],
        ["X2", "Y3", "T6"],
        ["X3", "Y3", "T5b"],
        ["X4", "not", "Y1", "T7"],
    ]
    assert system.holes() == [{"x": "X1", "y": "Y3"}, {"x": "X4", "y": "Y1"}]
    rows = [line.split()[1:] for line in system.grid().splitlines()[1:]]
    assert rows == [["T1", "T1", "-"], ["T2", "T3", "T6"], ["T3", "T5", "T5b"], ["-", "T7", "T7"]]
    # A corner of the plane where X1 and Y3 alone hold.
    assert not system([0.0, 0.76]).fired and system([0.3, 0.2]).fired
