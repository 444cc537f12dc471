"""Triangular memberships: partition of unity, and what is refused."""

import copy
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy import TriangularPartition

values = st.floats(-1e3, 1e3)


@st.composite
def partitions(draw):
    start = draw(st.floats(-10.0, 10.0))
    gaps = draw(st.lists(st.floats(1e-3, 10.0), min_size=1, max_size=8))
    return TriangularPartition(np.cumsum([start, *gaps]))


@given(partitions(), st.lists(values, max_size=6))
def test_grades_are_a_partition_of_unity(partition, x):
    grades = partition.grades(x)
    assert grades.shape == (len(x), len(partition))
    assert np.all(grades >= 0.0)
    np.testing.assert_allclose(grades.sum(axis=-1), 1.0, atol=1e-15)
    assert np.all((grades > 0.0).sum(axis=-1) <= 2)


@given(partitions(), values)
def test_grades_are_the_triangles_of_figure_4(partition, x):
    for k, grade in enumerate(partition.grades(x)):
        triangle = np.interp(x, partition.knots, np.eye(len(partition))[k])
        assert grade == pytest.approx(triangle, abs=1e-12)


@given(partitions())
def test_each_membership_peaks_at_its_knot(partition):
    np.testing.assert_array_equal(partition.grades(partition.knots), np.eye(len(partition)))


@given(partitions(), st.floats(allow_nan=False))
def test_locate_agrees_with_locate_array(partition, x):
    index, fraction = partition.locate(x)
    indices, fractions = partition.locate_array([x])
    assert (index, fraction) == (indices[0], fractions[0])
    assert 0 <= index <= len(partition) - 2
    assert 0.0 <= fraction <= 1.0


@pytest.mark.parametrize(("x", "grades"), [(-9.0, [1, 0, 0]), (9.0, [0, 0, 1])])
@pytest.mark.parametrize("factor", [1.0, math.inf])
def test_outermost_membership_holds_outside(x, grades, factor):
    np.testing.assert_array_equal(TriangularPartition([-1, 0, 1]).grades(x * factor), grades)


def test_nan_stays_nan_and_does_not_spread():
    partition = TriangularPartition([-1.0, 0.0, 1.0])
    index, fraction = partition.locate(math.nan)
    assert 0 <= index <= 1
    assert math.isnan(fraction)
    grades = partition.grades([math.nan, 0.5])
    assert np.all(np.isnan(grades[0]))
    np.testing.assert_array_equal(grades[1], [0.0, 0.5, 0.5])


def test_grades_keep_the_shape_of_the_input():
    partition = TriangularPartition([0.0, 1.0, 3.0])
    assert partition.grades(0.5).shape == (3,)
    assert partition.grades(np.zeros((2, 5))).shape == (2, 5, 3)
    assert partition.grades(np.zeros((0,))).shape == (0, 3)


def test_labels_continue_after_z():
    labels = TriangularPartition(range(54)).labels
    assert labels[:3] == ("A", "B", "C")
    assert labels[25:28] == ("Z", "AA", "AB")
    assert labels[51:] == ("AZ", "BA", "BB")


def test_does_not_change():
    knots = np.array([0.0, 1.0])
    partition = TriangularPartition(knots)
    knots[0] = 0.5
    assert partition.knots[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        partition.knots[0] = 0.5
    with pytest.raises(AttributeError):
        partition.knots = knots


def test_can_be_copied_and_pickled():
    partition = TriangularPartition([0.0, 1.0], ["S", "B"])
    for other in (copy.deepcopy(partition), pickle.loads(pickle.dumps(partition))):
        assert other.labels == ("S", "B")
        assert other.locate(0.25) == (0, 0.25)


@pytest.mark.parametrize(
    ("knots", "labels", "message"),
    [
        ([0.0], None, r"at least 2 values.*\(1,\)"),
        ([[0.0, 1.0]], None, r"\(1, 2\)"),
        ([0.0, math.nan], None, "finite, got nan"),
        ([0.0, math.inf], None, "finite, got inf"),
        ([0.0, 2.0, 1.5], None, "2.0 followed by 1.5"),
        ([0.0, 1.0, 1.0], None, "1.0 followed by 1.0"),
        ([-1.7e308, 1.7e308], None, "too far apart"),
        ([0.0, 1.0], ["S"], "1 labels .* 2 knots"),
        ([0.0, 1.0], ["S", "S"], "differ"),
    ],
)
def test_refuses(knots, labels, message):
    with pytest.raises(ValueError, match=message):
        TriangularPartition(knots, labels)
