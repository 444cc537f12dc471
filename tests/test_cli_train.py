"""`fikm-drake train`."""

import pytest

import fikm_drake as fd
from fikm_drake.cli import main

SHORT = ["--points", "200", "--epochs", "2", "--starts", "1"]


def test_train_bounds_writes_what_the_resolver_takes(tmp_path, capsys):
    path = tmp_path / "bounds.yaml"
    assert main(["train", "bounds", "hassantabar3r", str(path), *SHORT]) == 0
    assert "theta_1_lower(r, phi)" in capsys.readouterr().out
    bounds = fd.LearnedBounds.load(path)
    found = fd.RedundancyResolver(fd.load_arm("hassantabar3r"), bounds).resolve([[1.0, 2.0]])
    assert found.success.all()


def test_train_traced_bounds_writes_what_the_resolver_takes(tmp_path, capsys):
    path = tmp_path / "bounds.yaml"
    short = ["--points", "60", "--epochs", "1", "--processes", "1", "--joint", "1"]
    assert main(["train", "traced-bounds", "hassantabar4r", str(path), *short]) == 0
    assert "theta_2_lower(r, phi, psi_minus_phi)" in capsys.readouterr().out
    bounds = fd.LearnedBounds.load(path)
    assert (bounds.task, bounds.joint) == ("pose", 1)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["bounds", "panda", "out.yaml"], 2, ["panda", "three"]),
        (["bounds", "nothing", "out.yaml"], 2, ["nothing", "hassantabar3r"]),
        (["bounds", "hassantabar3r", "gone/out.yaml"], 1, ["gone/out.yaml"]),
        (["bounds", "hassantabar3r", "out.yaml", "--epochs", "0"], 2, ["epochs", "0"]),
        (["traced-bounds", "hassantabar3r", "out.yaml"], 2, ["hassantabar3r", "four"]),
        (["traced-bounds", "hassantabar4r", "out.yaml", "--joint", "5"], 2, ["joint", "5"]),
        (["traced-bounds", "hassantabar4r", "gone/out.yaml"], 1, ["gone/out.yaml"]),
        (["static", "gone/out.yaml"], 1, ["gone/out.yaml"]),
    ],
)
def test_bad_arguments(arguments, code, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["train", *arguments]) == code
    captured = capsys.readouterr()
    assert captured.out == "" and not list(tmp_path.iterdir())
    for word in words:
        assert word in captured.err
