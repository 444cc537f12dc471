"""`fikm-drake calibrate`: files that load, the same from the same seed."""

import pytest

from fikm_drake import load_mamdani
from fikm_drake.cli import main
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts

FEW = ["calibrate", "labvolt", "--targets", "40", "--rounds", "5", "--seed", "7"]


def test_writes_memberships_that_load_and_repeats_them(tmp_path, capsys):
    texts = []
    for name in ("first", "second"):
        folder = tmp_path / name
        folder.mkdir()
        assert main([*FEW, "--folder", str(folder)]) == 0
        texts.append({path.name: path.read_text("utf-8") for path in folder.iterdir()})
    assert texts[0] == texts[1]
    assert sorted(texts[0]) == ["labvolt_posture.yaml", "labvolt_theta3.yaml"]
    assert all(text.startswith("# Elsharif") for text in texts[0].values())
    printed = capsys.readouterr().out
    assert "guesses of θ_3, mean" in printed and "targets that the SQP misses" in printed
    FuzzyStarts(
        theta_3=load_mamdani(tmp_path / "first" / "labvolt_theta3.yaml"),
        posture=load_mamdani(tmp_path / "first" / "labvolt_posture.yaml"),
    )


def test_missing_folder_exits_with_2_before_the_search(tmp_path, capsys):
    assert main([*FEW, "--folder", str(tmp_path / "gone")]) == 2
    assert "gone" in capsys.readouterr().err


def test_negative_seed_exits_with_2_and_is_named(tmp_path, capsys):
    assert main([*FEW, "--seed", "-1", "--folder", str(tmp_path)]) == 2
    assert "seed must be an integer of at least 0, got -1" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["puma"], ["labvolt", "--rounds", "0"]])
def test_bad_arguments_exit_with_2(arguments, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["calibrate", *arguments])
    assert stopped.value.code == 2
    assert "usage" in capsys.readouterr().err
