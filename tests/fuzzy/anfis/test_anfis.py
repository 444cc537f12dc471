"""The learner: what it learns, keeps, writes and refuses."""

import tracemalloc

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.fuzzy.anfis.projection import LeastSquares
from fikm_drake.fuzzy.anfis.training import METHODS

LINKS = 10.0, 7.0


def two_link_arm():
    """The data of MATLAB's demonstration: both joints in steps of 0.1 rad over [0, π/2] and [0, π]."""
    first, second = np.meshgrid(np.arange(0, np.pi / 2, 0.1), np.arange(0, np.pi, 0.1))
    first, second = first.ravel(), second.ravel()
    x = LINKS[0] * np.cos(first) + LINKS[1] * np.cos(first + second)
    y = LINKS[0] * np.sin(first) + LINKS[1] * np.sin(first + second)
    return np.column_stack([x, y]), first, second


def two_link_angles(x, y):
    """The joints with the elbow bent to the left."""
    first, second = LINKS
    bend = np.arccos((x**2 + y**2 - first**2 - second**2) / (2 * first * second))
    ahead = np.arctan2(second * np.sin(bend), first + second * np.cos(bend))
    return np.arctan2(y, x) - ahead, bend


@pytest.fixture(scope="module")
def wave():
    """A smooth function of two inputs in odd units."""
    rng = np.random.default_rng(0)
    X = rng.uniform([-300.0, 1e-3], [500.0, 3e-3], (600, 2))
    return X, np.sin(X[:, 0] / 150) * np.cos(1500 * X[:, 1])


@pytest.mark.parametrize("kind", ["gaussian", "bell"])
@pytest.mark.parametrize("method", METHODS)
def test_learns_better_than_its_first_least_squares(kind, method, wave):
    X, Y = wave
    anfis = fd.Anfis((4, 4), kind).fit(X, Y, epochs=25, method=method)
    errors = anfis.training_error
    assert len(errors) == 25
    assert errors.min() < 0.75 * errors[0]
    measured = np.sqrt(np.mean((anfis.predict(X) - Y) ** 2))
    assert measured == pytest.approx(errors.min(), rel=1e-9)


def test_variable_projection_never_gets_worse(wave):
    X, Y = wave
    errors = fd.Anfis((3, 3)).fit(X, Y, epochs=30, method="variable_projection").training_error
    assert (np.diff(errors) <= 1e-6 * errors[0] + 0.05 * errors[1:]).all()  # but for the ridge
    assert errors[-1] < 0.3 * errors[0]


def test_matlab_two_link_demonstration():
    """Its page reaches θ1 max 0.0199, rms 0.0044 rad, θ2 0.0459 and 0.0093, 0 ≤ x ≤ 2, 8 ≤ y ≤ 10."""
    X, *joints = two_link_arm()
    x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 2.01, 0.1), np.arange(8, 10.01, 0.1)))
    cases = zip(joints, two_link_angles(x, y), (7, 6), (0.0199, 0.0459), (0.0044, 0.0093))
    for theta, expected, memberships, largest, rms in cases:
        anfis = fd.Anfis((memberships, memberships))
        anfis.fit(X, theta, epochs=60, method="variable_projection")
        error = anfis.predict(np.column_stack([x, y])) - expected
        assert np.abs(error).max() < largest
        assert np.sqrt(np.mean(error**2)) < rms


@pytest.mark.parametrize("order", [0, 1])
def test_linear_functions_are_exact_and_read_so(order):
    rng = np.random.default_rng(1)
    X = rng.uniform([2.0, -1.0], [4.0, 5.0], (200, 2))
    Y = 7.0 + (3.0 * X[:, 0] - 2.0 * X[:, 1]) * order
    anfis = fd.Anfis((2, 2), order=order, names=("r", "phi", "theta")).fit(X, Y, epochs=2)
    np.testing.assert_allclose(anfis.predict(X), Y, atol=1e-5)
    rules = anfis.rules()
    assert len(rules) == 4
    assert rules[0].startswith("IF r is about ") and " AND phi is about " in rules[0]
    consequents = {rule.split(" THEN ")[1] for rule in rules}
    assert consequents == {"theta = 7 + 3 r - 2 phi" if order else "theta = 7"}


@pytest.mark.parametrize("method", METHODS)
def test_memory_is_bounded_however_many_rows(method):
    """The matrix of least squares alone would take 84 MB here, 120 MB with derivatives."""
    rng = np.random.default_rng(5)
    X = rng.uniform(-1, 1, (375_000, 2))
    Y = X.prod(axis=1)
    tracemalloc.start()
    fd.Anfis((3, 3)).fit(X, Y, epochs=1, method=method).predict(X)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 60e6


