"""Rules as text."""

import dataclasses

import pytest

from fikm_drake.fuzzy.mamdani import MamdaniSystem, load_mamdani, parse_rules
from fikm_drake.resources import model_names


@pytest.mark.parametrize("name", model_names("fuzzy"))
def test_our_systems_read_back_from_their_text(name):
    system = load_mamdani(name)
    assert parse_rules("\n".join(system.rules()), system.config) == system.config.rules


def test_every_form_reads_back(make_config):
    system = MamdaniSystem(make_config())
    rules = parse_rules("\n".join(system.rules()), system.config)
    assert rules == system.config.rules
    again = MamdaniSystem(dataclasses.replace(system.config, rules=rules))
    assert again([0.45, 0.2]).values.tolist() == system([0.45, 0.2]).values.tolist()


def test_comments_case_and_spaces():
    text = """
        # brakes
        if distance is very near and speed is not low then brake is hard  # now!

        IF distance is far THEN brake is soft, horn is off
    """
    first, second = parse_rules(text)
    assert first.when == {"distance": "very near", "speed": "not low"} and first.join == "and"
    assert first.then == {"brake": "hard"}
    assert second.then == {"brake": "soft", "horn": "off"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\nIF x is nera THEN angle is up", "line 2, .*: 'x' has no label 'nera'; there are: near"),
        ("IF w is near THEN angle is up", "no variable 'w'; there are: x, y"),
        ("IF x is near THEN angle is high", "'angle' has no label 'high'; there are: down, level"),
        ("IF x is near THEN angle is not up", "a conclusion cannot be 'not up'"),
        ("IF x is near AND y is low OR y is high THEN angle is up", "`and` and `or` in one rule"),
        ("IF x is near AND x is far THEN angle is up", "'x' stands twice"),
        ("x near: angle up", "must read as 'IF x is A"),
        ("IF x near THEN angle is up", "'x near' must read as 'x is A'"),
        ("# nothing", "the text has no rule"),
    ],
)
def test_errors_name_the_line_and_the_label(make_config, text, message):
    with pytest.raises(ValueError, match=message):
        parse_rules(text, make_config())
