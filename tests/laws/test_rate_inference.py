"""The rules of Kim & Lee 1993 taken one by one, against the closed forms of the law."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.laws.rate_inference import (
    INFERENCE,
    paper_one,
    rate_rules,
    rule_texts,
    smooth_one,
)

ROWS = st.lists(
    st.tuples(st.floats(-0.3, 0.3), st.floats(-1.0, 1.0)), min_size=1, max_size=6
)  # dr [m], J / L


def grades(dr, j, D):
    """Figure 4: grades of dr in N, Z, P and of J in N, P."""
    a = float(np.clip(dr / D, -1.0, 1.0))
    return {"N": max(-a, 0.0), "Z": 1.0 - abs(a), "P": max(a, 0.0)}, {
        "N": (1.0 - j) / 2.0,
        "P": (1.0 + j) / 2.0,
    }


def truths(dr, j, D):
    """Truth of the five rules of one row, product AND, joined by the label of dθ."""
    error, column = grades(dr, j, D)
    return {
        "P": [column["N"] * error["N"], column["P"] * error["P"]],  # rules 1 and 4
        "N": [column["P"] * error["N"], column["N"] * error["P"]],  # rules 2 and 3
        "Z": [error["Z"]],  # rule 5
    }


@given(ROWS, st.floats(0.05, 0.2), st.floats(0.1, 3.0))
def test_paper_is_zadehs_or_and_the_height_method(rows, D, L):
    truth = {"P": 0.0, "N": 0.0, "Z": 0.0}
    for dr, j in rows:
        for label, values in truths(dr, j, D).items():
            truth[label] = max(truth[label], *values)
    expected = D / L * (truth["P"] - truth["N"]) / sum(truth.values())
    error, column = [dr for dr, _ in rows], [L * j for _, j in rows]
    assert paper_one(column, error, 1.0 / L, D) == pytest.approx(expected, abs=1e-12)


@given(ROWS, st.floats(0.1, 3.0))
def test_smooth_is_the_sum_of_the_rows(rows, L):
    """Inside the universe of dr, D = 0.3 m; the rules' weights of a row sum to one."""
    D = 0.3
    pushes = [sum(t["P"]) - sum(t["N"]) for t in (truths(dr, j, D) for dr, j in rows)]
    error, column = [dr for dr, _ in rows], [L * j for _, j in rows]
    assert smooth_one(column, error, 1.0 / L, D) == pytest.approx(D / L * sum(pushes), abs=1e-12)


@given(st.floats(-2.0, 2.0), st.floats(-1.0, 1.0))
def test_the_rule_base_infers_one_rows_push(a, j):
    assert rate_rules().evaluate(a, j) == pytest.approx(np.clip(a, -1.0, 1.0) * j, abs=1e-12)


def test_one_row_is_the_same_for_both():
    """With one row there is nothing to join: the weights of paper's mean sum to less than one."""
    for dr, j in ((0.05, 1.0), (-0.02, 1.0), (0.07, -1.0)):
        assert paper_one([j], [dr], 1.0, 0.1) == pytest.approx(smooth_one([j], [dr], 1.0, 0.1))


@pytest.mark.parametrize("variant", INFERENCE)
def test_many_equal_one_by_one(variant):
    many, one = INFERENCE[variant]
    rng = np.random.default_rng(0)
    column, error = rng.uniform(-1, 1, (2, 3, 50))
    inverse = rng.uniform(0.2, 0.5, 50)
    expected = [
        one(c.tolist(), e.tolist(), float(i), 0.4) for c, e, i in zip(column.T, error.T, inverse)
    ]
    np.testing.assert_allclose(many(column, error, inverse, 0.4), expected, rtol=1e-13)


def test_rules_read_as_in_the_paper():
    assert len(rule_texts()) == 5
    assert rule_texts()[0] == "IF J is N AND dr is N THEN dθ is P"
    assert rule_texts()[4] == "IF dr is Z THEN dθ is Z"
