"""`fikm-drake follow`, as one types it."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.cli import main
from fikm_drake.kinematics.load_robot import load_chain

HOME = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
START = ",".join(map(str, HOME))


@pytest.fixture
def way(tmp_path):
    points = np.tile(fd.load_arm("panda").forward_kinematics(HOME)[:3, 3], (12, 1))
    points[:, 1] += np.linspace(0.0, 0.2, 12)
    path = tmp_path / "way.csv"
    np.savetxt(path, points, delimiter=",", header="x,y,z", comments="")
    return path


@pytest.mark.parametrize("kind", ["name", "urdf"])
def test_follow(tmp_path, way, capsys, kind):
    robot = "panda"
    if kind == "urdf":
        robot = tmp_path / "panda.urdf"
        robot.write_text(fd.load_arm("panda").to_urdf())
    files = {
        name: tmp_path / f"{name}.{end}"
        for name, end in (("out", "csv"), ("times", "csv"), ("html", "html"))
    }
    words = [x for name, path in files.items() for x in (f"--{name}", str(path))]
    assert main(["follow", str(robot), str(way), "--start", START, *words]) == 0
    assert "12 followed" in capsys.readouterr().out
    _, *lines = files["out"].read_text().splitlines()
    q = np.array([[float(x) for x in line.split(",")[1:8]] for line in lines])
    tool = fd.load_arm("panda").forward_kinematics(q)[:, :3, 3]
    np.testing.assert_allclose(tool, np.loadtxt(way, delimiter=",", skiprows=1), atol=1e-6)
    times = np.loadtxt(files["times"], delimiter=",", skiprows=1)
    np.testing.assert_allclose(times[[0, -1], 1:], q[[0, -1]], atol=1e-9)
    assert "meshcat" in files["html"].read_text().lower()


def test_out_of_reach_is_exit_1_with_the_table_all_the_same(tmp_path, capsys):
    way = tmp_path / "way.csv"
    way.write_text("0.4,0,0.5\n5,0,0\n")
    out = tmp_path / "out.csv"
    assert main(["follow", "panda", str(way), "--out", str(out)]) == 1
    said = capsys.readouterr().out
    assert "1 not_reached" in said and "  target 1: NOT_REACHED, 4" in said and "mm from it" in said
    assert out.read_text().count("NOT_REACHED") == 1
    assert main(["follow", "panda", str(way), "--times", str(tmp_path / "t.csv")]) == 1
    assert "target 1 is NOT_REACHED" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["nobody", "WAY"], 2, "nobody"),
        (["nowhere.urdf", "WAY"], 2, "nowhere.urdf"),
        (["panda", "nowhere.csv"], 2, "nowhere.csv"),
        (["panda", "WAY", "--start", "a,b"], 2, "--start"),
        (["panda", "WAY", "--start", "9,9"], 2, "initial_position"),
        (["panda", "WAY", "--out", "no/folder/x.csv"], 1, "no such folder"),
    ],
)
def test_bad_words(way, capsys, words, code, message):
    assert main(["follow", *(str(way) if x == "WAY" else x for x in words)]) == code
    assert message in capsys.readouterr().err


def test_chain_of_a_model_ends_at_its_last_body(tmp_path):
    for name in ("iiwa14", "puma560"):
        arm = fd.load_arm(name)
        path = tmp_path / f"{name}.urdf"
        path.write_text(arm.to_urdf())
        chain = load_chain(path)
        q = np.linspace(-0.5, 0.5, arm.num_joints)
        np.testing.assert_allclose(
            chain.forward_kinematics(q), arm.forward_kinematics(q), atol=1e-9
        )
        assert load_chain(path, "link3").num_joints == 3
    with pytest.raises(ValueError, match="hand"):
        load_chain(path, "hand")
