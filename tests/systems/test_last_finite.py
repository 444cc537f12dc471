"""What is passed on of a signal that is not always finite."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd

SIGNALS = st.lists(
    st.lists(st.sampled_from([-1.0, 0.0, 2.5, np.nan, np.inf, -np.inf]), min_size=2, max_size=2)
)


def test_passes_on_the_last_finite_sample(drive):
    @given(signals=SIGNALS)
    def check(signals):
        driver, last = drive(fd.LastFinite(2, period=0.01)), np.zeros(2)
        for signal in signals:
            good = bool(np.isfinite(signal).all())
            last = np.array(signal) if good else last
            outputs = driver.cycle(signal=np.array(signal))
            np.testing.assert_array_equal(outputs["finite_signal"], last)
            assert outputs["valid"] == good

    check()


def test_set_last_is_for_a_signal_that_has_not_been_finite(drive):
    block = fd.LastFinite(2, period=0.01)
    driver = drive(block)
    block.SetLast(driver.context, [1.0, -2.0])
    outputs = driver.cycle(signal=np.full(2, np.nan))
    np.testing.assert_array_equal(outputs["finite_signal"], [1.0, -2.0])
    for bad in ([1.0], [1.0, np.nan]):
        with pytest.raises(ValueError, match="value must be 2 finite numbers"):
            block.SetLast(driver.context, bad)


@pytest.mark.parametrize(("size", "period", "word"), [(0, 0.01, "size"), (2, 0.0, "period")])
def test_bad_arguments_are_named(size, period, word):
    with pytest.raises(ValueError, match=word):
        fd.LastFinite(size, period=period)
