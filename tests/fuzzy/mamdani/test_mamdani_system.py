"""What a Mamdani system promises beside its numbers."""

import dataclasses
import itertools
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani import FuzzyRule, MamdaniConfig, MamdaniSystem
from fikm_drake.fuzzy.mamdani.mamdani_config import DEFUZZIFICATIONS
from fikm_drake.fuzzy.memberships import Gaussian, Trapezoid, Triangle
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

ALL_CHOICES = [
    dict(zip(("norm", "implication", "aggregation", "defuzzification"), combination))
    for combination in itertools.product(
        ("minimum", "product"),
        ("minimum", "product"),
        ("maximum", "sum"),
        DEFUZZIFICATIONS,
    )
]
rng = np.random.default_rng(0)
POINTS = rng.uniform([-0.1, -1.2], [1.1, 1.2], (1200, 2))


def one_output(shapes, labels, *, lower=0.0, upper=10.0, default=None, **choices):
    """Rule k fires as strongly as input k is large: strengths are inputs."""
    inputs = [
        FuzzyVariable(f"s{k}", "", 0.0, 1.0, {"on": Triangle(0.0, 1.0, 1.0)})
        for k in range(len(labels))
    ]
    output = FuzzyVariable("z", "m", lower, upper, shapes, default)
    rules = [FuzzyRule({f"s{k}": "on"}, {"z": label}) for k, label in enumerate(labels)]
    return MamdaniSystem(MamdaniConfig("one", inputs, [output], rules, **choices))


@pytest.mark.parametrize("choices", ALL_CHOICES, ids=lambda choices: "-".join(choices.values()))
def test_one_point_and_many_give_the_same(make_config, choices):
    system = MamdaniSystem(make_config(**choices))
    values, fired = system(POINTS)
    single = np.array([system(point).values for point in POINTS[::40]])
    np.testing.assert_allclose(single, values[::40], rtol=0.0, atol=1e-10)
    blocks = system(POINTS.reshape(3, 4, 100, 2))
    np.testing.assert_allclose(blocks.values.reshape(-1, 2), values, rtol=0.0, atol=1e-10)
    assert blocks.fired.shape == (3, 4, 100, 2) and fired.all()


@pytest.mark.parametrize("choices", ALL_CHOICES, ids=lambda choices: "-".join(choices.values()))
def test_is_equivariant_in_the_unit_of_the_output(make_config, choices):
    """Degrees to radians, and the other way round: only the numbers of the output change."""
    degrees = make_config(**choices)
    mirrored = {"smallest_of_maximum": "largest_of_maximum"}
    mirrored |= {last: first for first, last in mirrored.items()}
    method = mirrored.get(choices["defuzzification"], choices["defuzzification"])
    radians = make_config(**{**choices, "defuzzification": method})
    scale = -math.pi / 180.0
    angle = radians.outputs[0]
    angle.lower, angle.upper = scale * angle.upper, scale * angle.lower
    angle.memberships = {
        "down": Trapezoid(*(scale * c for c in (-20.0, -60.0, -100.0, -120.0))),
        "level": Triangle(*(scale * c for c in (33.0, 3.0, -45.0))),
        "up": Trapezoid(*(scale * c for c in (80.0, 80.0, 70.0, 10.0))),
    }
    expected = scale * MamdaniSystem(degrees)(POINTS).values[:, 0]
    np.testing.assert_allclose(MamdaniSystem(radians)(POINTS).values[:, 0], expected, atol=1e-9)


@given(st.permutations(range(6)))
def test_the_order_of_the_rules_does_not_matter(make_config, order):
    config = make_config(aggregation="sum", defuzzification="mean_of_maximum")
    expected = MamdaniSystem(config)(POINTS[:50]).values
    config.rules = [config.rules[k] for k in order]
    np.testing.assert_allclose(MamdaniSystem(config)(POINTS[:50]).values, expected, atol=1e-9)


