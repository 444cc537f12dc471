"""Benchmarks as a page of Markdown: where they ran, the command of each, its rows, what its columns mean."""

import ast
import dataclasses
import inspect
import math
import os
import platform
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from fikm_drake.experiments.benchmarks.registry import BENCHMARKS
from fikm_drake.kinematics.native.kernel import kernel_description

MOST_ROWS = 60
"""Of more rows than this a page has the benchmark's text, which sums them up."""
HEAD = """# Benchmarks

Written by `fikm-drake benchmark all --page FILE`; `fikm-drake benchmark NAME` prints one of them. Times are
CPU times unless a column says otherwise. What is compared takes turns on the same job, so a busy machine
disturbs all alike: ratios hold, times are those of this machine at that time. A *limit* is what the machine
could do at best, measured too. Peers that are not installed are left out (`pip install 'fikm-drake[peers]'`).
"""


def head() -> str:
    """The title, and where the figures below it are from."""
    versions = [f"{name} {_version(name)}" for name in ("drake", "numpy")]
    where = ", ".join([f"Python {platform.python_version()}", *versions, kernel_description()])
    load = f", load {os.getloadavg()[0]:.1f} at the start" if hasattr(os, "getloadavg") else ""
    return f"{HEAD}\n{where}; {_processor()}, {os.cpu_count()} processors{load}."


def section(name: str, count: int, table: str) -> str:
    """One benchmark: its command and seeds, its rows and columns; of too many rows, or none, its text."""
    entry = BENCHMARKS[name]
    command = f"`fikm-drake benchmark {name} --{entry.count} {count}`"
    title = f"## {name}: {entry.help}"
    long = len(getattr(table, "rows", ())) > MOST_ROWS
    body = f"```text\n{table}\n```" if long else rows_as_markdown(table)
    return "\n".join([title, "", f"{command}; {entry.seeds}.", "", body])


def rows_as_markdown(table: str) -> str:
    """The rows of a benchmark, a table for each kind of row; its text if it has none."""
    kinds: list[tuple[list[str], type, list[list[str]]]] = []
    for row in getattr(table, "rows", ()):
        fields = _fields(row)
        if not kinds or kinds[-1][0] != list(fields):
            kinds.append((list(fields), type(row), []))
        kinds[-1][2].append([_cell(value) for value in fields.values()])
    if not kinds:
        return f"```text\n{table}\n```"
    parts = []
    for names, kind, rows in kinds:
        heads = [name.replace("_", " ") for name in names]
        lines = [_line(heads), _line(["---"] * len(heads)), *map(_line, rows)]
        legend = [f"*{name.replace('_', ' ')}*: {text}" for name, text in _meanings(kind)]
        parts.append(
            "\n".join([*lines, *(["", *textwrap.wrap(" ".join(legend), 110)] if legend else [])])
        )
    return "\n\n".join(parts)


def _meanings(kind: type) -> Iterator[tuple[str, str]]:
    """What each field of a dataclass is, from the docstrings below them."""
    if not dataclasses.is_dataclass(kind):
        return
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    for field, below in zip(body, body[1:]):
        if isinstance(field, ast.AnnAssign) and isinstance(below, ast.Expr):
            text = ast.literal_eval(below.value)
            yield ast.unparse(field.target), " ".join(text.split())


def _fields(row: object) -> dict[str, object]:
    if isinstance(row, Mapping):
        return {str(key): value for key, value in row.items()}
    if dataclasses.is_dataclass(row) and not isinstance(row, type):
        return {item.name: getattr(row, item.name) for item in dataclasses.fields(row)}
    return {"": row}


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{_cell(key)}: {_cell(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(_cell, value))
    return str(value).replace("|", "\\|")


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:  # Drake built from source
        return "of unknown version"


def _processor() -> str:
    """The processor's name, as far as the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
        return next(
            line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
