"""The rule viewer tells what the engines compute."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.fuzzy.mamdani.mamdani_config import DEFUZZIFICATIONS
from fikm_drake.fuzzy.teaching import fuzzy_view, plot_memberships, plot_rules, plot_surface
from fikm_drake.laws.rule_generation import generate_rule_base


def anfis(inputs):
    X = np.random.default_rng(0).uniform(-1.0, 1.0, (60, inputs))
    names = ("x", "y", "w")[:inputs]
    return fd.Anfis((2,) * inputs, names=(*names, "z")).fit(X, np.sin(X.sum(axis=1)), epochs=2)


SYSTEMS = {
    "generated": (lambda: generate_rule_base(0.5), [0.03, 0.2]),
    "supervisor": (lambda: fd.GainSupervision(3, 7), [1.2, 3.5]),
    "rate control": (fd.FuzzyRateControl, [0.3, -0.5]),
    "integer, min": (lambda: fd.IntegerFuzzyIk(labels=(5, 4)), [120, 80]),
    "integer, product": (
        lambda: fd.IntegerFuzzyIk(labels=(4, 4), conjunction="product", rounding="nearest"),
        [301, 222],
    ),
    "anfis of one": (lambda: anfis(1), [0.3]),
    "anfis of three": (lambda: anfis(3), [0.3, -0.5, 0.9]),
}


@pytest.fixture(params=SYSTEMS, scope="module")
def case(request):
    make, point = SYSTEMS[request.param]
    return make(), np.array(point, dtype=float)


def test_weighted_numbers_of_the_rules_are_the_output(case):
    system, point = case
    view = fuzzy_view(system)
    for k, variable in enumerate(view.outputs):
        told = view.explain(point, k)
        weights = np.array([rule.strength for rule in told.rules])
        numbers = np.array([rule.conclusion for rule in told.rules])
        assert ((weights >= 0.0) & (weights <= 1.0)).all()
        scale = variable.upper - variable.lower
        slack = 1.1 if "integer" in told.method else 1e-9 * scale  # a whole number is cut off
        assert told.value == pytest.approx(weights @ numbers / weights.sum(), abs=slack)
        assert told.value == view.values(point)[k]


def test_strength_is_what_the_drawn_grades_give(case):
    """The premise that is drawn is the one that the engine uses: minimum or product of grades."""
    system, point = case
    view = fuzzy_view(system)
    told = view.explain(point)
    grades = [variable.grades(np.array([x]))[0] for variable, x in zip(view.inputs, point)]
    joined = []
    for rule in told.rules:
        parts = [g[v.labels.index(rule.when[v.name][0])] for v, g in zip(view.inputs, grades)]
        minimum = getattr(getattr(system, "rules", None), "conjunction", "") == "min"
        joined.append(min(parts) if minimum else np.prod(parts))
    # An ANFIS shows its weights, grades over their sum.
    total = sum(joined) if isinstance(system, fd.Anfis) else 1.0
    strengths = [rule.strength for rule in told.rules]
    np.testing.assert_allclose(strengths, np.array(joined) / total, atol=1e-9)


def test_pictures_have_a_row_a_rule_and_the_result(case):
    system, point = case
    told = fuzzy_view(system).explain(point)
    name = told.output.name
    figure = plot_rules(system, point, name, most=3)
    shown = min(3, len(told.strongest()))
    assert len(figure.axes) == (shown + 1) * (len(point) + 1)
    assert f"{told.value:.4g}" in figure.axes[-1].get_title()
    low, high = figure.axes[-1].get_xlim()
    assert low <= told.value <= high
    assert plot_memberships(system).axes
    if len(point) <= 2:
        axes = plot_surface(system, name, resolution=6).axes[0]
        assert axes.get_xlabel() == fuzzy_view(system).inputs[0].axis


@pytest.mark.parametrize("method", DEFUZZIFICATIONS)
@pytest.mark.parametrize("aggregation", ["maximum", "sum"])
def test_united_conclusions_of_mamdani_rules(make_config, method, aggregation):
    system = fd.MamdaniSystem(make_config(defuzzification=method, aggregation=aggregation))
    told = fuzzy_view(system).explain([0.45, 0.2], 1)
    assert told.value == system([0.45, 0.2]).values[1]
    assert [rule.text for rule in told.rules] == [r for r in system.rules() if "speed" in r]
    for rule in told.rules:
        assert rule.said.max() == pytest.approx(rule.strength, abs=2e-2)
    if method == "centroid":
        drawn = (told.span * told.united).sum() / told.united.sum()
        assert drawn == pytest.approx(told.value, abs=0.02)
    if method in ("smallest_of_maximum", "largest_of_maximum"):
        top = told.span[told.united >= told.united.max() - 1e-9]
        assert told.value == pytest.approx(top[-(method != "smallest_of_maximum")], abs=0.02)


def test_text_lists_the_rules_that_fire_and_the_result():
    text = str(fd.fuzzy_view(fd.load_mamdani("labvolt_theta3")).explain([0.4, 0.1]))
    first, *rules, last = text.splitlines()
    assert first == "at x = 0.4, y = 0.1:"
    assert all(" IF x is " in line for line in rules)
    strengths = [float(line.split()[0]) for line in rules]
    assert strengths == sorted(strengths, reverse=True) and strengths[-1] > 0.0
    assert last.startswith("theta_3 [rad] = ") and last.endswith("by mean of maximum")


def test_where_no_rule_fires_the_picture_says_so():
    config = fd.load_mamdani("labvolt_theta3").config
    config.inputs[0].memberships["X1"] = fd.Triangle(0.0, 0.1, 0.2)
    config.inputs[0].memberships["X2"] = fd.Triangle(0.2, 0.3, 0.5)
    system = fd.MamdaniSystem(config)
    figure = plot_rules(system, [0.2, 0.1])
    assert len(figure.axes) == 3 and "no rule fires" in figure.axes[-1].get_title()
    assert "no rule fires" in str(fuzzy_view(system).explain([0.2, 0.1]))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: fuzzy_view(3.0), "must be one of MamdaniSystem, RuleBase, .* got 3.0"),
        (lambda m: fuzzy_view(fd.Anfis((2, 2))), "nothing has been learned yet"),
        (lambda m: plot_rules(m, [0.4]), r"point must be 2 finite numbers: x \[m\], y \[m\]"),
        (lambda m: plot_rules(m, [0.4, np.nan]), "point must be 2 finite numbers"),
        (lambda m: plot_rules(m, [0.4, 0.1], "z"), "output must be one of: theta_3, got 'z'"),
        (lambda m: plot_rules(m, [0.4, 0.1], most=0), "most must be an integer of at least 1"),
    ],
)
def test_bad_arguments_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(fd.load_mamdani("labvolt_theta3"))
