"""Pictures of Mamdani systems."""

import numpy as np
import pytest

from fikm_drake.fuzzy.mamdani import MamdaniSystem, load_mamdani
from fikm_drake.fuzzy.memberships import Triangle
from fikm_drake.fuzzy.teaching import plot_memberships, plot_surface


def test_memberships_of_a_variable(make_config):
    variable = make_config().inputs[0]
    (axes,) = plot_memberships(variable).axes
    assert [text.get_text() for text in axes.texts] == ["near", "mid", "far"]
    assert axes.get_xlabel() == "x [m]" and axes.get_xlim() == (0.0, 1.0)
    x, grades = axes.lines[1].get_data()
    np.testing.assert_array_equal(grades, variable.memberships["mid"](x))
    assert grades.max() == 1.0


def test_memberships_of_a_system(make_config):
    figure = plot_memberships(MamdaniSystem(make_config()))
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert labels == ["x [m]", "y [m]", "angle [deg]", "speed [m/s]"]


def test_surface(make_config):
    system = MamdaniSystem(make_config())
    axes, bar = plot_surface(system, "speed", resolution=11).axes
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("x [m]", "y [m]", "")
    assert bar.get_ylabel() == "speed [m/s]"
    drawn = np.reshape(axes.collections[0].get_array(), (11, 11))
    assert drawn[7, 2] == pytest.approx(system([0.2, 0.4]).values[1])


def test_holes_are_hatched():
    config = load_mamdani("labvolt_theta3").config
    config.inputs[0].memberships["X1"] = Triangle(0.0, 0.1, 0.2)
    config.inputs[0].memberships["X2"] = Triangle(0.2, 0.3, 0.5)
    axes = plot_surface(MamdaniSystem(config), resolution=21).axes[0]
    assert axes.get_title() == "hatched: no rule fires"
    assert len(axes.collections) == 2


def test_a_slice_of_a_system_of_three_inputs(make_config):
    config = make_config()
    third = make_config().inputs[1]
    third.name = "z"
    config.inputs.append(third)
    config.rules[0].when["z"] = "low"
    system = MamdaniSystem(config)
    axes = plot_surface(system, "angle", resolution=5, fixed={"y": 0.5}).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "z [m]")
    drawn = np.reshape(axes.collections[0].get_array(), (5, 5))
    assert drawn[1, 3] == pytest.approx(system([0.75, 0.5, -0.5]).values[0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"output": "torque"}, "output must be one of: angle, speed"),
        ({"resolution": 1}, "resolution must be at least 2, got 1"),
        ({"fixed": {"x": 0.0, "y": 0.0}}, "fixed must leave one or two of the inputs x, y, got"),
        ({"fixed": {"w": 0.0}}, "fixed must leave one or two of the inputs"),
    ],
)
def test_refuses(make_config, options, message):
    with pytest.raises(ValueError, match=message):
        plot_surface(MamdaniSystem(make_config()), **{"output": "angle", **options})
