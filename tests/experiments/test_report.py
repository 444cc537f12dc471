"""A paper's figures beside ours: the verdicts, and the exit code that comes of them."""

from fikm_drake import cli
from fikm_drake.experiments.reproduce import papers
from fikm_drake.experiments.reproduce.report import Cell, Section, at_most, equal


def test_at_most():
    assert at_most("e", 0.61, 0.61).reached
    assert at_most("e", 0.61, 0.6101).reached is False
    assert at_most("e", 1.0, float("nan")).reached is False


def test_equal():
    assert equal("n", 45, 45).reached and not equal("n", 45, 44).reached


def test_section_prints_both_sides_and_the_verdict():
    section = Section("table 9", "a title", [Cell("x [m]", 1.0, 2.0, False), Cell("y", None, "z")])
    text = str(section)
    assert "table 9: a title" in text and "NOT REACHED" in text and "paper" in text
    assert not section.reached
    assert Section("t", "t", [Cell("y", None, "z")]).reached


def test_a_missed_claim_gives_exit_code_1(monkeypatch, capsys):
    missed = {"table 1": lambda: Section("table 1", "t", [Cell("x", 1.0, 2.0, False)])}
    monkeypatch.setitem(papers.PAPERS, "fikm", missed)
    assert cli.main(["reproduce", "fikm"]) == 1
    assert "fikm table 1" in capsys.readouterr().err


def test_unknown_paper_and_part_name_the_valid_ones(capsys):
    assert cli.main(["reproduce", "nobody"]) == 2
    assert "fikm" in capsys.readouterr().err
    assert cli.main(["reproduce", "fikm", "--table", "9"]) == 2
    assert "table 6" in capsys.readouterr().err


def test_a_part_of_all_papers(monkeypatch, capsys):
    section = Section("table 1", "t", [Cell("x", None, 1.0)])
    one = {"table 1": lambda: section, "table 2": lambda: Section("table 2", "t", [])}
    monkeypatch.setattr(papers, "PAPERS", {"a": one, "b": one})
    assert cli.main(["reproduce", "all", "--table", "1"]) == 0
    assert capsys.readouterr().out == f"{section}\n\n" * 2


def test_reproduce_writes_pictures(tmp_path, capsys):
    folder = tmp_path / "new" / "pictures"
    assert cli.main(["reproduce", "fikm", "--table", "1", "--pictures", str(folder)]) == 0
    assert [p.name for p in folder.iterdir()] == ["figures_6_7.png"]
    assert "2.6" in capsys.readouterr().out