def test_height_of_triangles_and_products_is_the_sugeno_rule_base():
    """Xu and Nechyba's equations 16-19, which `RuleBase` has as bilinear interpolation."""
    first, second = TriangularPartition([0.0, 0.3, 1.0]), TriangularPartition([-1.0, 0.5, 2.0])
    peaks = rng.uniform(-5.0, 5.0, (3, 3))
    shapes = {f"{i}{j}": Triangle(p - 1.0, p, p + 2.0) for (i, j), p in np.ndenumerate(peaks)}
    config = MamdaniConfig(
        name="sugeno",
        inputs=[
            FuzzyVariable.from_partition("x", first),
            FuzzyVariable.from_partition("y", second),
        ],
        outputs=[FuzzyVariable("z", "", -7.0, 7.0, shapes)],
        rules=[
            FuzzyRule({"x": first.labels[i], "y": second.labels[j]}, {"z": f"{i}{j}"})
            for i, j in np.ndindex(3, 3)
        ],
        norm="product",
        aggregation="sum",
        defuzzification="height",
    )
    x = rng.uniform([-0.2, -1.2], [1.2, 2.2], (500, 2))
    expected = RuleBase(first, second, peaks)(*x.T)
    np.testing.assert_allclose(MamdaniSystem(config)(x).values[:, 0], expected, atol=1e-12)


def test_centroids_by_hand():
    """A triangle (0, 3, 6) cut at one half is a trapezoid of area 2.25 about 3."""
    shapes = {"low": Triangle(0.0, 3.0, 6.0), "high": Triangle(6.0, 9.0, 9.0)}
    for aggregation in ("maximum", "sum"):
        system = one_output(shapes, ["low", "high"], aggregation=aggregation)
        assert system([0.5, 0.0]).values[0] == pytest.approx(3.0, abs=1e-9)
        # The whole of the other one: area 1.5, centroid 8.
        both = (2.25 * 3.0 + 1.5 * 8.0) / 3.75
        assert system([0.5, 1.0]).values[0] == pytest.approx(
            both, abs=1e-9 + 1e-3 * (aggregation == "maximum")
        )


@given(st.lists(st.floats(0.02, 1.0), min_size=3, max_size=3))
def test_without_overlap_the_maximum_is_the_sum(strengths):
    """Narrow memberships too, which an even grid would miss: the sum needs none."""
    shapes = {
        "narrow": Triangle(1.0, 1.001, 1.003),
        "wide": Trapezoid(2.0, 3.0, 4.0, 5.0),
        "edge": Triangle(7.0, 7.0, 7.1),
    }
    for implication, tolerance in (("minimum", 1e-2), ("product", 1e-9)):
        sampled, exact = (
            one_output(shapes, list(shapes), aggregation=aggregation, implication=implication)
            for aggregation in ("maximum", "sum")
        )
        values = sampled(strengths).values, exact(strengths).values
        np.testing.assert_allclose(*values, rtol=0.0, atol=tolerance)


def test_a_narrow_gaussian_weighs_its_area():
    shapes = {"bell": Gaussian(2.0, 1e-3), "box": Trapezoid(8.0, 8.0, 8.01, 8.01)}
    for aggregation in ("maximum", "sum"):
        system = one_output(shapes, ["bell", "box"], implication="product", aggregation=aggregation)
        area = 1e-3 * math.sqrt(2.0 * math.pi)
        expected = (area * 2.0 + 0.01 * 8.005) / (area + 0.01)
        assert system([1.0, 1.0]).values[0] == pytest.approx(expected, abs=1e-4)


