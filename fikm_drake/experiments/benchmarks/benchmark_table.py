"""What a benchmark gives: text for people that keeps its rows for programs."""

from __future__ import annotations

from collections.abc import Iterable


class BenchmarkTable(str):
    """The lines of a table, with the dataclasses or dicts that they show as `rows`.

    It is a string, so that `print` and `in` work; `fikm-drake benchmark --json` writes the rows.
    """

    rows: list[object]
    """One a measurement, with the units in the docstrings of their fields."""

    def __new__(cls, lines: Iterable[str], rows: Iterable[object]) -> BenchmarkTable:
        """The lines, joined, and their rows."""
        table = super().__new__(cls, "\n".join(lines))
        table.rows = list(rows)
        return table
