"""Rule generation: Table II of Xu and Nechyba (1993), and fewer rules by least squares."""

import math

import numpy as np
import pytest

from fikm_drake.fuzzy import RuleBase
from fikm_drake.laws.rule_generation import data_table, generate_rule_base

E_MAX = 0.0013
RANGES = [0.05, 0.2, 0.5, 1.0, 1.5, 2.2, 5.0]


@pytest.fixture(scope="module")
def araki():
    return generate_rule_base(1.5)


@pytest.fixture(scope="module")
def least_squares():
    return generate_rule_base(1.5, method="least_squares")


def assert_antisymmetric(rules):
    for partition in (rules.first, rules.second):
        np.testing.assert_array_equal(partition.knots, -partition.knots[::-1])
    np.testing.assert_array_equal(rules.consequents, -rules.consequents[::-1])
    np.testing.assert_array_equal(rules.consequents, -rules.consequents[:, ::-1])


def true_error(rules, j_max, dr_max=0.1):
    dr, jacobian, dtheta = data_table(j_max, dr_max).T
    return np.mean(np.abs(rules(dr, jacobian) - dtheta))


# The paper's generator


def test_table_2_number_of_rules_and_error(araki):
    assert araki.method == "araki"
    assert araki.converged
    assert araki.error < E_MAX
    assert araki.consequents.shape[0] == 3
    assert 11 <= araki.consequents.shape[1] <= 17
    assert araki.size == araki.consequents.size


def test_table_2_outer_consequents(araki):
    np.testing.assert_allclose(
        araki.consequents[0, :4], [0.0667, 0.1163, 0.2502, 0.4749], rtol=0.03
    )


def test_table_2_is_antisymmetric_and_its_middle_row_zero(araki):
    assert_antisymmetric(araki)
    assert not np.any(araki.consequents[1])


def test_figure_8_and_figure_9_knots(araki):
    np.testing.assert_array_equal(araki.first.knots, [-0.1, 0.0, 0.1])
    knots = araki.second.knots
    np.testing.assert_array_equal(knots[[0, -1]], [-1.5, 1.5])
    widths = np.diff(knots[knots >= 0.0])
    assert np.all(np.diff(widths) >= 0.0)  # the nearer to J = 0, the denser
    assert widths[0] < 0.05


def test_history_and_splits_tell_the_same_story(araki):
    assert araki.history[-1] == araki.error
    assert all(error >= E_MAX for error in araki.history[:-1])
    assert {split.input for split in araki.splits} == {"J"}
    assert 3 + 2 * len(araki.splits) == len(araki.second)
    for split in araki.splits:
        assert araki.history[split.epoch - 1] == split.error_before
        assert split.knot in araki.second.knots
        assert -split.knot in araki.second.knots


def test_table_error_is_the_error_after_training(araki):
    assert araki.table_error == pytest.approx(true_error(araki, 1.5), rel=1e-12)
    assert araki.error < araki.table_error < 2.0 * E_MAX


def test_dtheta_is_linear_in_dr_within_the_rules(araki, least_squares):
    dr, jacobian = np.meshgrid(np.linspace(-0.1, 0.1, 21), np.linspace(-1.5, 1.5, 31))
    for rules in (araki, least_squares):
        np.testing.assert_allclose(rules(dr, jacobian), dr / 0.1 * rules(0.1, jacobian), atol=1e-13)


def test_zero_jacobian_gives_zero(araki, least_squares):
    for rules in (araki, least_squares):
        assert rules.evaluate(0.1, 0.0) == pytest.approx(0.0, abs=1e-12)


def test_section_3_the_range_of_dr_is_trivially_extended(araki):
    """Doubling the consequents gives what generation over twice the range gives."""
    doubled = araki.scaled(2.0, 2.0)
    generated = generate_rule_base(1.5, dr_max=0.2, max_error=2 * E_MAX, min_change=1e-5)
    np.testing.assert_array_equal(doubled.first.knots, generated.first.knots)
    np.testing.assert_array_equal(doubled.consequents, generated.consequents)
    assert doubled.table_error == pytest.approx(generated.table_error)
    assert doubled.error == generated.error
    assert doubled.splits == generated.splits
    assert (doubled.dr_max, doubled.j_max) == (0.2, 1.5)


@pytest.mark.parametrize("j_max", [0.2, 0.6, 4.0])
def test_thresholds_in_proportion_give_the_same_rules_on_another_scale(araki, j_max):
    scale = 1.5 / j_max
    other = generate_rule_base(j_max, max_error=scale * E_MAX, min_change=scale * 5e-6)
    np.testing.assert_allclose(other.second.knots * scale, araki.second.knots, rtol=1e-12)
    np.testing.assert_allclose(other.consequents, scale * araki.consequents, rtol=1e-6)


