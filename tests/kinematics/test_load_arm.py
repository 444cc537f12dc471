"""Arms from YAML: round trips, and errors that name the bad value and the valid ones."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import evaluate, load_arm
from fikm_drake.resources import find_model, model_names, models_dir

GOOD = """\
name: mine
joints:
- {type: revolute, alpha: 0.1, a: 0.2, d: 0.3, theta: 0.4, lower: -1.0, upper: 1.0}
"""


@pytest.fixture
def written(tmp_path):
    """Writes a text to arm.yaml and returns its path."""

    def write(text):
        path = tmp_path / "arm.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@pytest.mark.parametrize("name", model_names())
def test_our_arms_round_trip_through_typed_yaml(name):
    table = load_arm(name).table
    again = yaml_load_typed(schema=DhTable, data=yaml_dump_typed(table))
    assert again == table
    assert table.name == name


def test_random_tables_round_trip(random_arm):
    rng = np.random.default_rng(0)
    for _ in range(30):
        table = random_arm(rng).table
        assert yaml_load_typed(schema=DhTable, data=yaml_dump_typed(table)) == table


def test_by_path_of_either_kind_and_suffix(written, tmp_path):
    path = written(GOOD)
    (tmp_path / "other.yml").write_text(GOOD)
    for where in (path, str(path), tmp_path / "other.yml"):
        arm = load_arm(where)
        assert arm.name == "mine"
        assert arm.num_joints == 1
        assert arm.table.convention == "craig"
        assert arm.table.tool == DhTransform()


def test_a_local_file_does_not_hide_our_arm(monkeypatch, written, tmp_path):
    written(GOOD)
    monkeypatch.chdir(tmp_path)
    assert load_arm("arm7").num_joints == 7
    assert load_arm("arm.yaml").name == "mine"


def test_integers_are_numbers_too(written):
    path = written("name: a\njoints:\n- {d: 1, lower: -1, upper: 2}\n")
    joint = load_arm(path).table.joints[0]
    assert (joint.d, joint.limits) == (1.0, (-1.0, 2.0))


@pytest.mark.parametrize("name", ["armm7", "", "arm7.urdf", "models/arm7", "../arm7", "arm7/"])
def test_unknown_name_lists_ours(name):
    with pytest.raises(FileNotFoundError) as error:
        load_arm(name)
    message = str(error.value)
    assert repr(name) in message
    for ours in ("arm7", "panda", "planar2", "puma560"):
        assert ours in message


def test_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="gone.yaml"):
        load_arm(tmp_path / "gone.yaml")


def test_directory_as_path_is_refused(tmp_path):
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(FileNotFoundError, match="folder.yaml"):
        load_arm(tmp_path / "folder.yaml")
    with pytest.raises(FileNotFoundError, match=tmp_path.name):
        load_arm(tmp_path)


BAD_FILES = {
    "empty": ("", []),
    "comment": ("# nothing\n", []),
    "list": ("- 1\n- 2\n", []),
    "text": ("hello\n", []),
    "broken": ("name: [\n", []),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\xff", []),
    "unknown key": (GOOD + "colour: red\n", ["colour"]),
    "unknown key of a joint": (GOOD.replace("theta", "thetta"), ["thetta"]),
    "unknown key of the tool": (GOOD + "tool: {b: 1.0}\n", ["b"]),
    "convention": (GOOD + "convention: hayati\n", ["'hayati'", "craig", "standard"]),
    "type": (GOOD.replace("revolute", "screw"), ["'screw'", "revolute", "prismatic", "joint 1"]),
    "text for a number": (GOOD.replace("0.2", "long"), ["long"]),
    "list for a number": (GOOD.replace("0.2", "[1, 2]"), []),
    "limits reversed": (GOOD.replace("upper: 1.0", "upper: -2.0"), ["lower", "-1.0", "-2.0"]),
    "all limits equal": (GOOD.replace("upper: 1.0", "upper: -1.0"), ["all joints", "equal limits"]),
    "limits infinite": (
        GOOD.replace("lower: -1.0, upper: 1.0", "lower: .inf, upper: .inf"),
        ["inf"],
    ),
    "key twice": (GOOD.replace("a: 0.2", "a: 0.2, a: 0.3"), ["'a'", "twice", "lines 3 and 3"]),
    "top key twice": (GOOD + "name: yours\n", ["'name'", "twice", "lines 1 and 4"]),
    "code for a number": (GOOD.replace("0.2", "__import__('os')"), ["joint 1", " a ", "pi"]),
    "function for a number": (GOOD.replace("0.2", "sin(pi)"), ["joint 1", " a ", "sin(pi)"]),
    "power for a number": (GOOD.replace("0.2", "9**9**9"), ["joint 1", " a ", "9**9**9"]),
    "division by zero": (GOOD.replace("0.2", "1/0"), ["joint 1", " a ", "1/0"]),
    "twist in degrees": (GOOD.replace("0.1", "90"), ["joint 1", "alpha", "90", "angle: deg"]),
    "limit in degrees": (GOOD.replace("1.0}", "170}"), ["joint 1", "upper", "170", "angle: deg"]),
    "pi in degrees": (
        GOOD.replace("0.1", "pi/2") + "unit: {angle: deg}\n",
        ["joint 1", "alpha", "pi/2", "deg"],
    ),
    "unit of an angle": (GOOD + "unit: {angle: grad}\n", ["unit", "'grad'", "rad", "deg"]),
    "unit of a length": (GOOD + "unit: {length: ft}\n", ["unit", "'ft'", "mm"]),
    "flip": (GOOD.replace("a: 0.2", "flip: 2"), ["flip", "2"]),
    "row is text": ("name: a\njoints: [hello]\n", ["joint 1", "hello"]),
    "limit not a number": (GOOD.replace("upper: 1.0", "upper: .nan"), ["upper", "nan", "joint 1"]),
    "not a number": (GOOD.replace("0.2", ".nan"), ["joint 1", " a ", "nan"]),
    "infinite": (GOOD.replace("0.3", ".inf"), ["joint 1", " d ", "inf"]),
    "tool not finite": (GOOD + "tool: {theta: -.inf}\n", ["tool", "theta", "-inf"]),
    "no joints": ("name: a\njoints: []\n", ["joints"]),
    "joints missing": ("name: a\n", ["joints"]),
    "joints null": ("name: a\njoints: null\n", []),
    "no name": (GOOD.replace("mine", "''"), ["name", "''"]),
    "name with a blank": (GOOD.replace("mine", "my arm"), ["'my arm'", "letter"]),
    "name with a digit first": (GOOD.replace("mine", "7up"), ["'7up'", "letter"]),
    "name of XML": (GOOD.replace("mine", "'a<b>'"), ["'a<b>'"]),
    "velocity zero": (GOOD.replace("upper: 1.0", "velocity: 0.0"), ["velocity", "0.0"]),
    "velocity not a number": (GOOD.replace("upper: 1.0", "velocity: .nan"), ["velocity", "nan"]),
}


@pytest.mark.parametrize("text, words", BAD_FILES.values(), ids=BAD_FILES)
def test_bad_files_raise_value_error_that_names_file_and_value(text, words, written):
    path = written(text)
    with pytest.raises(ValueError) as error:
        load_arm(path)
    message = str(error.value)
    for word in [str(path), *words]:
        assert word in message


@pytest.mark.parametrize(
    "table, words",
    [
        (DhTable("a", "craig", [DhJoint(a=float("nan"))]), ["a", "nan"]),
        (DhTable("a", "craig", [DhJoint(a="1.0")]), ["'1.0'"]),
        (DhTable("a", "craig", [DhJoint(a=None)]), ["None"]),
        (DhTable("a", "craig", [DhJoint(lower="low")]), ["low"]),
        (DhTable("a", "craig", [DhJoint(velocity="fast")]), ["fast"]),
        (DhTable("a", "dh", [DhJoint()]), ["'dh'", "craig", "standard"]),
        (DhTable("a", "craig", []), ["joints"]),
        (DhTable(joints=[DhJoint()]), ["''"]),
    ],
)
def test_bad_tables_raise_value_error(table, words):
    with pytest.raises(ValueError) as error:
        DhArm(table)
    for word in words:
        assert word in str(error.value)


def test_folder_of_models():
    assert (models_dir() / "package.xml").is_file()
    assert find_model("panda") == models_dir() / "panda.yaml"
    assert {"table6_10s", "large_step_2"} <= set(model_names("scenarios"))


def test_missing_models_folder_says_reinstall(monkeypatch, tmp_path):
    monkeypatch.setattr("fikm_drake.resources._PACKAGE", tmp_path / "fikm_drake")
    with pytest.raises(FileNotFoundError, match="reinstall"):
        load_arm("arm7")


def test_dataclasses_compare_and_copy():
    """A user's script changes a table of ours by dataclasses.replace."""
    table = load_arm("arm7").table
    longer = dataclasses.replace(table, name="longer", tool=DhTransform(a=0.4))
    X = DhArm(longer).forward_kinematics(np.zeros(7))
    np.testing.assert_allclose(X[:3, 3], [0.4, -0.6, 0.6], rtol=0, atol=1e-12)