def test_one_and_three_inputs():
    rng = np.random.default_rng(2)
    for counts in ((6,), (3, 2, 3)):
        X = rng.uniform(-1, 1, (800, len(counts)))
        Y = np.cos(2 * X).prod(axis=1)
        anfis = fd.Anfis(counts).fit(X, Y, epochs=10, method="variable_projection")
        assert np.abs(anfis.predict(X) - Y).max() < 0.1
        assert anfis.num_rules == np.prod(counts) == len(anfis.rules())


def test_best_epoch_of_the_validation_data_is_kept(wave):
    X, Y = wave
    rng = np.random.default_rng(3)
    noisy = Y[:120] + rng.normal(0, 0.1, 120)
    held = X[120:], Y[120:]
    anfis = fd.Anfis((5, 5)).fit(
        X[:120], noisy, epochs=20, method="variable_projection", validation=held
    )
    errors = anfis.validation_error
    assert len(errors) == 20 and errors.argmin() < 19
    measured = np.sqrt(np.mean((anfis.predict(held[0]) - held[1]) ** 2))
    assert measured == pytest.approx(errors.min(), rel=1e-9)


def test_the_same_data_give_the_same_rules_whatever_was_learned_before(wave):
    X, Y = wave
    once = fd.Anfis((3, 3)).fit(X, Y, epochs=3)
    again = fd.Anfis((3, 3)).fit(X, -5 * Y, epochs=2).fit(X, Y, epochs=3)
    np.testing.assert_array_equal(once.predict(X), again.predict(X))


def test_units_of_inputs_and_output_do_not_matter(wave):
    X, Y = wave
    plain = fd.Anfis((3, 3)).fit(X, Y, epochs=6, method="variable_projection")
    scaled = fd.Anfis((3, 3)).fit(2 * X, 1024 * Y, epochs=6, method="variable_projection")
    np.testing.assert_allclose(scaled.predict(2 * X), 1024 * plain.predict(X), atol=1e-6)


def test_an_interruption_keeps_the_best_so_far(wave):
    X, Y = wave
    anfis = fd.Anfis((3, 3))

    def stop(fraction):
        if fraction >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        anfis.fit(X, Y, epochs=8, progress=stop)
    assert len(anfis.training_error) == 4
    measured = np.sqrt(np.mean((anfis.predict(X) - Y) ** 2))
    assert measured == pytest.approx(anfis.training_error.min(), rel=1e-9)


def test_an_interruption_before_the_first_epoch_changes_nothing(wave, monkeypatch):
    X, Y = wave
    anfis = fd.Anfis((3, 3)).fit(X, Y, epochs=2)
    before = anfis.predict(X)

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(LeastSquares, "project", stop)
    with pytest.raises(KeyboardInterrupt):
        anfis.fit(10 * X, Y, epochs=2)
    np.testing.assert_array_equal(anfis.predict(X), before)


def test_far_outside_the_data_it_is_held(wave):
    X, Y = wave
    anfis = fd.Anfis((3, 3)).fit(X, Y, epochs=2)
    lower, upper = anfis.input_range
    edge = upper + 0.05 * (upper - lower)
    far = anfis.predict([1e9 * upper, [np.inf, np.inf], edge])
    np.testing.assert_allclose(far, far[2], rtol=1e-12)
    assert np.isnan(anfis.predict([[np.nan, lower[1]]])).all()
    assert anfis.predict(np.empty((0, 2))).shape == (0,)


def test_many_rows_are_predicted_as_one_by_one(wave):
    X, Y = wave
    anfis = fd.Anfis((3, 4)).fit(X, Y, epochs=1)
    many = anfis.predict(np.tile(X, (60, 1)))
    single = np.array([anfis.predict(row[None])[0] for row in X])
    np.testing.assert_allclose(many.reshape(60, -1), np.tile(single, (60, 1)), atol=1e-12)


