"""Memberships of integers: figure 3 with grades to 255, and section 3.2's truncation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy.integer import IntegerPartition
from fikm_drake.fuzzy.integer.integer_partition import ROUNDINGS

KNOTS = st.lists(st.integers(-32767, 32767), min_size=2, max_size=33, unique=True).map(sorted)


@given(KNOTS, st.integers(-(2**40), 2**40))
def test_truncated_grades_are_the_exact_ones_without_decimals(knots, x):
    cell, fall, rise = IntegerPartition(knots).locate(x, "truncate")
    inside = min(max(x, knots[0]), knots[-1])
    left, right = knots[cell], knots[cell + 1]
    assert left <= inside <= right
    assert rise == 255 * (inside - left) // (right - left)
    assert fall == 255 * (right - inside) // (right - left)
    assert rise + fall in (254, 255)


@given(KNOTS, st.integers(-(2**40), 2**40))
def test_rounded_grades_are_the_nearest_and_complements(knots, x):
    cell, fall, rise = IntegerPartition(knots).locate(x, "nearest")
    inside = min(max(x, knots[0]), knots[-1])
    width = knots[cell + 1] - knots[cell]
    assert abs(rise * width - 255 * (inside - knots[cell])) * 2 <= width
    assert rise + fall == 255


@given(KNOTS, st.lists(st.integers(-(2**40), 2**40), min_size=1), st.sampled_from(ROUNDINGS))
def test_arrays_are_scalars_to_the_last_bit(knots, values, rounding):
    partition = IntegerPartition(knots)
    arrays = partition.locate_array(np.array(values, dtype=np.int64), rounding)
    assert [tuple(row) for row in np.stack(arrays, axis=1).tolist()] == [
        partition.locate(x, rounding) for x in values
    ]


def test_figure_3():
    partition = IntegerPartition.even(0, 400, 3)
    assert partition.knots.tolist() == [0, 200, 400]
    assert partition.locate(0, "truncate") == (0, 255, 0)
    assert partition.locate(200, "truncate") == (1, 255, 0)
    assert partition.locate(100, "truncate") == (0, 127, 127)
    assert partition.locate(400, "truncate") == (1, 0, 255)


def test_even_knots_are_rounded_and_span_the_range():
    partition = IntegerPartition.even(0, 300, 33)
    assert (len(partition), partition.low, partition.high) == (33, 0, 300)
    assert set(np.diff(partition.knots).tolist()) == {9, 10}


@pytest.mark.parametrize(
    ("knots", "words"),
    [
        ([0], "2 to 33 knots, got 1"),
        (range(34), "2 to 33 knots, got 34"),
        ([0, 5, 5], "5 followed by 5"),
        ([0, 7, 3], "7 followed by 3"),
        ([0, 32768], "32768"),
        ([0.0, 1.5], r"integers, got \[0.0, 1.5\]"),
        (["a", "b"], "integers"),
    ],
)
def test_bad_knots(knots, words):
    with pytest.raises(ValueError, match=words):
        IntegerPartition(knots)


@pytest.mark.parametrize("count", [0, 1, 34, -3])
def test_bad_count_of_labels(count):
    with pytest.raises(ValueError, match=f"2 to 33 labels, got {count}"):
        IntegerPartition.even(0, 400, count)


def test_a_range_too_short_for_its_labels():
    with pytest.raises(ValueError, match="increase strictly"):
        IntegerPartition.even(0, 3, 9)
