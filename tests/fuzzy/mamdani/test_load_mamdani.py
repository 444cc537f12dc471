"""Mamdani systems as YAML files."""

import pytest

from fikm_drake.fuzzy.mamdani import MamdaniSystem, load_mamdani
from fikm_drake.resources import model_names

GOOD = """
name: one
inputs:
- {name: x, lower: 0.0, upper: 1.0, memberships: {A: {left: 0.0, peak: 0.0, right: 1.0}}}
outputs:
- {name: z, lower: 0.0, upper: 1.0, memberships: {B: !Gaussian {mean: 0.5, sigma: 0.1}}}
rules:
- {when: {x: A}, then: {z: B}}
"""


def test_a_saved_system_comes_back(make_config, tmp_path):
    system = MamdaniSystem(make_config(aggregation="sum", samples=77))
    system.save(tmp_path / "example.yaml")
    again = load_mamdani(tmp_path / "example.yaml")
    assert again.config == system.config
    assert again.grid("angle") == system.grid("angle")
    assert (again([0.3, 0.2]).values == system([0.3, 0.2]).values).all()


@pytest.mark.parametrize("name", model_names("fuzzy"))
def test_ours_load(name):
    assert load_mamdani(name).config.name == name


def test_defaults_of_a_file(tmp_path):
    path = tmp_path / "good.yaml"
    path.write_text(GOOD)
    config = load_mamdani(path).config
    assert (config.norm, config.aggregation, config.defuzzification) == (
        "minimum",
        "maximum",
        "centroid",
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (", right: 1.0", "", "membership 'A': Triangle: right must be a finite number, got nan"),
        ("!Gaussian", "!Bell", "Bell"),
        ("mean: 0.5", "centre: 0.5", "centre"),
        ("mean: 0.5", "mean: middle", "middle"),
        (
            "upper: 1.0, memberships: {A",
            "memberships: {A",
            "upper must be a finite number, got nan",
        ),
        ("then: {z: B}", "then: {z: C}", "rule 1, then: 'z' has no label 'C'; there are: B"),
        ("name: one", "nome: one", "nome"),
        ("rules:", "rules: [", "not a valid fuzzy system file"),
        ("{name: x, ", "{", "a variable needs a name"),
    ],
)
def test_refuses_and_names_the_file(tmp_path, old, new, message):
    path = tmp_path / "bad.yaml"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(ValueError, match=rf"(?s)bad\.yaml.*{message}|{message}.*bad\.yaml"):
        load_mamdani(path)


def test_there_is_no_such_file():
    with pytest.raises(FileNotFoundError, match="no fuzzy system 'nothing'; .* labvolt_theta3"):
        load_mamdani("nothing")
