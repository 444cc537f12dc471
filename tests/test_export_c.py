"""`fikm-drake export-c`."""

import shutil
import subprocess

import pytest

from fikm_drake.cli import main

DATA = "x, y, a, b\n" + "\n".join(
    f"{x}, {y}, {x / 10}, {-y / 10}" for x in (0, 9, 99) for y in (0, 5, 50)
)


def test_writes_the_papers_rules(tmp_path, capsys):
    assert main(["export-c", str(tmp_path / "tojo.c")]) == 0
    assert "tojo.h: 9 rules, 4 joints" in capsys.readouterr().out
    assert "#define TOJO_OUTPUTS 4" in (tmp_path / "tojo.h").read_text("utf-8")


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("shape", ["shared_cell", "rule_loop"])
def test_options_reach_the_c_and_it_passes_its_self_test(shape, tmp_path, capsys):
    path = tmp_path / "arm.c"
    options = ["--labels", "9", "5", "--conjunction", "product", "--rounding", "nearest"]
    options += ["--resolution", "0.1", "--least-squares", "--shape", shape]
    assert main(["export-c", str(path), *options]) == 0
    assert "45 rules, 4 joints" in capsys.readouterr().out
    assert "9 x 5 rules, AND = product, rounding = nearest" in path.read_text("utf-8")
    strict = ["cc", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"]
    subprocess.run([*strict, "-DARM_SELF_TEST", path, "-o", tmp_path / "arm"], check=True)
    assert subprocess.run([tmp_path / "arm"]).returncode == 0


def test_data_of_the_users_own(tmp_path, capsys):
    (tmp_path / "data.csv").write_text(DATA)
    options = ["--data", str(tmp_path / "data.csv")]
    assert main(["export-c", str(tmp_path / "mine.c"), *options]) == 0
    assert "9 rules, 2 joints" in capsys.readouterr().out
    assert "0, 9, 99" in (tmp_path / "mine.c").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["7.c"], 2, "C identifier"),
        (["arm.c", "--labels", "3", "40"], 2, "33 labels, got 40"),
        (["arm.c", "--data", "gone.csv"], 2, "gone.csv"),
        (["gone/arm.c"], 1, "gone"),
    ],
)
def test_bad_arguments(arguments, code, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["export-c", *arguments]) == code
    captured = capsys.readouterr()
    assert words in captured.err and captured.out == ""
    assert not list(tmp_path.iterdir())