@pytest.mark.parametrize("kind", ["gaussian", "bell"])
def test_file_round_trip_is_exact(kind, wave, tmp_path):
    X, Y = wave
    anfis = fd.Anfis((3, 4), kind, names=("a", "b", "c")).fit(X, Y, epochs=3, validation=(X, Y))
    anfis.save(tmp_path / "learned.yaml")
    read = fd.Anfis.load(tmp_path / "learned.yaml")
    np.testing.assert_array_equal(read.predict(X), anfis.predict(X))
    assert read.rules() == anfis.rules()
    assert (read.kind, read.order, read.names) == (kind, 1, ("a", "b", "c"))
    np.testing.assert_array_equal(read.training_error, anfis.training_error)
    np.testing.assert_array_equal(read.validation_error, anfis.validation_error)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("kind: gaussian", "kind: square", ["square", "gaussian"]),
        ("order: 1", "order: 2", ["order", "2"]),
        ("lower: [", "lower: [.nan, ", ["bounds"]),
        ("names: [x1, ", "names: [", ["names"]),
        ("coefficients:", "coefficients: []\nother:", ["other"]),
        ("kind", "kimd", ["kimd"]),
    ],
)
def test_a_bad_file_is_told_by_name(old, new, words, wave, tmp_path):
    X, Y = wave
    path = tmp_path / "learned.yaml"
    fd.Anfis((2, 2)).fit(X, Y, epochs=1).save(path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(ValueError) as error:
        fd.Anfis.load(path)
    for word in ["learned.yaml", *words]:
        assert word in str(error.value)


def test_untrained_says_so():
    anfis = fd.Anfis((2, 3))
    for use in (lambda: anfis.predict([[0.0, 0.0]]), anfis.rules, anfis.to_data):
        with pytest.raises(ValueError, match="call fit first"):
            use()
    assert "not trained" in repr(anfis)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"memberships": ()}, ["memberships", "()"]),
        ({"memberships": (8, 0)}, ["memberships", "(8, 0)"]),
        ({"memberships": (8, 2.5)}, ["memberships", "2.5"]),
        ({"kind": "triangle"}, ["triangle", "gaussian", "bell"]),
        ({"order": 2}, ["order", "2"]),
        ({"names": ("x", "y")}, ["names", "3"]),
    ],
)
def test_constructor_refuses(arguments, words):
    with pytest.raises(ValueError) as error:
        fd.Anfis(**arguments)
    for word in words:
        assert word in str(error.value)


GOOD = np.array([[0.0, 1.0], [1.0, 2.0], [2.0, 0.0]])


@pytest.mark.parametrize(
    ("X", "Y", "options", "words"),
    [
        (GOOD[:, :1], [0, 1, 2], {}, ["X", "(N, 2)", "(3, 1)"]),
        (GOOD, [0, 1], {}, ["Y", "(3,)", "(2,)"]),
        (GOOD[:0], [], {}, ["Y", "at least 1"]),
        (GOOD + [[np.nan, 0.0]], [0, 1, 2], {}, ["X", "row 0", "nan"]),
        (GOOD, [0, np.inf, 2], {}, ["Y", "row 1", "inf"]),
        (GOOD * [0, 1], [0, 1, 2], {}, ["x1", "always 0"]),
        (GOOD, [0, 1, 2], {"method": "luck"}, ["luck", "hybrid"]),
        (GOOD, [0, 1, 2], {"epochs": 0}, ["epochs", "0"]),
        (GOOD, [0, 1, 2], {"epochs": 2.5}, ["epochs", "2.5"]),
        (GOOD, [0, 1, 2], {"ridge": 0.0}, ["ridge", "0.0"]),
        (GOOD, [0, 1, 2], {"ridge": np.nan}, ["ridge", "nan"]),
        (GOOD, [0, 1, 2], {"validation": (GOOD, [1.0])}, ["validation Y", "(1,)"]),
    ],
)
def test_fit_refuses(X, Y, options, words):
    with pytest.raises(ValueError) as error:
        fd.Anfis((2, 2)).fit(X, Y, **options)
    for word in words:
        assert word in str(error.value)


@pytest.mark.parametrize("method", ["hybrid", "variable_projection"])
@pytest.mark.parametrize("slope", [0.0, 2.0])
def test_data_that_the_rules_meet_exactly(method, slope):
    """Nothing is left to gain, and what is foreseen of a step is rounding."""
    x = np.linspace(0.0, 1.0, 20)[:, None]
    anfis = fd.Anfis(memberships=(3,)).fit(x, slope * x[:, 0] + 1.0, epochs=10, method=method)
    np.testing.assert_allclose(anfis.predict(x), slope * x[:, 0] + 1.0, atol=1e-6)
    grid = np.array([[i, j] for i in range(6) for j in range(6)], float)
    plane = 6.0 * grid[:, 0] + grid[:, 1]
    anfis = fd.Anfis(memberships=(2, 2)).fit(grid, plane, epochs=5, method=method)
    np.testing.assert_allclose(anfis.predict(grid), plane, atol=1e-5)
