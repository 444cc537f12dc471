"""The block of integer fuzzy IK: sampled, in the world's metres, calm when its input is lost."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

import fikm_drake as fd

INVALID, INSIDE, OUTSIDE = (float(status) for status in fd.IntegerFuzzyIkStatus)
WORKPLANE = fd.load_workplane("tojo4dof")


@pytest.fixture(scope="module")
def ik():
    return fd.IntegerFuzzyIk(labels=(9, 9), conjunction="product")


@pytest.fixture
def driver(ik, drive):
    return drive(fd.IntegerFuzzyIkSystem(ik, WORKPLANE))


def after(driver, position):
    """State after a cycle with this input."""
    driver.cycle(desired_position=position)
    return driver["commanded_position"], driver["status"][0]


def test_ports(ik, ports):
    system = fd.IntegerFuzzyIkSystem(ik, WORKPLANE)
    assert ports(system) == ({"desired_position": 3}, {"commanded_position": 4, "status": 1})
    assert not system.HasAnyDirectFeedthrough()


@pytest.mark.parametrize("point", [(0, 0), (120, 80), (400, 300)])
def test_command_is_of_the_nearest_whole_millimetre(driver, ik, point):
    desired = WORKPLANE.to_world(np.array(point) + [0.4, -0.4])
    position, status = after(driver, desired)
    np.testing.assert_array_equal(position, ik.to_radians(ik.solve(*point)[0]))
    assert status == INSIDE


def test_tool_comes_to_the_position_in_the_world(driver):
    arm = fd.load_arm("tojo4dof")
    for desired in WORKPLANE.to_world(np.random.default_rng(0).uniform(0, [400, 300], (20, 2))):
        position, _ = after(driver, desired)
        tool = arm.forward_kinematics(position)[:3, 3]
        assert np.linalg.norm(tool - desired) < 0.0033


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_lost_input_holds_the_last_good_command(driver, bad):
    good, _ = after(driver, WORKPLANE.to_world([100, 200]))
    for k in range(3):
        desired = WORKPLANE.to_world([300, 20])
        desired[k] = bad
        position, status = after(driver, desired)
        np.testing.assert_array_equal(position, good)
        assert status == INVALID
    assert after(driver, WORKPLANE.to_world([300, 20]))[1] == INSIDE


@pytest.mark.parametrize(
    ("point", "nearest"), [((-3, 100), (0, 100)), ((500, 400), (400, 300)), ((1e100, 5), (400, 5))]
)
def test_a_position_beside_the_desk_gives_the_nearest_point(ik, drive, point, nearest):
    workplane = fd.Workplane()
    driver = drive(fd.IntegerFuzzyIkSystem(ik, workplane))
    position, status = after(driver, np.array([*point, 0.0]) / 1000)
    np.testing.assert_array_equal(position, ik.to_radians(ik.solve(*nearest)[0]))
    assert status == OUTSIDE


def test_a_position_over_the_desk_counts_as_outside(ik, drive):
    driver = drive(fd.IntegerFuzzyIkSystem(ik, WORKPLANE, height_tolerance=0.01))
    for height, expected in ((0.009, INSIDE), (0.011, OUTSIDE), (-0.011, OUTSIDE)):
        position, status = after(driver, WORKPLANE.to_world([50, 60]) + [0, 0, height])
        np.testing.assert_array_equal(position, ik.to_radians(ik.solve(50, 60)[0]))
        assert status == expected


def test_starts_in_the_middle_or_where_it_is_set(ik, drive):
    system = fd.IntegerFuzzyIkSystem(ik, WORKPLANE)
    driver = drive(system)
    np.testing.assert_array_equal(
        driver["commanded_position"], ik.to_radians(ik.solve(200, 150)[0])
    )
    system.SetPositions(driver.context, [0.1, 0.2, 0.3, 0.4])
    assert driver["commanded_position"].tolist() == [0.1, 0.2, 0.3, 0.4]
    with pytest.raises(ValueError, match="4 finite numbers"):
        system.SetPositions(driver.context, [0.1, np.nan, 0.3, 0.4])


def test_a_desk_that_is_moved_later_does_not_count(ik, drive):
    workplane = fd.load_workplane("tojo4dof")
    driver = drive(fd.IntegerFuzzyIkSystem(ik, workplane))
    workplane.origin[0] += 1.0
    assert after(driver, WORKPLANE.to_world([50, 60]))[1] == INSIDE


def test_samples_at_its_period_in_a_simulator(ik):
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource(WORKPLANE.to_world([10, 20])))
    system = builder.AddSystem(fd.IntegerFuzzyIkSystem(ik, WORKPLANE, period=0.5))
    builder.Connect(source.get_output_port(), system.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.1)
    context = system.GetMyContextFromRoot(simulator.get_context())
    q = system.GetOutputPort("commanded_position").Eval(context)
    np.testing.assert_array_equal(q, ik.to_radians(ik.solve(10, 20)[0]))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"period": 0.0}, "period"),
        ({"period": np.nan}, "period"),
        ({"height_tolerance": -1.0}, "height_tolerance"),
        ({"height_tolerance": np.inf}, "height_tolerance"),
        ({"workplane": fd.Workplane(yaw=np.nan)}, "yaw"),
    ],
)
def test_bad_options(ik, options, words):
    with pytest.raises(ValueError, match=words):
        fd.IntegerFuzzyIkSystem(ik, **({"workplane": WORKPLANE} | options))