def test_means_of_maxima_by_hand():
    shapes = {"low": Triangle(0.0, 2.0, 4.0), "high": Trapezoid(4.0, 6.0, 7.0, 9.0)}
    cut = one_output(shapes, ["low", "high"], defuzzification="mean_of_maximum")
    assert cut([0.5, 0.2]).values[0] == pytest.approx(2.0)
    assert cut([0.2, 0.5]).values[0] == pytest.approx(6.5)
    # Tops [1, 3] and [5, 8] together: (2·2 + 3·6.5) / 5.
    assert cut([0.5, 0.5]).values[0] == pytest.approx(4.7)
    scaled = one_output(
        shapes, ["low", "high"], implication="product", defuzzification="mean_of_maximum"
    )
    assert scaled([0.5, 0.4]).values[0] == pytest.approx(2.0)
    assert scaled([0.5, 0.5]).values[0] == pytest.approx(6.5)  # an interval outweighs a point


def test_first_and_last_of_maxima_by_hand():
    shapes = {"low": Triangle(0.0, 2.0, 4.0), "high": Trapezoid(4.0, 6.0, 7.0, 9.0)}
    for method, ends in (("smallest", [1.0, 5.0, 1.0]), ("largest", [3.0, 8.0, 8.0])):
        for aggregation in ("maximum", "sum"):
            system = one_output(
                shapes,
                ["low", "high"],
                aggregation=aggregation,
                defuzzification=f"{method}_of_maximum",
            )
            values = system([[0.5, 0.2], [0.2, 0.5], [0.5, 0.5]]).values[:, 0]
            np.testing.assert_allclose(values, ends, rtol=0.0, atol=1e-9)


def test_bisectors_by_hand():
    shapes = {"low": Triangle(0.0, 2.0, 4.0), "high": Trapezoid(6.0, 6.0, 8.0, 8.0)}
    for aggregation in ("maximum", "sum"):
        system = one_output(
            shapes,
            ["low", "high"],
            implication="product",
            aggregation=aggregation,
            defuzzification="bisector",
        )
        # Areas 2 and 2: half is on either side of the whole gap from 4 to 6, whose middle is 5. Then
        # the triangle alone; then areas 2 and 1: 1.5 of 2 are left of 4 - s with s²/4 = 0.5.
        values = system([[1.0, 1.0], [0.4, 0.0], [1.0, 0.5]]).values[:, 0]
        np.testing.assert_allclose(values, [5.0, 2.0, 4.0 - 2.0**0.5], rtol=0.0, atol=1e-5)


def test_tops_that_are_points_count_alike():
    shapes = {"low": Triangle(0.0, 2.0, 4.0), "high": Triangle(5.0, 7.0, 9.0)}
    for aggregation in ("maximum", "sum"):
        system = one_output(
            shapes,
            ["low", "high"],
            implication="product",
            aggregation=aggregation,
            defuzzification="mean_of_maximum",
        )
        assert system([0.5, 0.5]).values[0] == pytest.approx(4.5)


def test_a_sum_grows_where_conclusions_agree():
    """Why the paper adds: two weak rules with one label outvote one stronger rule."""
    shapes = {"low": Triangle(0.0, 2.0, 4.0), "high": Triangle(5.0, 7.0, 9.0)}
    choices = {"defuzzification": "mean_of_maximum"}
    maximum = one_output(shapes, ["low", "low", "high"], aggregation="maximum", **choices)
    total = one_output(shapes, ["low", "low", "high"], aggregation="sum", **choices)
    assert maximum([0.4, 0.4, 0.6]).values[0] == pytest.approx(7.0)
    assert total([0.4, 0.4, 0.6]).values[0] == pytest.approx(2.0)


def test_a_sum_of_gaussians_has_its_top_between_them():
    shapes = {"low": Gaussian(4.0, 1.5), "high": Gaussian(6.0, 1.5)}
    for implication in ("minimum", "product"):
        system = one_output(
            shapes,
            ["low", "high"],
            implication=implication,
            aggregation="sum",
            defuzzification="mean_of_maximum",
        )
        assert system([1.0, 1.0]).values[0] == pytest.approx(5.0, abs=0.02)


