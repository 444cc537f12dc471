"""The count of changes of sign, against one that is written out plainly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.control.gain_supervision import GainSupervision
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.sign_changes import SignChanges

VALUES = st.sampled_from([-2.0, -1.0, -0.05, 0.0, 0.05, 1.0, 2.0, np.nan, np.inf, -np.inf])
SERIES = st.integers(1, 4).flatmap(
    lambda n: st.lists(st.lists(VALUES, min_size=n, max_size=n), min_size=1, max_size=30)
)


def count_plainly(series, window, dead_band):
    """Changes of one element between two of the last `window` cycles."""
    last, flips = 0, []
    for x in series:
        sign = int(np.sign(x)) if np.isfinite(x) and abs(x) > dead_band else 0
        flips.append(sign * last < 0)
        last = sign or last
    return sum(flips[-(window - 1) :])


@given(series=SERIES, window=st.integers(2, 12))
def test_counts_like_plain_counting(series, window):
    changes = SignChanges(len(series[0]), window=window, dead_band=0.1)
    memory = changes.initial_memory()
    for vector in series:
        changes.remember(memory, np.array(vector))
    expected = [count_plainly(column, window, 0.1) for column in zip(*series)]
    np.testing.assert_array_equal(changes.count(memory), expected)


@given(series=SERIES)
def test_the_largest_count_is_that_of_gain_supervision(series):
    """Section 2.7 counts alike, over all joints at once."""
    config = GainSupervisorConfig(dead_band=0.1)
    supervision = GainSupervision(1, len(series[0]), config)
    changes = SignChanges(len(series[0]), window=config.window, dead_band=config.dead_band)
    theirs, ours = supervision.initial_memory(), changes.initial_memory()
    for vector in series:
        supervision.remember(theirs, np.zeros(1), np.array(vector), np.zeros(1))
        changes.remember(ours, np.array(vector))
        largest = changes.count(ours).max()
        assert supervision.oscillating(theirs) == (largest >= config.sign_changes)


@pytest.mark.parametrize("period", [1, 2, 3])
def test_a_square_wave_has_a_change_each_half_period(period):
    changes = SignChanges(1, window=10, dead_band=0.0)
    memory = changes.initial_memory()
    for k in range(60):
        changes.remember(memory, np.array([1.0 if (k // period) % 2 else -1.0]))
    assert changes.count(memory)[0] == 9 // period
