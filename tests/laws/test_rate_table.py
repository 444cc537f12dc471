"""Rate control from a look-up table."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.laws.rate_table import rate_table


def test_entries_are_the_rules():
    ticks = np.linspace(-1.0, 1.0, 9)
    np.testing.assert_allclose(rate_table(9), np.outer(ticks, ticks), rtol=0, atol=1e-15)
    with pytest.raises(ValueError, match="table_size"):
        rate_table(1)


def test_a_finer_table_comes_nearer_to_the_rules():
    rng = np.random.default_rng(0)
    J, dr = rng.normal(size=(200, 3, 7)), rng.uniform(-0.05, 0.05, (200, 3))
    exact = fd.FuzzyRateControl(sweeps=2)(J, dr)
    off = [
        np.abs(fd.FuzzyRateControl(sweeps=2, table_size=size)(J, dr) - exact).max()
        for size in (33, 129, 513, 2049)
    ]
    assert all(b < 0.5 * a for a, b in zip(off, off[1:])) and off[-1] < 1e-3


def test_one_case_is_the_batch():
    law = fd.FuzzyRateControl(table_size=101)
    rng = np.random.default_rng(1)
    for _ in range(20):
        J, dr = rng.normal(size=(3, 6)), rng.uniform(-0.3, 0.3, 3)
        np.testing.assert_allclose(law.step(J, dr), law(J, dr), rtol=0, atol=1e-12)
    assert np.isnan(law(np.full((3, 2), np.nan), np.zeros(3))).all()
    assert np.isnan(law.step(np.full((3, 2), np.nan), np.zeros(3))).all()


def test_dead_band_and_bad_sizes():
    law = fd.FuzzyRateControl(table_size=21)  # an entry each centimetre
    J = np.eye(2)
    assert (law(J, np.array([0.004, -0.004])) == 0.0).all()
    assert (law(J, np.array([0.006, -0.006])) != 0.0).all()
    for size in (1, -3):
        with pytest.raises(ValueError, match="table_size"):
            fd.FuzzyRateControl(table_size=size)
    with pytest.raises(ValueError, match="'smooth'"):
        fd.FuzzyRateControl("paper", table_size=9)