@pytest.mark.parametrize("choices", ALL_CHOICES, ids=lambda choices: "-".join(choices.values()))
def test_no_rule_fires(choices):
    shapes = {"low": Triangle(0.0, 2.0, 4.0), "high": Gaussian(7.0, 1.0)}
    del choices["norm"]
    middle = one_output(shapes, ["low", "high"], **choices)
    values, fired = middle([[0.0, 0.0], [math.nan, 0.0], [math.nan, 1.0], [math.inf, -math.inf]])
    np.testing.assert_array_equal(fired[:, 0], [False, False, True, True])
    np.testing.assert_array_equal(values[:2, 0], 5.0)
    assert np.isfinite(values).all()
    chosen = one_output(shapes, ["low", "high"], default=1.5, **choices)
    assert chosen([0.0, 0.0]).values[0] == 1.5


def test_outputs_fire_each_for_itself(make_config):
    config = make_config()
    config.rules = [config.rules[0], FuzzyRule({"y": "high"}, {"angle": "up"})]
    values, fired = MamdaniSystem(config)([1.0, 1.0])
    np.testing.assert_array_equal(fired, [True, False])
    assert values[1] == 1.0


@pytest.mark.parametrize("strength", [1e-300, 1e-99, 1e-30, 1e-12, 1.0])
@pytest.mark.parametrize("choices", ALL_CHOICES, ids=lambda choices: "-".join(choices.values()))
def test_weak_rules_are_no_trouble(strength, choices):
    choices = {key: value for key, value in choices.items() if key != "norm"}
    system = one_output({"low": Triangle(1.0, 2.0, 3.0)}, ["low"], **choices)
    values, fired = system([strength])
    assert fired[0] == (strength > 1e-100)
    # A weak conclusion is cut off low down: its top reaches from nearly 1 to nearly 3.
    half = 1.0 - strength if choices["implication"] == "minimum" else 0.0
    ends = {"smallest_of_maximum": 2.0 - half, "largest_of_maximum": 2.0 + half}
    expected = ends.get(choices["defuzzification"], 2.0) if fired[0] else 5.0
    assert values[0] == pytest.approx(expected, abs=1e-6)


def test_infinity_is_the_end_of_the_range(make_config):
    system = MamdaniSystem(make_config())
    ends, infinities = ([[1.0, -1.0]], [[math.inf, -math.inf]])
    np.testing.assert_array_equal(system(infinities).values, system(ends).values)


def test_no_points(make_config):
    values, fired = MamdaniSystem(make_config())(np.zeros((0, 2)))
    assert values.shape == fired.shape == (0, 2)


@pytest.mark.parametrize("shape", [(), (3,), (2, 3), (0,), (2, 1)])
def test_refuses_wrong_shapes(make_config, shape):
    system = MamdaniSystem(make_config())
    message = r"inputs must have shape \(\.\.\., 2\): x \[m\], y \[m\]; got"
    with pytest.raises(ValueError, match=message):
        system(np.zeros(shape))
    with pytest.raises(ValueError, match=message):
        system.strengths(np.zeros(shape))


def test_does_not_change(make_config):
    config = make_config()
    system = MamdaniSystem(config)
    before = system(POINTS).values
    config.inputs[0].memberships["mid"].peak = 0.4
    system.config.rules.clear()
    np.testing.assert_array_equal(system(POINTS).values, before)
    assert system.config == make_config()
    assert repr(system) == "<MamdaniSystem angle, speed(x, y), 6 rules>"


def test_goes_to_another_process(make_config):
    system = MamdaniSystem(make_config(norm="product"))
    again = pickle.loads(pickle.dumps(system))
    np.testing.assert_array_equal(again(POINTS).values, system(POINTS).values)


def test_does_not_write_into_its_input(make_config):
    x = POINTS.copy()
    MamdaniSystem(make_config())(x)
    np.testing.assert_array_equal(x, POINTS)


def test_a_system_can_be_varied(make_config):
    config = dataclasses.replace(make_config(), defuzzification="height")
    assert MamdaniSystem(config).config.defuzzification == "height"
