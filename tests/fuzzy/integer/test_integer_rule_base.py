"""Equation 5 in integers, beside the equations of the paper written out over every rule."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy.integer import IntegerPartition, IntegerRuleBase, interpolate
from fikm_drake.fuzzy.integer.integer_partition import ROUNDINGS
from fikm_drake.fuzzy.integer.integer_rule_base import CONJUNCTIONS

VARIANTS = [(c, r) for c in CONJUNCTIONS for r in ROUNDINGS]


def all_grades(knots, x, rounding):
    """Grade of every label at x inside the range, one by one, from exact fractions."""
    grades = []
    for k, peak in enumerate(knots):
        if x < peak:
            grade = Fraction(255 * (x - knots[k - 1]), peak - knots[k - 1])
        elif k + 1 < len(knots):
            grade = Fraction(255 * (knots[k + 1] - x), knots[k + 1] - peak)
        else:
            grade = Fraction(255)
        grade = max(grade, Fraction(0))
        if rounding == "truncate":
            grades.append(int(grade))
        else:  # halves: up where the grade rises, so down where it falls
            up = grade + Fraction(1, 2)
            falls = x > peak and up.denominator == 1
            grades.append(int(up) - int(falls))
    return grades


def every_rule(rules, x, y):
    """The paper's inference: all rules, each output by itself."""
    a = all_grades(rules.first.knots.tolist(), x, rules.rounding)
    b = all_grades(rules.second.knots.tolist(), y, rules.rounding)
    outputs = []
    for k, least in enumerate(rules.least.tolist()):
        above = total = 0
        for i, p in enumerate(a):
            for j, q in enumerate(b):
                weight = min(p, q) if rules.conjunction == "min" else p * q
                above += weight * (int(rules.singletons[i, j, k]) - least)
                total += weight
        mean = Fraction(above, total) + (Fraction(1, 2) if rules.rounding == "nearest" else 0)
        outputs.append(least + int(mean))
    return outputs


@pytest.mark.parametrize(("conjunction", "rounding"), VARIANTS)
@pytest.mark.parametrize("labels", [(3, 3), (2, 5), (33, 33)])
def test_four_rules_are_all_rules(rules_of, labels, conjunction, rounding):
    rules = rules_of(labels, 2, conjunction=conjunction, rounding=rounding)
    rng = np.random.default_rng(1)
    for x, y in zip(rng.integers(0, 401, 30).tolist(), rng.integers(0, 301, 30).tolist()):
        assert rules.infer(x, y) == (every_rule(rules, x, y), False)


@pytest.mark.parametrize(("conjunction", "rounding"), VARIANTS)
@given(data=st.data())
def test_batch_is_scalar_to_the_last_bit(rules_of, conjunction, rounding, data):
    labels = data.draw(st.tuples(st.integers(2, 33), st.integers(2, 33)))
    rules = rules_of(
        labels, data.draw(st.sampled_from([1, 4, 24])), conjunction=conjunction, rounding=rounding
    )
    far = st.one_of(st.integers(-50, 450), st.integers(-(2**62), 2**62))
    points = np.array(data.draw(st.lists(st.tuples(far, far), min_size=1, max_size=8)))
    outputs, outside = rules.infer_batch(points[:, 0], points[:, 1])
    for (x, y), row, flag in zip(points.tolist(), outputs.tolist(), outside.tolist()):
        assert rules.infer(x, y) == (row, flag)


@pytest.mark.parametrize(("conjunction", "rounding"), VARIANTS)
def test_peaks_give_their_singletons(rules_of, conjunction, rounding):
    rules = rules_of((9, 5), 4, conjunction=conjunction, rounding=rounding)
    x, y = np.meshgrid(rules.first.knots, rules.second.knots, indexing="ij")
    np.testing.assert_array_equal(rules.infer_batch(x, y)[0], rules.singletons)


@pytest.mark.parametrize(("conjunction", "rounding"), VARIANTS)
def test_integers_are_near_floating_point(rules_of, conjunction, rounding):
    """A grade is off by at most 1 of 255, so the output by a few 255ths of the singletons' span."""
    rules = rules_of((9, 9), 4, conjunction=conjunction, rounding=rounding)
    points = np.random.default_rng(2).integers(0, [401, 301], (3000, 2))
    exact = interpolate(rules.first, rules.second, rules.singletons, points, conjunction)
    error = np.abs(rules.infer_batch(*points.T)[0] - exact)
    assert 0 < error.max() < 65536 * 4 / 255
    if rounding == "nearest":
        bias = (rules.infer_batch(*points.T)[0] - exact).mean()
        assert abs(bias) < 0.05 * error.mean() + 0.5


def test_outside_is_the_nearest_point_with_a_flag(rules_of):
    rules = rules_of()
    for x, y in ((-1, 20), (401, 20), (30, -5), (30, 301), (-9, 999), (2**70, -(2**70))):
        nearest = min(max(x, 0), 400), min(max(y, 0), 300)
        assert rules.infer(x, y) == (rules.infer(*nearest)[0], True)
        assert rules.infer(*nearest)[1] is False


def test_instances_do_not_change(rules_of):
    singletons = np.zeros((3, 3, 1), dtype=int)
    first, second = IntegerPartition([0, 1, 2]), IntegerPartition([0, 1, 2])
    rules = IntegerRuleBase(first, second, singletons)
    singletons[:] = 7
    assert rules.infer(1, 1) == ([0], False)
    with pytest.raises(ValueError, match="read-only"):
        rules.singletons[0, 0, 0] = 1
    rules.least[0] = 5
    assert rules.infer(1, 1) == ([0], False)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"conjunction": "or"}, "conjunction must be one of .*'min', 'product'.*'or'"),
        ({"rounding": "up"}, "rounding must be one of .*'truncate', 'nearest'.*'up'"),
        ({"singletons": np.zeros((3, 2, 1), int)}, r"\(3, 2, 1\)"),
        ({"singletons": np.zeros((3, 3), int)}, r"\(3, 3\)"),
        ({"singletons": np.zeros((3, 3, 0), int)}, r"\(3, 3, 0\)"),
        ({"singletons": np.zeros((3, 3, 1))}, "integers.*float64"),
        ({"singletons": np.full((3, 3, 1), 2**31)}, "2147483647"),
        ({"singletons": np.full((3, 3, 1), -(2**63))}, "2147483647"),
        ({"singletons": np.arange(9).reshape(3, 3, 1) * 8192}, "65535, got 65536"),
    ],
)
def test_bad_arguments(change, words):
    first, second = IntegerPartition([0, 1, 2]), IntegerPartition([0, 1, 2])
    arguments = {"singletons": np.zeros((3, 3, 1), int)} | change
    with pytest.raises(ValueError, match=words):
        IntegerRuleBase(first, second, **arguments)


@pytest.mark.parametrize("bad", [1.0, "1", None, float("nan")])
def test_inputs_that_are_not_integers(rules_of, bad):
    with pytest.raises(TypeError):
        rules_of().infer(bad, 0)
    with pytest.raises(ValueError, match="y must be integers"):
        rules_of().infer_batch([0, 1], [bad, bad])


def test_inputs_that_do_not_broadcast(rules_of):
    with pytest.raises(ValueError, match="broadcast"):
        rules_of().infer_batch([0, 1], [0, 1, 2])
