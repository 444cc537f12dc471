"""The integer inference as C99."""

import re
from pathlib import Path
from string import Template
from textwrap import fill
from typing import Literal

import numpy as np

from fikm_drake.files import write_whole
from fikm_drake.fuzzy.integer.integer_partition import GRADE, IntegerPartition, check_choice
from fikm_drake.fuzzy.integer.integer_rule_base import IntegerRuleBase

Shape = Literal["shared_cell", "rule_loop"]
SHAPES: tuple[Shape, ...] = ("shared_cell", "rule_loop")
KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int "
    "long register restrict return short signed sizeof static struct switch typedef union unsigned void "
    "volatile while".split()
)
_SHORT_STEP = """\
        sum <<= 1;
        if ((uint16_t)(sum >> 16) >= total)
            sum = sum - ((uint32_t)total << 16) + 1;"""
_LONG_STEP = """\
        uint8_t carry = (uint8_t)(sum >> 31);

        sum <<= 1;
        if (carry || (uint16_t)(sum >> 16) >= total)
            sum = sum - ((uint32_t)total << 16) + 1;"""
"""One bit of a quotient; totals of `min` have 10 bits, those of `product` 16, so a bit can be lost."""
_TEMPLATES = Path(__file__).parent / "templates"


def write_c(
    rules: IntegerRuleBase,
    path: str | Path,
    *,
    shape: Shape = "shared_cell",
    note: str = "Units: those of the rule base.",
) -> tuple[Path, Path]:
    """Write a rule base as C99, `NAME.c` and `NAME.h`, with the function `NAME_infer`.

    The function gives the integers of `rules.infer` for inputs of 32 bits. It uses integers and constant
    tables only: grades of 16 bits where a cell of an input is at most 256 wide, and sums of 32. With the
    macro `NAME_SELF_TEST` (capitals) defined, the source is a program whose exit code is 0 if its results
    are those of Python.

    Args:
        rules: the rule base.
        path: of the source, `…/NAME.c`; the header is put beside it.
        shape: `shared_cell` finds the cell once and looks at its four rules for all outputs;
            `rule_loop` looks at every rule, once for each output, as the paper's equations stand.
        note: what the inputs and outputs are, for the head of both files.

    Returns:
        Paths of the source and of the header.

    Raises:
        ValueError: the shape is unknown, or the path does not end in `.c` after a C identifier.
        OSError: a file cannot be written.
    """
    check_choice("shape", shape, SHAPES)
    source = Path(path)
    if source.suffix != ".c" or not re.fullmatch(r"[A-Za-z]\w*", source.stem, re.ASCII):
        raise ValueError(f"path must be a C identifier with the suffix .c, got {source.name!r}")
    if source.stem in KEYWORDS:
        raise ValueError(f"path must not be named by a word of C, got {source.name!r}")
    words = {**_words(rules, shape), "name": source.stem, "NAME": source.stem.upper()}
    words["note"] = fill(
        note, 96, initial_indent=" * ", subsequent_indent=" * ", break_long_words=False
    ).replace("*/", "* /")
    parts = ("common.c", f"{shape}.c", "self_test.c")
    write_whole(source, "".join(_fill(part, words) for part in parts))
    header = source.with_suffix(".h")
    write_whole(header, _fill("header.h", words))
    return source, header


def _fill(template: str, words: dict[str, str]) -> str:
    return Template((_TEMPLATES / template).read_text("utf-8")).substitute(words)


def _words(rules: IntegerRuleBase, shape: Shape) -> dict[str, str]:
    """What the templates leave open, but for the names and the note."""
    first, second = rules.first, rules.second
    nearest = rules.rounding == "nearest"
    widest = max(int(np.diff(partition.knots).max()) for partition in (first, second))
    cases = _cases(rules)
    return {
        "rules": f"{len(first)} x {len(second)}",
        "conjunction": rules.conjunction,
        "rounding": rules.rounding,
        "shape": shape.replace("_", " "),
        "grade": str(GRADE),
        "bits": "16" if GRADE * widest + widest // 2 <= 0xFFFF else "32",
        "x_labels": str(len(first)),
        "y_labels": str(len(second)),
        "outputs": str(rules.num_outputs),
        "x_low": str(first.low),
        "x_high": str(first.high),
        "y_low": str(second.low),
        "y_high": str(second.high),
        "x_knots": _numbers(first.knots),
        "y_knots": _numbers(second.knots),
        "least": _numbers(rules.least),
        "singletons": _braces(rules.singletons - rules.least, 1),
        "rise": "(grade_max * offset + width / 2) / width"
        if nearest
        else "grade_max * offset / width",
        "fall": "grade_max - rise(offset, width)"
        if nearest
        else "grade_max * (width - offset) / width",
        "both": "a < b ? a : b" if rules.conjunction == "min" else "a * b",
        "step": _SHORT_STEP if rules.conjunction == "min" else _LONG_STEP,
        "quotient": "divide(sum + total / 2, total)" if nearest else "divide(sum, total)",
        "cases": str(len(cases)),
        "expected": ",\n".join(f"    {case}" for case in cases),
    }


def _cases(rules: IntegerRuleBase) -> list[str]:
    """Inputs inside and outside, with what is inferred there."""
    pairs = [(x, y) for x in _samples(rules.first) for y in _samples(rules.second)]
    cases = []
    for x, y in pairs:
        outputs, outside = rules.infer(x, y)
        cases.append(f"{{{x}, {y}, {int(outside)}, {{{', '.join(map(str, outputs))}}}}}")
    return cases


def _samples(partition: IntegerPartition) -> list[int]:
    low, high = partition.low, partition.high
    inside = [low + (high - low) * k // 7 for k in range(8)]
    return [1 - 2**31, low - 1, *inside, high + 1, 2**31 - 1]


def _numbers(values: np.ndarray) -> str:
    return fill(
        ", ".join(map(str, values.tolist())), 96, initial_indent="    ", subsequent_indent="    "
    )


def _braces(values: np.ndarray, depth: int) -> str:
    """Nested initialisers of an array, one line a row."""
    indent = "    " * depth
    if values.ndim == 1:
        return f"{indent}{{{', '.join(map(str, values.tolist()))}}}"
    if values.ndim == 2:
        return ",\n".join(_braces(row, depth) for row in values)
    return ",\n".join(f"{indent}{{\n{_braces(block, depth + 1)}\n{indent}}}" for block in values)
