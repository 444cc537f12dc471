"""The table of equation 12."""

import numpy as np
import pytest

from fikm_drake.laws.rule_generation import data_table, quarter_table, table_error


def test_equation_12_counts_and_ranges():
    table = data_table(1.5)
    assert table.shape == (12006, 3)
    dr, jacobian, dtheta = table.T
    np.testing.assert_allclose(dr, jacobian * dtheta, atol=1e-16)
    assert np.abs(dr).max() == pytest.approx(0.1)
    np.testing.assert_allclose(np.unique(jacobian), np.linspace(-1.5, 1.5, 2001), atol=1e-15)
    steps = np.diff(np.unique(dtheta))
    np.testing.assert_allclose(steps, 0.04 / 1.5)


def test_no_vector_is_repeated():
    assert len(np.unique(data_table(0.7), axis=0)) == 12006


def test_the_quarter_and_its_images_are_the_whole_table():
    dr, jacobian, dtheta = quarter_table(1.5).T
    images = [
        np.column_stack([p * q * dr, p * jacobian, q * dtheta]) for p in (1, -1) for q in (1, -1)
    ]
    # Adding zero merges the negative zeros at J = 0 with the positive ones.
    whole = np.unique(np.vstack(images) + 0.0, axis=0)
    expected = np.unique(data_table(1.5) + 0.0, axis=0)
    np.testing.assert_allclose(whole, expected, atol=1e-17)


def test_the_quarter_is_swept_outward():
    jacobian = quarter_table(1.5)[:, 1]
    assert jacobian[0] == 0.0
    assert np.all(np.diff(jacobian) >= 0.0)


def test_no_model_removes_the_error_at_zero_jacobian():
    def perfect(dr, jacobian):
        return np.divide(dr, jacobian, out=np.zeros_like(dr), where=jacobian != 0.0)

    assert table_error(perfect, 1.5) == pytest.approx(0.06 / 1.5 / 2001)


def test_error_of_no_model_is_the_mean_output():
    assert table_error(lambda dr, jacobian: 0.0 * dr, 2.0, 0.2) == pytest.approx(0.06)
