"""What an author of a bad file is told: the line, the word, what would be right."""

import pytest

import fikm_drake as fd

GOOD = "robot: planar4\ntarget: {positions: [[1.2, 0.4]], duration: 1}\n"
BAD = {
    "top": (GOOD + "contoller: frmrc\n", ["line 3", "'contoller'", "did you mean 'controller'?"]),
    "target": (GOOD.replace("positions", "position"), ["line 2", "'positions'", "Path has"]),
    "law": (
        GOOD + "controller: {config: {law: !FuzzyMapping {iteration: 3}}}\n",
        ["line 3", "'iteration'", "did you mean 'iterations'?", "FuzzyMapping has method"],
    ),
    "deep": (
        GOOD + "controller:\n  config:\n    supervisor: {gain: [1]}\n",
        ["line 5", "'gain'", "did you mean 'gains'?", "GainSupervisorConfig has"],
    ),
    "list": (
        GOOD + "obstacles:\n- {xyz: [0, 0, 0], radious: 1}\n",
        ["line 4", "'radious'", "'radius'", "Obstacle has xyz"],
    ),
    "tag": (GOOD + "plant: !TorqueDriven {bandwith: 3}\n", ["line 3", "'bandwidth'"]),
    "no near one": (GOOD + "sensor: {qqq: 1}\n", ["'qqq'; Sensor has noise, delay"]),
    "unknown tag": (GOOD + "controller: !Magic {}\n", ["'Magic'", "(Fuzzy, Frmrc"]),
    "number": (GOOD + "control_rate: fast\n", ["line 3", "control_rate", "'fast'"]),
    "whole number": (GOOD + "seed: x1\n", ["line 3", "seed", "'x1'"]),
    "list of numbers": (
        GOOD + "initial_position: zero\n",
        ["line 3", "initial_position", "'zero'"],
    ),
    "empty": ("", ["it is empty"]),
    "comment": ("# to do\n", ["it is empty"]),
    "not YAML": ("robot: [\n", ["line 2"]),
}


@pytest.mark.parametrize("name", BAD)
def test_the_message_names_line_word_and_cure(name, tmp_path):
    text, words = BAD[name]
    (tmp_path / "mine.yaml").write_text(text)
    with pytest.raises(ValueError) as error:
        fd.load_scenario(tmp_path / "mine.yaml")
    for word in [*words, "mine.yaml"]:
        assert word in str(error.value)
    assert "<class" not in str(error.value)


def test_the_same_for_an_arm_and_for_fuzzy_rules(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: m\nconvention: craig\njoint: []\n")
    with pytest.raises(ValueError, match="did you mean 'joints'"):
        fd.load_arm(tmp_path / "mine.yaml")
    (tmp_path / "rules.yaml").write_text("name: m\ninput: []\n")
    with pytest.raises(ValueError, match="did you mean 'inputs'"):
        fd.load_mamdani(tmp_path / "rules.yaml")
