"""The scripts of `notebooks/examples` run, and do what they say; each is under 60 lines."""

import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "notebooks" / "examples"


def run(monkeypatch, name, *arguments):
    """The variables of a script after it has run."""
    path = FOLDER / f"{name}.py"
    monkeypatch.setattr(sys, "argv", [str(path), *arguments])
    return runpy.run_path(str(path))


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_every_example_is_short(path):
    assert len(path.read_text("utf-8").splitlines()) < 60


def test_two_torque_driven_arms_in_one_plant(monkeypatch):
    errors = run(monkeypatch, "two_arms")["errors"]
    assert len(errors) == 2 and max(errors.values()) < 2e-3


def test_a_torso_reaches_what_the_arm_alone_does_not(monkeypatch):
    errors = run(monkeypatch, "torso_with_an_arm")["errors"]
    assert errors["with the torso"] < 2e-3 < 0.1 < errors["the arm alone"]


def test_a_tool_stays_above_a_moving_body(monkeypatch):
    errors = run(monkeypatch, "moving_target")["errors"]
    assert errors[-1] < 5e-3 < errors[0]


def test_sliders_move_the_target(monkeypatch):
    assert run(monkeypatch, "teleoperation", "1.5")["moved"] == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize("driver", ["torque", "iiwa"])
def test_a_brick_is_picked_and_placed(driver, monkeypatch):
    assert run(monkeypatch, "pick_and_place", driver)["error"] < 0.01
