"""Paper 5: every table and figure that `fikm-drake reproduce integer` claims."""

import importlib

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.experiments.reproduce.integer import EXPERIMENTS, compiled, traces
from fikm_drake.experiments.reproduce.integer.table_1 import (
    TABLE_1,
    labels_in_order,
    shared_singletons,
)
from fikm_drake.experiments.reproduce.integer.table_2 import JOINTS, many_joints, operations

MODULE = "fikm_drake.experiments.reproduce.integer.table_2"  # the package has the part of this name


def test_mcu_without_its_tools_says_so(monkeypatch):
    monkeypatch.setattr(compiled.shutil, "which", lambda _: None)
    section = EXPERIMENTS["mcu"]()
    assert section.cells == [] and section.reached
    assert "Skipped: avr-gcc" in str(section) and "gcc-avr avr-libc simavr" in str(section)


@pytest.mark.parametrize("key", EXPERIMENTS)
def test_reproduces(key, monkeypatch):
    if key == "export":  # all arms and variants: tests/fuzzy/integer/test_write_c.py
        monkeypatch.setattr(importlib.import_module(MODULE), "JOINTS", (4,))
    section = EXPERIMENTS[key]()
    assert section.key == key
    assert section.cells or "not installed" in str(section) or compiled.find_compiler() is None
    assert section.reached, str(section)
    for cell in section.cells:
        assert not (isinstance(cell.ours, float) and np.isnan(cell.ours)), cell


def test_table_2_runs_without_a_compiler(monkeypatch):
    monkeypatch.setattr(compiled.shutil, "which", lambda _: None)
    table = EXPERIMENTS["table 2"]()
    assert table.reached and any("operations" in cell.label for cell in table.cells)
    assert not any("instructions" in cell.label for cell in table.cells)
    assert "that takes a C compiler" in str(table)
    export = EXPERIMENTS["export"]()
    assert export.cells == [] and "Not run" in str(export)


def test_labels_that_do_not_agree_show():
    rules = fd.IntegerFuzzyIk().rules
    roll, paper = rules.singletons[..., 1].copy(), TABLE_1["shoulder roll"]
    assert labels_in_order(roll, paper) == paper
    roll[0, 0], roll[2, 2] = roll[2, 2], roll[0, 0]
    assert labels_in_order(roll, paper) == ("S ML MS", "ML M S", "M MS L")


def test_five_shared_singletons_are_not_enough():
    """Figure 4 taken literally; Table 1 has three labels of the pitch, five of the others."""
    shared = shared_singletons(fd.IntegerFuzzyIk().rules.singletons)
    assert [len(np.unique(shared[..., j])) for j in range(4)] == [3, 5, 5, 5]
    own_max, own_mean, shared_max, shared_mean = (
        cell.ours for cell in EXPERIMENTS["figure 4"]().cells
    )
    assert shared_max > 3 * own_max and shared_mean > 2 * own_mean


@pytest.mark.parametrize(
    ("name", "length", "step"),
    [
        ("integer_rectangle", 1400, 5),
        ("integer_circle", 2 * np.pi * 150, 150 * np.pi / 180),
        ("integer_line", 500, 5),
    ],
)
def test_paths_of_figures_7_to_12(name, length, step):
    path = traces.path(fd.load_scenario(name))
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps.sum() == pytest.approx(length, rel=1e-4)
    np.testing.assert_allclose(steps, step, rtol=1e-4)
    assert (path >= -1e-9).all() and (path <= [400 + 1e-9, 300 + 1e-9]).all()


@pytest.mark.parametrize("joints", JOINTS)
def test_arms_side_by_side_have_the_first_ones_rules_first(joints):
    singletons = many_joints(joints).singletons
    assert singletons.shape == (3, 3, joints)
    np.testing.assert_array_equal(singletons[..., :4], fd.IntegerFuzzyIk().rules.singletons)
    assert len(np.unique(singletons.reshape(9, joints), axis=1).T) == joints - joints // 4 + 1


class Counting:
    """A number that counts the arithmetic done with it."""

    done = 0

    def __init__(self, value):
        self.value = value

    def _do(self, operation, other):
        Counting.done += 1
        return Counting(operation(self.value, getattr(other, "value", other)))

    def __add__(self, other):
        return self._do(int.__add__, other)

    def __sub__(self, other):
        return self._do(int.__sub__, other)

    def __mul__(self, other):
        return self._do(int.__mul__, other)

    def __floordiv__(self, other):
        return self._do(int.__floordiv__, other)

    def __lt__(self, other):
        return bool(self._do(int.__lt__, other).value)


def c_in_python(rules, shape, x, y):
    """The generated C for `min` and truncation, line by line, on numbers that count."""
    knots = [[Counting(k) for k in p.knots.tolist()] for p in (rules.first, rules.second)]
    values, K = (Counting(x), Counting(y)), Counting
    for value, ends in zip(values, knots):
        assert not value < ends[0] and not ends[-1] < value
    table = (rules.singletons - rules.least).tolist()
    least = rules.least.tolist()

    def both(a, b):
        return a if a < b else b

    def rise(offset, width):
        return offset * 255 // width

    def fall(offset, width):
        return (width - offset) * 255 // width

    def average(terms, total, k):
        above = terms[0]
        for term in terms[1:]:
            above = above + term
        return (above // total + least[k]).value

    if shape == "shared_cell":
        cells = []
        for value, k in zip(values, knots):
            cell = K(len(k) - 2)
            while value < k[cell.value]:
                cell = cell - 1
            offset, width = value - k[cell.value], k[cell.value + 1] - k[cell.value]
            cells.append((cell.value, rise(offset, width), fall(offset, width)))
        (i, a_rise, a_fall), (j, b_rise, b_fall) = cells
        weights = [both(a_fall, b_fall), both(a_fall, b_rise)]
        weights += [both(a_rise, b_fall), both(a_rise, b_rise)]
        total = weights[0] + weights[1] + weights[2] + weights[3]
        rows = table[i][j], table[i][j + 1], table[i + 1][j], table[i + 1][j + 1]
        return [
            average([w * row[k] for w, row in zip(weights, rows)], total, k)
            for k in range(rules.num_outputs)
        ]

    def grade(k, label, value):
        if value < k[label]:
            if value < k[label - 1]:
                return K(0)
            return rise(value - k[label - 1], k[label] - k[label - 1])
        if K(label) + 1 < len(k):
            if k[label + 1] < value:
                return K(0)
            return fall(value - k[label], k[label + 1] - k[label])
        return K(255)

    outputs = []
    for k in range(rules.num_outputs):
        b = [grade(knots[1], j, values[1]) for j in range(len(knots[1]))]
        above, total = K(0), K(0)
        for i in range(len(knots[0])):
            a = grade(knots[0], i, values[0])
            for j in range(len(b)):
                weight = both(a, b[j])
                above, total = above + weight * table[i][j][k], total + weight
        outputs.append(average([above], total, k))
    return outputs


@pytest.mark.parametrize("shape", fd.fuzzy.integer.SHAPES)
@pytest.mark.parametrize(("labels", "joints"), [(3, 4), (3, 24), (5, 8)])
def test_operations_are_what_the_c_does(labels, joints, shape):
    rules = many_joints(joints, labels=(labels, labels))
    counts = []
    for left in rules.first.knots[:-1].tolist():
        for low in rules.second.knots[:-1].tolist():
            Counting.done = 0
            assert (
                c_in_python(rules, shape, left + 20, low + 30)
                == rules.infer(left + 20, low + 30)[0]
            )
            counts.append(Counting.done)
    assert np.mean(counts) == operations(labels, joints, shape)
