"""Fuzzy weights near joint limits: their rules, and what they do to a law's step."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import fikm_drake as fd
from fikm_drake.control.limit_weights import LimitWeights, limit_rules
from fikm_drake.control.safe_step import SafeStep

LOWER, UPPER = np.array([-1.0, -np.inf, -0.3, 0.0]), np.array([2.0, 0.5, 0.4, 0.2])
ZONE = 0.1
ZONES = [0.1, 0.1, 0.1, 0.05]  # at most a quarter of the range

fractions = hnp.arrays(float, 4, elements=st.floats(0, 1))
steps = hnp.arrays(float, 4, elements=st.floats(-0.5, 0.5))


def positions(fraction):
    """Positions inside the limits, the half of them within a zone."""
    low = np.maximum(LOWER, -3.0)
    inside = low + np.clip(2 * fraction - 0.5, 0, 1) * (UPPER - low)
    near = np.where(fraction < 0.5, inside, UPPER - ZONE * 2 * (1 - fraction))
    return np.clip(near, LOWER, UPPER)


@given(fractions, steps)
def test_the_closed_form_is_the_rules(fraction, step):
    """The smaller of the rules' answers for the two limits of a joint."""
    q, rules = positions(fraction), limit_rules()
    weights = LimitWeights(LOWER, UPPER, ZONE)(q, step)
    for j in np.flatnonzero(step):
        toward = np.sign(step[j])
        expected = min(
            rules(min((UPPER[j] - q[j]) / ZONES[j], 1.0), toward),
            rules(min((q[j] - LOWER[j]) / ZONES[j], 1.0), -toward),
        )
        assert weights[j] == pytest.approx(expected, abs=1e-12)


def test_the_rules_can_be_printed():
    rules = limit_rules()
    assert "IF distance is AT AND motion is TOWARD THEN w is 0" in rules.rules()
    assert rules.size == 4


@given(fractions, steps)
def test_only_a_joint_that_moves_toward_a_near_limit_counts_less(fraction, step):
    q, law = positions(fraction), LimitWeights(LOWER, UPPER, ZONE)
    weights = law(q, step)
    assert (weights >= 0).all() and (weights <= 1).all()
    near_upper, near_lower = q > UPPER - ZONES, q < LOWER + ZONES
    expected = np.select([step > 0, step < 0], [near_upper, near_lower], False)
    assert expected[weights < 1 - 1e-12].all() and (weights[expected] < 1).all()
    assert law.near(q) or not (near_upper | near_lower).any()


@given(fractions, steps)
def test_a_step_no_longer_than_the_zone_never_crosses_a_limit(fraction, step):
    q, step = positions(fraction), np.clip(step, -np.array(ZONES), ZONES)
    after = q + LimitWeights(LOWER, UPPER, ZONE)(q, step) * step
    assert (after >= LOWER - 1e-12).all() and (after <= UPPER + 1e-12).all()


def test_at_a_limit_a_joint_is_locked_from_one_side():
    law = LimitWeights(LOWER, UPPER, ZONE)
    np.testing.assert_array_equal(law(UPPER, np.ones(4)), 0.0)
    np.testing.assert_array_equal(law(UPPER, -np.ones(4)), 1.0)


@pytest.mark.parametrize(
    ("law", "most"),
    [(fd.FuzzyMapping(), 0.01), (fd.FuzzyMapping(iterations=3, damping=0.05), 0.2)],
)
def test_few_steps_of_a_law_are_cut_off_at_a_limit(law, most):
    """Those where the last pass turned a joint round, of the ones that would be cut off without."""
    rng = np.random.default_rng(0)
    free, safe = SafeStep(law), SafeStep(law, limits=LimitWeights(LOWER, UPPER, ZONE))
    crossed = {free: 0, safe: 0}
    for _ in range(2000):
        q, J, error = positions(rng.random(4)), rng.normal(size=(3, 4)), 0.01 * rng.normal(size=3)
        for step in (free, safe):
            after = q + step(q, J, error)
            crossed[step] += ((after < LOWER - 1e-12) | (after > UPPER + 1e-12)).any()
    assert crossed[free] > 500
    assert crossed[safe] <= most * crossed[free]


@pytest.mark.parametrize("law", [fd.FuzzyMapping(), fd.FuzzyMapping(iterations=3, damping=0.05)])
def test_far_from_the_limits_nothing_changes(law):
    rng = np.random.default_rng(1)
    safe = SafeStep(law, limits=LimitWeights(LOWER, UPPER, ZONE))
    q = np.array([0.0, 0.0, 0.0, 0.1])
    for _ in range(20):
        J, error = rng.normal(size=(3, 4)), rng.normal(size=3)
        np.testing.assert_array_equal(safe(q, J, error), law.step(J, error))


def test_the_other_joints_do_what_a_locked_one_cannot():
    """A pseudo-inverse of the columns that are left: the task is solved all the same."""
    law = fd.FuzzyMapping(iterations=3)
    safe = SafeStep(law, limits=LimitWeights(LOWER, UPPER, ZONE))
    rng = np.random.default_rng(2)
    solved = 0
    for _ in range(50):
        q = np.array([2.0, 0.0, 0.0, 0.1])  # the first is at its upper limit
        J, error = rng.normal(size=(3, 4)), 0.01 * rng.normal(size=3)
        free, step = law.step(J, error), safe(q, J, error)
        if free[0] <= 0:
            continue
        assert step[0] <= 0.0
        np.testing.assert_allclose(J @ step, error, atol=1e-8)
        solved += 1
    assert solved > 10


def test_a_joint_without_range_stays():
    """lower = upper: the zone is not zero, so nothing is divided by it."""
    law = LimitWeights(np.zeros(2), np.array([0.0, 1.0]), ZONE)
    np.testing.assert_array_equal(law(np.array([0.0, 0.5]), np.ones(2)), [0.0, 1.0])
