"""The README's blocks run, and its first two are the commands that it promises."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
PYTHON = [code for language, code in BLOCKS if language == "python"]


def test_first_two_shell_blocks_run_the_main_job_and_the_tests():
    first, second = [code for language, code in BLOCKS if language == "sh"][:2]
    assert first.startswith("python3 -m venv .venv && ") and "fikm-drake run" in first
    assert second.startswith("python3 -m venv .venv && ") and "pytest" in second


@pytest.mark.parametrize("code", PYTHON, ids=range(len(PYTHON)))
def test_python_block_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, str(README), "exec"), {})


def test_table_6_figures_are_what_the_runs_give():
    import fikm_drake as fd

    rows = re.findall(r"^\| (\d+) s \| (.*) \|$", README.read_text(encoding="utf-8"), flags=re.M)
    assert len(rows) == 3
    for seconds, cells in rows:
        _, e_max, _, e_mean, _, e_ss = (cell.strip() for cell in cells.split("|"))
        metrics = fd.simulate(fd.load_scenario(f"table6_{seconds}s")).metrics()
        measured = [f"{100 * e:.2f}" for e in (metrics.e_max, metrics.e_mean, metrics.e_ss)]
        assert measured == [e_max, e_mean, e_ss]
