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


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["bounds", "panda", "out.yaml"], 2, ["panda", "three"]),
        (["bounds", "nothing", "out.yaml"], 2, ["nothing", "hassantabar3r"]),
        (["bounds", "hassantabar3r", "gone/out.yaml"], 1, ["gone/out.yaml"]),
        (["bounds", "hassantabar3r", "out.yaml", "--epochs", "0"], 2, ["epochs", "0"]),
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