def test_degrees_and_millimetres_equal_radians_and_metres(written):
    degrees = """
name: same
convention: standard
joints:
- {alpha: -90, d: 300, lower: -170, upper: 170, velocity: 90}
- {a: 400, theta: 45, lower: -90, upper: 1.5e+2}
- {type: prismatic, a: 20, lower: 50, upper: 300, velocity: 100}
tool: {d: 10, theta: 180}
unit: {angle: deg, length: mm}
"""
    radians = """
name: same
convention: standard
joints:
- {alpha: -pi/2, d: 0.3, lower: -17/18*pi, upper: (20-3)*pi/18, velocity: pi/2}
- {a: 0.4, theta: pi / 4, lower: -pi/2, upper: 5*pi/6}
- {type: prismatic, a: 2e-2, lower: 0.05, upper: .3, velocity: +0.1}
tool: {d: 0.01, theta: pi}
"""
    one, other = load_arm(written(degrees)), load_arm(written(radians))
    q = np.random.default_rng(0).uniform(-1, 1, (20, 3))
    np.testing.assert_allclose(one.jacobian(q), other.jacobian(q), rtol=0, atol=1e-15)
    for field in ("lower", "upper", "velocity_limits"):
        np.testing.assert_allclose(getattr(one, field), getattr(other, field), rtol=1e-15)
    assert one.table.unit.angle == "rad" and one.table.joints[0].d == 0.3
    assert load_arm(written(yaml_dump_typed(one.table))).table == one.table


