"""What every law of the registry promises, on any Jacobian: finite, bounded, still without an error,
independent of the unit of length, and never against the error where a law says so."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.laws import LAWS, named_law

OPTIONS = {
    "FuzzyMapping iterations": fd.FuzzyMapping(iterations=2),
    "FuzzyMapping direct solve": fd.FuzzyMapping(iterations=6, damping=0.1, row_floor=0.05),
    "FuzzyMapping iterated": fd.FuzzyMapping.iterated(),
    "FuzzyMapping error damping": fd.FuzzyMapping(iterations=2, error_damping=2.0),
    "FuzzyMapping floors": fd.FuzzyMapping(row_floor=0.3, column_floor=0.3),
    "FuzzyMapping rule bases": fd.FuzzyMapping("direct"),
    "DampedLeastSquares small": fd.DampedLeastSquares(1e-4),
    "PseudoInverse cut off": fd.PseudoInverse(1e-2),
    "FuzzyRateControl sweeps": fd.FuzzyRateControl(sweeps=3),
    "FuzzyRateControl paper": fd.FuzzyRateControl("paper", sweeps=2),
}
EVERY = {name: named_law(name) for name in LAWS} | OPTIONS
RULES = ("FuzzyMapping rule bases", "FuzzyRateControl paper")
"""These have universes: outside them the error is cut, so they promise less."""
EXACT = [name for name in EVERY if name not in RULES]
LINEAR = [
    name for name in EXACT if "Rate" not in name and not getattr(EVERY[name], "error_damping", 0.0)
]
KINDS = (
    "dense",
    "sparse",
    "zero row",
    "zero column",
    "rank one",
    "zero",
    "tiny column",
    "huge row",
)


def problem(seed, kind, scale=1.0):
    """A Jacobian of 1 to 6 rows and 1 to 60 columns and an error, in metres times `scale`."""
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(1, 7)), int(rng.integers(1, 61 if rng.random() < 0.3 else 9))
    J = rng.normal(size=(m, n))
    if kind == "sparse":
        J *= rng.random((m, n)) < 0.5
    elif kind == "zero row":
        J[rng.integers(m)] = 0.0
    elif kind == "zero column":
        J[:, rng.integers(n)] = 0.0
    elif kind == "rank one":
        J = np.outer(J[:, 0], J[0])
    elif kind == "zero":
        J = 0.0 * J
    elif kind == "tiny column":
        J[:, rng.integers(n)] *= 1e-8
    elif kind == "huge row":
        J[rng.integers(m)] *= 1e6
    return scale * J, scale * 10.0 ** rng.uniform(-6.0, 0.0) * rng.normal(size=m)


cases = {"seed": st.integers(0, 10**6), "kind": st.sampled_from(KINDS)}


def scaled(law, scale):
    """The law in another unit of length: what it has in metres times `scale`."""
    lengths = {
        name: scale * getattr(law, name)
        for name, of in (
            ("damping", fd.DampedLeastSquares),
            ("error_range", fd.FuzzyRateControl),
        )
        if isinstance(law, of)
    }
    return dataclasses.replace(law, **lengths)


def within(law, J):
    """The Jacobian, inside the range that a law with rule bases was made for."""
    return np.clip(J, -1.5, 1.5) if getattr(law, "method", "") == "direct" else J


def row_weights(law, J):
    """R⁻¹ of the fuzzy law, ones for the others: the metric in which it does not go against the error."""
    rows = np.abs(J).sum(axis=1)
    if not isinstance(law, fd.FuzzyMapping) or not rows.max() > 0.0:
        return np.ones(len(J))
    floored = np.hypot(rows, law.row_floor * rows.max())
    seen = rows > law.zero_threshold * rows.max()
    return np.where(seen, 1.0 / np.where(seen, floored, 1.0), 0.0)


@pytest.mark.parametrize("name", EVERY)
@settings(max_examples=60, deadline=None)
@given(**cases, exponent=st.floats(-6.0, 6.0))
def test_a_finite_problem_has_a_finite_step(name, seed, kind, exponent):
    J, error = problem(seed, kind, 10.0**exponent)
    J = within(EVERY[name], J)
    step = EVERY[name].step(J, error)
    assert step.shape == J.shape[1:] and np.isfinite(step).all()


@pytest.mark.parametrize("name", EVERY)
@settings(max_examples=30, deadline=None)
@given(**cases)
def test_without_an_error_nothing_moves(name, seed, kind):
    J, error = problem(seed, kind)
    assert not EVERY[name].step(within(EVERY[name], J), 0.0 * error).any()


@pytest.mark.parametrize("name", EXACT)
@settings(max_examples=60, deadline=None)
@given(**cases)
def test_the_tool_goes_not_against_the_error_and_no_farther_than_it(name, seed, kind):
    """In the law's metric; the Gauss-Seidel passes of rate control may go on to twice the error."""
    law = EVERY[name]
    J, error = problem(seed, kind)
    weights, motion = row_weights(law, J), J @ law.step(J, error)
    asked = np.sqrt(weights.dot(error**2))
    assert (weights * error).dot(motion) >= -1e-7 * asked**2
    most = 2.0 if isinstance(law, fd.FuzzyRateControl) else 1.0
    assert np.sqrt(weights.dot(motion**2)) <= (most + 1e-6) * asked
    rest = np.sqrt(weights.dot((error - motion) ** 2))
    assert rest <= (1.0 + 1e-6) * asked


@pytest.mark.parametrize("name", ["DampedLeastSquares", "DampedLeastSquares small"])
@settings(max_examples=30, deadline=None)
@given(**cases)
def test_damping_bounds_the_joint_step(name, seed, kind):
    """|dθ| ≤ |dr| / 2λ: σ / (σ² + λ²) is largest at σ = λ."""
    law = EVERY[name]
    J, error = problem(seed, kind)
    bound = np.linalg.norm(error) / (2.0 * law.damping)
    assert np.linalg.norm(law.step(J, error)) <= bound * (1 + 1e-6)


@pytest.mark.parametrize("name", EXACT)
@settings(max_examples=40, deadline=None)
@given(seed=cases["seed"], kind=st.sampled_from(KINDS[:5]), exponent=st.floats(-4.0, 4.0))
def test_the_step_does_not_depend_on_the_unit_of_length(name, seed, kind, exponent):
    law, scale = EVERY[name], 10.0**exponent
    J, error = problem(seed, kind)
    if np.linalg.matrix_rank(J) < len(J) and isinstance(law, fd.DampedLeastSquares):
        return  # what rounding makes of a rank is not the law's
    size = np.abs(law.step(J, error)).max()
    other = scaled(law, scale).step(scale * J, scale * error)
    np.testing.assert_allclose(other, law.step(J, error), rtol=0, atol=1e-5 * size + 1e-300)


@pytest.mark.parametrize("name", LINEAR)
@settings(max_examples=40, deadline=None)
@given(seed=cases["seed"], kind=st.sampled_from(KINDS[:5]), factor=st.floats(1e-3, 1e3))
def test_twice_the_error_is_twice_the_step(name, seed, kind, factor):
    law = EVERY[name]
    J, error = problem(seed, kind)
    step = law.step(J, error)
    # Nearly as much as rounding moves a step that is damped by 1e-4 at a singular J.
    bound = 1e-4 * factor * np.abs(step).max() + 1e-300
    np.testing.assert_allclose(law.step(J, factor * error), factor * step, rtol=0, atol=bound)
