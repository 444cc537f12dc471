"""Shapes of memberships against their definitions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy.membership_stack import MembershipStack
from fikm_drake.fuzzy.memberships import Gaussian, Trapezoid, Triangle

# Rounded: a vertical edge is as wide as the spacing of doubles.
values = st.floats(-100.0, 100.0).map(lambda value: round(value, 9))


def corners(count):
    spread = st.lists(values, min_size=count, max_size=count).map(sorted)
    return spread.filter(lambda points: points[-1] - points[0] > 1e-3)


def shapes():
    return st.one_of(
        corners(3).map(lambda points: Triangle(*points)),
        corners(4).map(lambda points: Trapezoid(*points)),
        st.builds(Gaussian, values, st.floats(0.01, 50.0)),
    )


def linear(x, left, top_left, top_right, right):
    """A trapezoid's grade by its definition."""
    if top_left <= x <= top_right:
        return 1.0
    if left < x < top_left:
        return (x - left) / (top_left - left)
    return (right - x) / (right - top_right) if top_right < x < right else 0.0


@given(corners(4), values)
def test_trapezoid(points, x):
    assert Trapezoid(*points)(x) == pytest.approx(linear(x, *points), abs=1e-12)


@given(corners(3), values)
def test_a_triangle_is_a_trapezoid_with_a_point_on_top(points, x):
    left, peak, right = points
    assert Triangle(*points)(x) == Trapezoid(left, peak, peak, right)(x)


@given(values, st.floats(0.01, 50.0), values)
def test_gaussian(mean, sigma, x):
    expected = math.exp(-((x - mean) ** 2) / (2.0 * sigma**2))
    assert Gaussian(mean, sigma)(x) == pytest.approx(expected, rel=1e-12, abs=1e-300)


@given(corners(4))
def test_corners_are_exact(points):
    shape = Trapezoid(*points)
    np.testing.assert_array_equal(shape(shape.core), 1.0)
    for corner, top in ((points[0], points[1]), (points[3], points[2])):
        assert shape(corner) == float(corner == top)


def test_a_vertical_edge_belongs_to_the_top():
    shoulder = Triangle(0.0, 0.0, 1.0)
    np.testing.assert_array_equal(shoulder([-1e-9, 0.0, 0.5, 1.0]), [0.0, 1.0, 0.5, 0.0])
    box = Trapezoid(-3.0, -3.0, 2.0, 2.0)
    np.testing.assert_array_equal(box([-3.1, -3.0, 0.0, 2.0, 2.1]), [0.0, 1.0, 1.0, 1.0, 0.0])


@given(shapes(), st.integers(0, 3))
def test_takes_any_shape_of_values(shape, ndim):
    x = np.linspace(-50.0, 50.0, 2**ndim).reshape((2,) * ndim)
    grades = shape(x)
    assert grades.shape == x.shape
    np.testing.assert_array_equal(grades.ravel(), [shape(value) for value in x.ravel()])
    assert np.all((grades >= 0.0) & (grades <= 1.0))


@pytest.mark.parametrize("shape", [Triangle(0, 1, 2), Trapezoid(0, 1, 2, 3), Gaussian(0, 1)])
def test_nan_in_gives_nan_out(shape):
    assert math.isnan(shape(math.nan))
    np.testing.assert_array_equal(shape([math.inf, -math.inf]), 0.0)


@given(st.lists(shapes(), min_size=1, max_size=6), values)
def test_a_stack_is_its_shapes(members, x):
    stacked = MembershipStack(members).grades(np.array([[x]]))
    np.testing.assert_array_equal(stacked[:, 0], [shape(x) for shape in members])


@given(st.lists(shapes(), min_size=1, max_size=6), st.floats(0.01, 1.0))
def test_a_cut_ends_where_the_grade_is_the_level(members, level):
    ends = MembershipStack(members).cuts(np.full((len(members), 1), level))
    for shape, left, right in zip(members, *ends):
        assert left <= right
        middle, outside = 0.5 * (left + right), 1e-3 * (right - left) + 1e-3
        assert shape(middle) >= level - 1e-9
        assert shape(left - outside) < level and shape(right + outside) < level


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Triangle(0.0, 2.0, 1.0),
            r"Triangle: corners must increase, got \(0.0, 2.0, 1.0\)",
        ),
        (lambda: Triangle(1.0, 1.0, 1.0), "Triangle: corners must increase"),
        (lambda: Triangle(0.0, 1.0), "Triangle: right must be a finite number, got nan"),
        (lambda: Triangle("a", 1.0, 2.0), "Triangle: left must be a finite number, got 'a'"),
        (lambda: Trapezoid(0.0, 3.0, 2.0, 4.0), "Trapezoid: corners must increase"),
        (lambda: Trapezoid(0.0, 1.0, 2.0, math.inf), "Trapezoid: right .* got inf"),
        (lambda: Gaussian(0.0, 0.0), "Gaussian: sigma must be positive, got 0.0"),
        (lambda: Gaussian(0.0, -1.0), "Gaussian: sigma must be positive, got -1.0"),
        (lambda: Gaussian(0.0), "Gaussian: sigma must be a finite number, got nan"),
    ],
)
def test_refuses(make, message):
    with pytest.raises(ValueError, match=message):
        make()
