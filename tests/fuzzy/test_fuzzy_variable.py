"""Fuzzy variables."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.memberships import Gaussian, Trapezoid, Triangle
from fikm_drake.fuzzy.triangular_partition import TriangularPartition


def variable(**changes):
    values = {
        "name": "x",
        "unit": "m",
        "lower": 0.0,
        "upper": 2.0,
        "memberships": {
            "high": Gaussian(2.0, 0.5),
            "low": Trapezoid(0.0, 0.0, 0.4, 1.0),
            "mid": Triangle(0.0, 1.0, 2.0),
        },
    }
    return FuzzyVariable(**{**values, **changes})


def test_labels_are_in_the_order_of_their_cores():
    assert variable().labels == ("low", "mid", "high")
    assert variable().axis == "x [m]"
    assert variable(unit="").axis == "x"


def test_grades_are_in_the_order_of_the_labels():
    x = np.array([[0.1, 0.7], [1.0, 1.9]])
    grades = variable().grades(x)
    assert grades.shape == (2, 2, 3)
    for column, label in enumerate(("low", "mid", "high")):
        np.testing.assert_array_equal(grades[..., column], variable().memberships[label](x))


def test_values_outside_the_range_are_its_ends():
    np.testing.assert_array_equal(
        variable().grades([-9.0, math.inf]), variable().grades([0.0, 2.0])
    )
    assert np.isnan(variable().grades(math.nan)).all()


@given(
    st.lists(st.floats(0.1, 5.0), min_size=1, max_size=5),
    st.floats(-20.0, 20.0),
)
def test_from_a_partition(gaps, x):
    partition = TriangularPartition(np.cumsum([-3.0, *gaps]))
    made = FuzzyVariable.from_partition("x", partition, unit="rad")
    assert made.labels == partition.labels
    np.testing.assert_allclose(made.grades(x), partition.grades(x), atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": ""}, "needs a name"),
        ({"lower": 2.0}, "'x': lower must be less than upper, got 2.0 and 2.0"),
        ({"upper": math.inf}, "'x': upper must be a finite number, got inf"),
        ({"lower": math.nan}, "'x': lower must be a finite number, got nan"),
        ({"upper": {}}, "'x': upper must be a finite number, got {}"),
        ({"memberships": {}}, "'x': needs at least one membership"),
        ({"default": 3.0}, r"'x': default must be in \[0.0, 2.0\], got 3.0"),
        ({"default": math.nan}, "default must be a finite number, got nan"),
        ({"memberships": {"A": (0, 1, 2)}}, r"'A' must be a Triangle, .* got \(0, 1, 2\)"),
        ({"memberships": {"": Triangle(0, 1, 2)}}, "a label must not be empty"),
        ({"memberships": {"not far": Triangle(0, 1, 2)}}, "or begin with 'not '"),
        ({"memberships": {"deg": Triangle(0, 45, 90)}}, r"'deg' must reach grade 1 in the range"),
        ({"memberships": {"spike": Gaussian(1.0, 1e-11)}}, "'spike' must .* not be a point there"),
        ({"memberships": {"edge": Triangle(-1, 0, 0)}}, r"'edge' must reach grade 1 in the range"),
    ],
)
def test_refuses(changes, message):
    with pytest.raises(ValueError, match=message):
        variable(**changes)


def test_a_shape_that_was_changed_is_checked_again():
    changed = variable()
    changed.memberships["mid"].peak = 5.0
    with pytest.raises(ValueError, match="'x', membership 'mid': Triangle: corners must increase"):
        changed.validate()
