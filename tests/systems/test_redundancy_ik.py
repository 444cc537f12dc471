"""RedundancyIk: ports, what it commands, what it does when the point is lost."""

import inspect
import re

import numpy as np
import pytest
import yaml
from pydrake.common.value import Value
from pydrake.math import RigidTransform

import fikm_drake as fd

STATUS = fd.ResolutionStatus
PERIOD = 0.02


@pytest.fixture(scope="module")
def resolver():
    return fd.RedundancyResolver(fd.load_arm("hassantabar3r"))


@pytest.fixture
def block(resolver):
    return fd.RedundancyIk(resolver, period=PERIOD)


def test_ports_and_docstring(block, ports):
    inputs, outputs = ports(block)
    assert inputs == {"desired_position": 2}
    assert outputs == {"commanded_position": 3, "bounds": 2, "status": 1}
    text = inspect.getdoc(fd.RedundancyIk)
    described = re.search(r"\.\. pydrake_system::\n\n((?: {4}.*\n)+)", text).group(1)
    assert yaml.safe_load(described) == {
        "name": "RedundancyIk",
        "input_ports": list(inputs),
        "output_ports": list(outputs),
    }
    assert not block.HasAnyDirectFeedthrough()


def test_commands_what_the_resolver_finds(block, resolver, drive):
    driver = drive(block)
    for point in ([1.0, 2.0], [-1.0, 3.0], [2.0, 2.5]):
        driver.cycle(desired_position=point)
        found = resolver.resolve([point])
        np.testing.assert_array_equal(driver["commanded_position"], found.q[0])
        np.testing.assert_array_equal(driver["bounds"], [found.lower[0], found.upper[0]])
        assert driver["status"] == found.status[0]


@pytest.mark.parametrize(
    ("bad", "status"),
    [
        ([np.nan, 1.0], STATUS.INVALID_INPUT),
        ([np.inf, 1.0], STATUS.INVALID_INPUT),
        ([9.0, 9.0], STATUS.INFEASIBLE),
    ],
)
def test_a_lost_point_holds_the_last_command(block, drive, bad, status):
    driver = drive(block)
    driver.cycle(desired_position=[1.0, 2.0])
    before = driver.read()
    driver.cycle(desired_position=bad)
    after = driver.read()
    assert after["status"] == status
    for name in ("commanded_position", "bounds"):
        np.testing.assert_array_equal(after[name], before[name])
    driver.cycle(desired_position=[1.0, 2.0])
    assert driver["status"] == STATUS.SOLVED


def test_lost_from_the_start_it_stays_where_it_is(resolver, drive):
    start = [0.5, 0.6, 0.7]
    driver = drive(fd.RedundancyIk(resolver, period=PERIOD, initial_position=start))
    driver.cycle(desired_position=[np.nan, np.nan])
    np.testing.assert_array_equal(driver["commanded_position"], start)
    assert np.isfinite(driver["bounds"]).all()


def test_poses_of_an_arm_without_a_closed_form(ports, drive):
    arm = fd.load_arm("hassantabar4r")
    resolver = fd.RedundancyResolver(arm, task="pose")
    block = fd.RedundancyIk(resolver, period=PERIOD)
    assert list(ports(block)[0]) == ["desired_pose"]
    assert ports(block)[1] == {"commanded_position": 4, "bounds": 2, "status": 1}
    driver = drive(block)
    pose = arm.forward_kinematics([0.8, 0.7, 1.0, 0.3])
    driver.cycle(desired_pose=Value(RigidTransform(pose)))
    found = resolver.resolve([pose])
    np.testing.assert_array_equal(driver["commanded_position"], found.q[0])
    np.testing.assert_array_equal(driver["bounds"], [found.lower[0], found.upper[0]])
    for far, status in ((9.0, STATUS.INFEASIBLE), (np.nan, STATUS.INVALID_INPUT)):
        driver.cycle(desired_pose=Value(RigidTransform([far, 0.0, 0.0])))
        assert driver["status"] == status
        np.testing.assert_array_equal(driver["commanded_position"], found.q[0])


def test_along_a_line_there_is_no_jump(block, drive):
    driver = drive(block)
    points = np.linspace([1.0, 2.0], [1.0, 4.0], 300)
    commands = []
    for point in points:
        driver.cycle(desired_position=point)
        commands.append(driver["commanded_position"])
    assert np.abs(np.diff(commands, axis=0)).max() < 0.05


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"period": 0.0}, ["period", "0.0"]),
        ({"period": -1.0}, ["period", "-1.0"]),
        ({"initial_position": [0.0, 0.0]}, ["3 finite"]),
        ({"initial_position": [0.0, 2.0, 0.0]}, ["position[1]", "2.0"]),
        ({"initial_position": [0.0, np.nan, 0.0]}, ["finite", "nan"]),
    ],
)
def test_refuses(resolver, options, words):
    with pytest.raises(ValueError) as error:
        fd.RedundancyIk(resolver, **{"period": PERIOD} | options)
    for word in words:
        assert word in str(error.value)
