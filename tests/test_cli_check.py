"""`fikm-drake check`: a robot's file as a controller will see it."""

import json

import pytest

import fikm_drake as fd
from fikm_drake.cli import main


@pytest.fixture
def urdf(tmp_path):
    """Our panda as somebody's file, a speed of zero in it."""
    path = tmp_path / "robot.urdf"
    text = fd.load_arm("panda").to_urdf().replace('velocity="2.175"', 'velocity="0"', 1)
    path.write_text(text)
    return path


def test_the_chain_what_is_odd_and_what_is_reached(urdf, capsys):
    assert main(["check", str(urdf), "--poses", "4"]) == 0
    out = capsys.readouterr().out
    for word in ("7 joints", "joint4", "-3.072", "velocity is 0", "velocity_limits", "of 4 random"):
        assert word in out
    assert "false CONVERGED: 0" in out


def test_joints_base_and_json(urdf, capsys):
    arguments = ["check", str(urdf), "--joints", "joint2", "joint4", "--base", "link1"]
    assert main([*arguments, "--poses", "2", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert [joint["name"] for joint in report["joints"]] == ["joint2", "joint4"]
    assert report["poses"] == 2 and report["microseconds_a_cycle"] > 0
    assert any("2 joints cannot take every pose" in line for line in report["odd"])


def test_our_own_arms_by_name(capsys):
    assert main(["check", "iiwa14", "--poses", "3"]) == 0
    assert "7 joints, reach" in capsys.readouterr().out


@pytest.mark.parametrize(
    "change, arguments, words",
    [
        (("upper=", "upper= "), ["--frame", "hand"], ["'hand'", "panda::tool"]),
        (('lower="-1.7628"', 'lower="9"'), [], ["joint2", "swap"]),
        (("", ""), ["--joints", "joint9"], ["joint9", "joint7"]),
    ],
)
def test_what_is_wrong_is_named(change, arguments, words, urdf, capsys):
    urdf.write_text(urdf.read_text().replace(*change, 1))
    assert main(["check", str(urdf), *arguments]) == 2
    error = capsys.readouterr().err
    assert all(word in error for word in words)


def test_a_missing_file_is_named(capsys):
    assert main(["check", "gone.urdf"]) == 2
    assert "gone.urdf" in capsys.readouterr().err
