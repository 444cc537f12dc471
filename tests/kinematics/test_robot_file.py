"""URDFs as people have them: what works, and what is refused with joint and remedy."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd

INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
GOOD = 'lower="-1" upper="2" velocity="3" effort="1"'


def robot(limit, *, kind="revolute", inside="", beside=""):
    """A robot of two joints, the first as given; a link to stand on without inertia."""
    links = "".join(f'<link name="{n}">{INERTIAL}</link>' for n in ("upper", "lower", "tool"))
    first = f'<joint name="first" type="{kind}"><parent link="base"/><child link="upper"/>{inside}'
    second = '<joint name="second" type="revolute"><parent link="upper"/><child link="lower"/>'
    return (
        f'<robot name="r"><link name="base"/>{links}'
        f'{first}<axis xyz="0 1 0"/>' + (f"<limit {limit}/>" if limit else "") + "</joint>"
        f'{second}<origin xyz="1 0 0"/><axis xyz="0 1 0"/><limit {GOOD}/></joint>'
        '<joint name="end" type="fixed"><parent link="lower"/><child link="tool"/>'
        f'<origin xyz="1 0 0"/></joint>{beside}</robot>'
    )


@pytest.fixture
def written(tmp_path):
    def write(text, name="robot.urdf"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def chain_of(path):
    return fd.SerialChain.from_plant(fd.MakeRobotPlant(path), "tool")


@pytest.mark.parametrize(
    "limit, words",
    [
        ('lower="1" upper="-1" velocity="1"', ["lower 1.0", "upper -1.0", "swap"]),
        ('lower="-1" upper="1" velocity="-2"', ["velocity", "-2.0", "write 2.0"]),
        ('lower="-inf" upper="1" velocity="1"', ["lower", "'-inf'", "leave it out"]),
        ('lower="-1" upper="1" velocity="nan"', ["velocity", "'nan'"]),
        ('lower="-1" upper="high" velocity="1"', ["upper", "'high'"]),
    ],
)
def test_what_drake_ends_the_process_for_names_file_joint_and_remedy(limit, words, written):
    path = written(robot(limit))
    for function in (fd.check_robot_file, fd.MakeRobotPlant):
        with pytest.raises(ValueError) as error:
            function(path)
        assert all(word in str(error.value) for word in [str(path), "'first'", *words])


@pytest.mark.parametrize(
    "limit, kind, inside, words",
    [
        ('lower="-1" upper="1" velocity="0"', "revolute", "", ["velocity is 0", "no limit"]),
        ('lower="-1" upper="1"', "revolute", "", ["velocity is missing", "no limit"]),
        ('velocity="1"', "revolute", "", ["without end"]),
        ('lower="1" upper="1" velocity="1"', "revolute", "", ["equal limits 1.0", "fixed"]),
        ('lower="-170" upper="170" velocity="1"', "revolute", "", ["degrees", "170"]),
        (GOOD, "revolute", '<mimic joint="second"/>', ["follows joint 'second'", "mimic"]),
        ("", "continuous", "", ["velocity is missing"]),
    ],
)
def test_what_is_odd_is_found(limit, kind, inside, words, written):
    (finding,) = fd.check_robot_file(written(robot(limit, kind=kind, inside=inside)))
    assert finding.joint == "first"
    assert all(word in str(finding) for word in words)


def test_a_good_file_has_no_findings_and_other_kinds_are_read_by_drake(written):
    assert fd.check_robot_file(written(robot(GOOD))) == []
    assert fd.check_robot_file(written(robot('velocity="1"', kind="continuous"))) == []
    sdf = '<sdf version="1.7"><model name="m"><link name="l"/></model></sdf>'
    assert fd.check_robot_file(written(sdf, "m.sdf")) == []


def test_velocity_zero_is_no_limit_and_says_so(written):
    with pytest.warns(UserWarning, match=r"velocity limit 0 of \['first'\].*no limit"):
        chain = chain_of(written(robot('lower="-1" upper="1" velocity="0"')))
    np.testing.assert_array_equal(chain.velocity_limits, [np.inf, 3.0])
    chain = chain_of(written(robot('lower="-1" upper="1"')))
    np.testing.assert_array_equal(chain.velocity_limits, [np.inf, 3.0])


def test_equal_limits_hold_the_joint_there(written):
    chain = chain_of(written(robot('lower="0.4" upper="0.4" velocity="1"')))
    assert chain.joint_names == ("second",)
    X = chain.forward_kinematics([0.0])
    np.testing.assert_allclose(X[:3, 3], [2 * np.cos(0.4), 0, -2 * np.sin(0.4)], atol=1e-14)


def test_continuous_joints_have_no_limits(written):
    chain = chain_of(written(robot('velocity="2"', kind="continuous")))
    np.testing.assert_array_equal(chain.lower, [-np.inf, -1.0])
    np.testing.assert_array_equal(chain.velocity_limits, [2.0, 3.0])


def test_the_root_is_welded_and_what_carries_nothing_stays_free(written):
    plant = fd.MakeRobotPlant(written(robot(GOOD, beside=f'<link name="brick">{INERTIAL}</link>')))
    assert plant.num_positions() == 2 + 7
    assert fd.SerialChain.from_plant(plant, "tool").num_joints == 2


@pytest.mark.parametrize(
    "text, name, words",
    [
        ("<robot", "robot.urdf", ["not XML"]),
        (robot(GOOD, inside='<mimic joint="none"/>'), "robot.urdf", ["robot.urdf", "'none'"]),
        ("hello", "robot.sdf", ["robot.sdf"]),
        ("hello", "robot.txt", [".urdf", "robot.txt"]),
    ],
)
def test_what_is_no_robot_is_named(text, name, words, written):
    with pytest.raises(ValueError) as error:
        fd.MakeRobotPlant(written(text, name))
    assert all(word in str(error.value) for word in words)


def test_missing_files_finalized_plants_and_bad_steps_are_named(written, tmp_path):
    with pytest.raises(FileNotFoundError, match="gone.urdf"):
        fd.MakeRobotPlant(tmp_path / "gone.urdf")
    plant = MultibodyPlant(0.0)
    plant.Finalize()
    with pytest.raises(ValueError, match="finalized"):
        fd.AddRobot(plant, written(robot(GOOD)))
    with pytest.raises(ValueError, match=r"time_step.*-1"):
        fd.MakeRobotPlant(written(robot(GOOD)), time_step=-1)