def test_large_angles_are_taken_where_the_table_says_radians(written):
    path = written(GOOD.replace("1.0}", "170}") + "unit: {angle: rad}\n")
    assert load_arm(path).upper == [170.0]


@pytest.mark.parametrize("convention", ["craig", "standard"])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_flipped_joint_moves_the_other_way(convention, kind, random_arm):
    """Its variable is subtracted, as roboticstoolbox does for its `flip`; its offset stays."""
    rng = np.random.default_rng(8)
    for _ in range(10):
        table = random_arm(rng, convention=convention).table
        k = int(rng.integers(len(table.joints)))
        table.joints[k].type, table.joints[k].flip = kind, True
        plain = dataclasses.replace(
            table, joints=[dataclasses.replace(row, flip=False) for row in table.joints]
        )
        sign = np.ones(len(table.joints))
        sign[k] = -1.0
        q = rng.uniform(-3, 3, (4, len(sign)))
        flipped, plain = DhArm(table), DhArm(plain)
        np.testing.assert_allclose(
            flipped.forward_kinematics(q), plain.forward_kinematics(sign * q), atol=1e-13
        )
        np.testing.assert_allclose(flipped.jacobian(q), sign * plain.jacobian(sign * q), atol=1e-13)


def test_a_joint_with_equal_limits_stands_still(random_arm, plant_twin):
    rng = np.random.default_rng(9)
    for _ in range(20):
        table = random_arm(rng).table
        if len(table.joints) < 2:
            continue
        fixed = rng.random(len(table.joints)) < 0.4
        fixed[int(rng.integers(len(fixed)))] = False
        free = DhArm(table)
        q = rng.uniform(-2, 2, len(fixed))
        for row, still, value in zip(table.joints, fixed, q):
            if still:
                row.lower = row.upper = float(value)
        arm = DhArm(table)
        assert arm.num_joints == np.sum(~fixed)
        assert arm.chain.joint_names == tuple(f"joint{i + 1}" for i in np.flatnonzero(~fixed))
        np.testing.assert_allclose(
            arm.forward_kinematics(q[~fixed]), free.forward_kinematics(q), rtol=0, atol=1e-13
        )
        np.testing.assert_allclose(
            arm.jacobian(q[~fixed]), free.jacobian(q)[:, ~fixed], rtol=0, atol=1e-13
        )
        twin = plant_twin(arm)
        np.testing.assert_allclose(
            arm.jacobian(q[~fixed]), twin.jacobian(q[~fixed]), rtol=0, atol=1e-12
        )


@pytest.mark.parametrize(
    "text, value",
    [
        ("pi/2", np.pi / 2),
        ("-pi", -np.pi),
        ("2*(1+pi)", 2 + 2 * np.pi),
        ("1e-3", 1e-3),
        ("-.INF", -np.inf),
    ],
)
def test_expressions(text, value):
    assert evaluate(text) == value


@given(st.text("0123456789.+-*/() piea_[]", max_size=12))
def test_no_text_does_more_than_arithmetic(text):
    try:
        assert isinstance(evaluate(text), float)
    except ValueError as error:
        assert repr(text) in str(error)
