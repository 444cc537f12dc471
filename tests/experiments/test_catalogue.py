"""The map of the papers: no dangling name, no number left out, every key runs something."""

import importlib
import re
from pathlib import Path

import pytest

from fikm_drake import cli
from fikm_drake.experiments.reproduce.catalogue import aliases, catalogue
from fikm_drake.experiments.reproduce.papers import PAPERS, listing, page, select
from fikm_drake.experiments.reproduce.report import Cell, Section

ITEMS = [(paper, item) for paper, items in catalogue().items() for item in items]
NUMBERS = {
    "fikm": {"table": range(1, 8), "figure": range(1, 24)},
    "frmrc": {"table": [1], "figure": range(1, 8)},
    "labvolt": {"table": range(1, 5), "figure": range(1, 10), "algorithm": [1]},
    "integer": {"table": range(1, 3), "figure": range(1, 13)},
    "anfis": {
        "table": ["3.1", "3.2", "3.3", "4.1"],
        "figure": [*(f"3.{k}" for k in range(1, 20)), *(f"4.{k}" for k in range(1, 19))],
        "algorithm": [1],
    },
}
"""Of the papers; chapters 1 and 2 of the thesis show other people's machines."""


@pytest.mark.parametrize(("paper", "item"), ITEMS, ids=lambda x: getattr(x, "names", [x])[0])
def test_items_name_what_is_there(paper, item):
    module, name = item.where.split(":")
    assert hasattr(importlib.import_module(f"fikm_drake.{module}"), name)
    assert item.part in PAPERS[paper]


@pytest.mark.parametrize("paper", NUMBERS)
def test_every_table_figure_and_algorithm_is_a_key(paper):
    keys = aliases(paper)
    for kind, numbers in NUMBERS[paper].items():
        for number in numbers:
            assert len(select(paper, [f"{kind} {number}"])) == 1
    assert len(keys) == sum(map(len, NUMBERS[paper].values()))


@pytest.mark.parametrize(("paper", "last"), [("fikm", 57), ("frmrc", 16), ("labvolt", 5)])
def test_every_equation_is_in_the_map(paper, last):
    found = set()
    for item in catalogue()[paper]:
        for name in item.names:
            text = name.removeprefix("equations ").removeprefix("equation ")
            if name.startswith("equation") or text.isdigit():
                low, _, high = text.partition("-")
                found |= set(range(int(low), int(high or low) + 1))
    assert found == set(range(1, last + 1))


def test_list_names_every_part_and_its_numbers(capsys):
    assert cli.main(["reproduce", "fikm", "--list"]) == 0
    text = capsys.readouterr().out
    assert all(f"  {key} " in text for key in PAPERS["fikm"])
    assert "figure 14" in text and "figure 23" in text
    assert all(paper in listing("all") for paper in PAPERS)


def test_map_has_a_row_an_item_and_the_verdicts_of_what_was_run(tmp_path, capsys):
    target = tmp_path / "map.md"
    assert cli.main(["reproduce", "fikm", "--table", "1", "--map", str(target)]) == 0
    text = target.read_text("utf-8")
    assert text.count("\n| ") == len(ITEMS) + len(PAPERS)  # and the heads
    assert "6 of 6 claims hold" in text and "not run" in text
    told = Section("table 6", "t", [Cell("e", 1.0, 0.5, True, 2.0, False)])
    assert "1 of 1 claims hold; told: 0 meet, 1 miss" in page({"fikm table 6": told})


def test_the_map_that_is_kept_is_complete_and_up_to_date():
    """Every row is today's, has a verdict, and links to a file that is there."""
    folder = Path(__file__).parents[2] / "notebooks"
    text = (folder / "papers.md").read_text("utf-8")
    assert "not run |" not in text and "NOT REACHED" not in text

    def rows(page_text):
        lines = [line for line in page_text.splitlines() if line.startswith("| ")]
        return [line.rsplit(" | ", 1)[0] for line in lines]

    assert rows(text) == rows(page({}))
    for link in re.findall(r"\]\(([^)]+)\)", text):
        assert (folder / link).exists(), link
    for held, of in re.findall(r"(\d+) of (\d+) claims hold", text):
        assert held == of
