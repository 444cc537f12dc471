"""The C: compiled by the system's compiler, beside Python to the last bit."""

import re
import shutil
import subprocess

import pytest

from fikm_drake.experiments.reproduce.integer import compiled
from fikm_drake.experiments.reproduce.integer.compiled import mismatches, passes_self_test
from fikm_drake.experiments.reproduce.integer.microcontroller import missing_tools, run_on_avr
from fikm_drake.fuzzy.integer import SHAPES, write_c
from fikm_drake.fuzzy.integer.integer_partition import ROUNDINGS
from fikm_drake.fuzzy.integer.integer_rule_base import CONJUNCTIONS

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


@needs_compiler
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("conjunction", CONJUNCTIONS)
@pytest.mark.parametrize(("joints", "labels"), [(4, (9, 9)), (12, (2, 7))])
def test_c_is_python_on_the_whole_grid(rules_of, joints, labels, conjunction, rounding, shape):
    """401 x 301 points, singletons that fill 16 bits; no warning with -Wall -Wextra -pedantic."""
    rules = rules_of(labels, joints, conjunction=conjunction, rounding=rounding)
    assert mismatches(rules, shape) == 0


@needs_compiler
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("conjunction", CONJUNCTIONS)
def test_division_bit_by_bit_is_the_same(rules_of, conjunction, rounding, monkeypatch):
    """As on a processor of 16 bits; cells of 400 mm need grades of 32 bits, those of 50 do not."""
    monkeypatch.setattr(compiled, "FLAGS", (*compiled.FLAGS, "-DRULES_NARROW"))
    for labels in ((2, 2), (9, 9)):
        rules = rules_of(labels, 4, conjunction=conjunction, rounding=rounding)
        assert mismatches(rules, "shared_cell") == 0


@pytest.mark.skipif(bool(missing_tools()), reason="no avr-gcc or simavr")
@pytest.mark.parametrize(
    ("labels", "conjunction", "most"), [((3, 3), "min", 4375), ((2, 5), "product", 6000)]
)
def test_a_microcontroller_infers_the_same(rules_of, labels, conjunction, most):
    """The second has cells of 400 mm, so grades of 32 bits."""
    run = run_on_avr(rules_of(labels, 3, conjunction=conjunction), "shared_cell", every=100)
    assert run.mismatches == 0
    assert 500 < run.cycles.min() <= run.cycles.max() < most


@needs_compiler
@pytest.mark.parametrize("conjunction", CONJUNCTIONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_self_test_passes_with_most_labels_and_far_inputs(rules_of, shape, conjunction):
    rules = rules_of((33, 33), 3, x=(-32767, 32767), y=(-5, 300), conjunction=conjunction)
    assert passes_self_test(rules, shape)


@needs_compiler
@pytest.mark.parametrize("shape", SHAPES)
def test_self_test_fails_when_a_table_is_wrong(rules_of, shape, tmp_path):
    source, _ = write_c(rules_of(), tmp_path / "arm.c", shape=shape)
    text = source.read_text("utf-8")
    knots = "    0, 200, 400\n"
    assert text.count(knots) == 1
    source.write_text(text.replace(knots, "    0, 190, 400\n"), encoding="utf-8")
    program = tmp_path / "arm"
    subprocess.run(["cc", "-DARM_SELF_TEST", source, "-o", program], check=True)
    assert subprocess.run([program]).returncode == 1


@pytest.mark.parametrize("shape", SHAPES)
def test_source_includes_and_calls_nothing_else(rules_of, shape, tmp_path):
    source, header = write_c(rules_of(), tmp_path / "arm.c", shape=shape)
    text = header.read_text("utf-8") + source.read_text("utf-8")
    assert set(re.findall(r"#include (.*)", text)) == {"<stdint.h>", '"arm.h"'}
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    assert not re.search(r"\b(float|double|malloc|\d+\.\d*)\b", code)
    defined = set(re.findall(r"^(?:static )?(?:\w+ )+(\w+)\(", code, flags=re.M))
    called = set(re.findall(r"\b(\w+)\(", code)) - {"if", "for", "while"}
    assert called <= defined
    tables = re.findall(r"^(.*)\[\w+\] = \{", code, flags=re.M)
    assert len(tables) == 5 and tables.pop() == "} cases"
    assert all(table.startswith("static const ") for table in tables)
    assert "static const struct {" in code


def test_note_and_shape_are_told(rules_of, tmp_path):
    source, header = write_c(rules_of(), tmp_path / "arm.c", shape="rule_loop", note="In */ mm.")
    assert " * In * / mm.\n" in header.read_text("utf-8")
    assert "3 x 3 rules, AND = min, rounding = truncate, shape = rule loop" in source.read_text()


@pytest.mark.parametrize(
    "name", ["arm.h", "arm", "7up.c", "my arm.c", "a-b.c", "int.c", "ärm.c", "_a.c"]
)
def test_names_that_are_no_c_identifiers(rules_of, name, tmp_path):
    with pytest.raises(ValueError, match="path must"):
        write_c(rules_of(), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_unknown_shape_and_missing_folder(rules_of, tmp_path):
    with pytest.raises(ValueError, match="'shared_cell', 'rule_loop'.*'cell'"):
        write_c(rules_of(), tmp_path / "arm.c", shape="cell")
    with pytest.raises(OSError, match="gone"):
        write_c(rules_of(), tmp_path / "gone" / "arm.c")
