"""The Sugeno rule base against equations 16-19 taken literally."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fikm_drake.fuzzy import RuleBase, TriangularPartition

inputs = st.floats(-30.0, 30.0)


@st.composite
def partitions(draw):
    start = draw(st.floats(-10.0, 10.0))
    gaps = draw(st.lists(st.floats(1e-3, 10.0), min_size=1, max_size=5))
    return TriangularPartition(np.cumsum([start, *gaps]))


@st.composite
def rule_bases(draw):
    first, second = draw(partitions()), draw(partitions())
    shape = (len(first), len(second))
    return RuleBase(first, second, draw(hnp.arrays(float, shape, elements=st.floats(-5.0, 5.0))))


def truth_table_output(rules, x, y):
    """Equations 18 and 19: the truth of every rule, then the sum of truth times consequent."""
    total = 0.0
    for a, row in zip(rules.first.grades(x), rules.consequents):
        for b, w in zip(rules.second.grades(y), row):
            total += a * b * w
    return total


@pytest.fixture
def small():
    first = TriangularPartition([-0.1, 0.1])
    second = TriangularPartition([-1.0, 0.0, 2.0])
    return RuleBase(
        first, second, [[0.2498, 0, -1], [-0.2498, -1e-9, 1]], names=("dr", "J", "dtheta")
    )


@given(rule_bases(), inputs, inputs)
def test_equations_18_and_19(rules, x, y):
    assert rules.evaluate(x, y) == pytest.approx(truth_table_output(rules, x, y), abs=1e-13)


@given(rule_bases(), inputs, inputs)
def test_evaluate_is_the_same_as_call(rules, x, y):
    assert rules.evaluate(x, y) == pytest.approx(float(rules(x, y)), rel=1e-15, abs=1e-15)


@given(rule_bases())
def test_interpolates_the_consequents_at_the_knots(rules):
    x, y = np.meshgrid(rules.first.knots, rules.second.knots, indexing="ij")
    np.testing.assert_array_equal(rules(x, y), rules.consequents)


@given(rule_bases(), inputs, inputs)
def test_output_stays_within_the_consequents(rules, x, y):
    w = rules.consequents
    assert w.min() - 1e-12 <= rules.evaluate(x, y) <= w.max() + 1e-12


@given(partitions(), partitions(), inputs, inputs, st.tuples(*[st.floats(-2.0, 2.0)] * 4))
def test_bilinear_functions_are_exact(first, second, x, y, coefficients):
    a, b, c, d = coefficients

    def function(x, y):
        return a + b * x + c * y + d * x * y

    rules = RuleBase(first, second, function(*np.ix_(first.knots, second.knots)))
    x = np.clip(x, first.knots[0], first.knots[-1])
    y = np.clip(y, second.knots[0], second.knots[-1])
    assert rules.evaluate(x, y) == pytest.approx(function(x, y), abs=1e-9)


@given(partitions(), partitions(), st.data())
def test_monotone_consequents_give_a_monotone_output(first, second, data):
    steps = data.draw(hnp.arrays(float, (len(first), len(second)), elements=st.floats(0.0, 1.0)))
    rules = RuleBase(first, second, np.cumsum(steps, axis=0))
    x = np.linspace(first.knots[0] - 1.0, first.knots[-1] + 1.0, 40)
    y = data.draw(inputs)
    assert np.all(np.diff(rules(x, y)) >= -1e-12)


@given(rule_bases(), inputs, inputs, st.floats(0.1, 10.0), st.floats(-10.0, 10.0))
def test_scaled_changes_the_ranges_only(rules, x, y, first_factor, output_factor):
    scaled = rules.scaled(first_factor, output_factor)
    expected = output_factor * rules.evaluate(x, y)
    knots = rules.first.knots
    tolerance = 1e-14 * np.abs(knots).max() / np.diff(knots).min()
    assert scaled.evaluate(first_factor * x, y) == pytest.approx(
        expected, abs=100.0 * (tolerance + 1e-14)
    )


def test_section_3_doubling_is_exact_to_the_last_bit(small):
    doubled = small.scaled(2.0, 2.0)
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-0.15, 0.15, 500), rng.uniform(-2.0, 3.0, 500)
    np.testing.assert_array_equal(doubled(2.0 * x, y), 2.0 * small(x, y))
    assert doubled.names == small.names


def test_broadcasts(small):
    assert small(np.zeros((4, 1)), np.zeros(3)).shape == (4, 3)
    assert np.shape(small(0.0, 0.0)) == ()
    assert small(np.zeros(0), 1.0).shape == (0,)


def test_nan_in_gives_nan_out(small):
    for x, y in ((math.nan, 0.0), (0.0, math.nan)):
        assert math.isnan(small.evaluate(x, y))
        assert np.isnan(small(x, y))


def test_infinity_is_the_end_of_the_range(small):
    assert small.evaluate(math.inf, -math.inf) == -0.2498
    assert float(small(math.inf, -math.inf)) == -0.2498


def test_rules_read_as_equation_17(small):
    assert small.size == 6
    rules = small.rules()
    assert len(rules) == 6
    assert rules[0] == "IF dr is A AND J is A THEN dtheta is 0.2498"
    assert rules[4] == "IF dr is B AND J is B THEN dtheta is -1e-09"


def test_table_is_a_grid_like_table_2(small):
    lines = small.table().splitlines()
    assert lines[0].split() == ["dr", "\\", "J", "A", "B", "C"]
    assert lines[1].split() == ["A", "0.2498", "0.0000", "-1.0000"]
    assert lines[2].split() == ["B", "-0.2498", "0.0000", "1.0000"]
    assert len(set(map(len, lines))) == 1


def test_does_not_change(small):
    with pytest.raises(ValueError, match="read-only"):
        small.consequents[0, 0] = 1.0


@pytest.mark.parametrize(
    ("consequents", "names", "message"),
    [
        ([[0.0, 1.0]], ("x", "y", "z"), r"\(2, 2\), got \(1, 2\)"),
        ([[0.0, 1.0], [math.nan, 0.0]], ("x", "y", "z"), "finite, got nan"),
        (np.zeros((2, 2)), ("x", "y"), "three"),
    ],
)
def test_refuses(consequents, names, message):
    partition = TriangularPartition([0.0, 1.0])
    with pytest.raises(ValueError, match=message):
        RuleBase(partition, partition, consequents, names)


@pytest.mark.parametrize("factors", [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (1.0, math.inf)])
def test_scaled_refuses(small, factors):
    with pytest.raises(ValueError, match="factor must be finite"):
        small.scaled(*factors)