def test_more_is_asked_than_the_bounds_allow():
    rules = generate_rule_base(0.3, max_memberships=9, max_epochs=60)
    assert not rules.converged
    assert rules.error >= E_MAX
    assert rules.error == rules.history[-1]
    assert len(rules.history) <= 60
    assert len(rules.second) <= 9
    assert_antisymmetric(rules)


@pytest.mark.parametrize("j_max", [0.2, 1.0, 3.0, 5.0])
def test_dr_never_needs_a_membership(j_max):
    """Section 3: since dθ is linear in dr, more memberships of dr do not lower the error."""
    rules = generate_rule_base(j_max)
    assert len(rules.first) == 3
    assert len(rules.second) <= 41
    assert_antisymmetric(rules)
    assert rules.table_error == pytest.approx(true_error(rules, j_max), rel=1e-12)


# Least squares


def test_fewer_rules_than_the_paper_for_a_smaller_true_error(araki, least_squares):
    assert least_squares.table_error < E_MAX
    assert least_squares.size <= 36
    assert least_squares.size < araki.size
    assert least_squares.table_error < araki.table_error


@pytest.mark.parametrize("j_max", RANGES)
def test_least_squares_meets_the_bound_at_every_range(j_max):
    rules = generate_rule_base(j_max, method="least_squares")
    assert rules.converged
    assert true_error(rules, j_max) < E_MAX
    assert rules.error == rules.table_error
    assert rules.consequents.shape[0] == 2
    assert rules.j_max == j_max
    assert_antisymmetric(rules)


def test_a_wider_range_needs_no_more_rules():
    sizes = [generate_rule_base(j_max, method="least_squares").size for j_max in RANGES]
    assert sizes == sorted(sizes, reverse=True)


def test_a_tighter_bound_needs_no_fewer_rules():
    bounds = [0.01, 0.005, 0.002, 0.001, 0.0005]
    rules = [generate_rule_base(1.5, method="least_squares", max_error=e) for e in bounds]
    sizes = [rule_base.size for rule_base in rules]
    assert sizes == sorted(sizes)
    assert all(r.table_error < e for r, e in zip(rules, bounds))


def test_ranges_are_scales_of_one_design(least_squares):
    other = generate_rule_base(3.0, method="least_squares", dr_max=0.4, max_error=2 * E_MAX)
    np.testing.assert_allclose(other.second.knots, 2.0 * least_squares.second.knots, rtol=1e-14)
    np.testing.assert_allclose(other.consequents, 2.0 * least_squares.consequents, rtol=1e-14)


def test_a_loose_bound_needs_the_least_rule_base():
    assert generate_rule_base(1.5, method="least_squares", max_error=1.0).size == 4


def test_consequents_are_optimal_for_the_knots(least_squares):
    """No other height at any knot lowers the error by more than a thousandth."""
    error = least_squares.table_error
    for column in range(least_squares.consequents.shape[1]):
        for factor in (0.98, 1.02):
            consequents = least_squares.consequents.copy()
            consequents[:, column] *= factor
            other = RuleBase(least_squares.first, least_squares.second, consequents)
            assert true_error(other, 1.5) > 0.999 * error


# Arguments


def test_results_are_cached():
    assert generate_rule_base(1.5) is generate_rule_base(1.5, method="araki")
    assert generate_rule_base(2) is generate_rule_base(2.0)


@pytest.mark.parametrize("method", ["araki", "least_squares"])
@pytest.mark.parametrize("name", ["j_max", "dr_max", "max_error"])
@pytest.mark.parametrize("value", [0.0, -1.5, math.nan, math.inf])
def test_refuses_values_that_are_not_finite_and_positive(method, name, value):
    arguments = {"j_max": 1.5, name: value}
    with pytest.raises(ValueError, match=f"{name} must be finite and positive, got {value}"):
        generate_rule_base(**arguments, method=method)


def test_refuses_an_unknown_method():
    with pytest.raises(ValueError, match=r"\['araki', 'least_squares'\], got 'anfis'"):
        generate_rule_base(1.5, method="anfis")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("learning_rate", 0.0),
        ("learning_rate", 2.0),
        ("learning_rate", math.nan),
        ("min_change", -1e-6),
        ("min_change", math.nan),
        ("max_memberships", 2),
        ("max_epochs", 0),
    ],
)
def test_refuses_options(name, value):
    with pytest.raises(ValueError, match=f"{name} must be .*, got {value}"):
        generate_rule_base(1.5, **{name: value})


def test_refuses_options_of_the_other_method():
    with pytest.raises(TypeError, match="learning_rate"):
        generate_rule_base(1.5, method="least_squares", learning_rate=0.5)


def test_refuses_an_error_below_the_floor_and_names_it():
    floor = 0.06 / 1.5 / 2001
    with pytest.raises(ValueError, match=rf"J = 0 alone contribute {floor:.3g}"):
        generate_rule_base(1.5, method="least_squares", max_error=floor)
