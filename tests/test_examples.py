"""The scripts of `notebooks/examples` run, and do what they say; each is under 60 lines."""

import runpy
import sys
from pathlib import Path

import numpy as np
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


def test_the_labvolt_holds_a_box_by_contact_and_puts_it_down(monkeypatch, tmp_path):
    found = run(monkeypatch, "pick_and_place_labvolt", str(tmp_path))
    log, (x, y), size = found["log"], found["TO"], found["SIZE"]
    box = log["box"][:, 4:7]
    assert found["error"] < 5e-3  # of its place, standing on the table
    assert box[-1] == pytest.approx([x, y, size[2] / 2], abs=5e-3)
    assert box[:, 2].max() > 0.1  # it was in the air, held by nothing but friction
    assert np.ptp(box[log.time > log.time[-1] - 0.8], axis=0).max() < 1e-3  # and stays there
    counts = (tmp_path / "counts.csv").read_text("utf-8").splitlines()
    assert len(counts) == len(log) + 1 and counts[0].startswith("time_s,base_deg")
    assert (tmp_path / "run.csv").exists()
