"""Roll, gripper and servo counts: the arm as a cell has it."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

NAMES = ["joint1", "joint2", "joint3", "joint4", "roll", "left", "right"]


@pytest.fixture(scope="module")
def plant():
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), time_step=1e-3)
    Parser(plant).AddModelsFromString(fd.labvolt.gripper_urdf(), "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return plant


def test_the_tool_is_where_it_is_without_gripper(plant):
    arm, context = fd.load_arm("labvolt5250"), plant.CreateDefaultContext()
    assert plant.GetPositionNames(add_model_instance_prefix=False) == [
        *(f"{name}_q" for name in NAMES[:5]),
        "left_x",
        "right_x",
    ]
    assert plant.num_actuators() == 7
    rng = np.random.default_rng(0)
    for _ in range(10):
        q = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
        plant.SetPositions(context, [*q, rng.uniform(-3, 3), *rng.uniform(0, 0.03, 2)])
        X = plant.GetFrameByName("tool").CalcPoseInWorld(context)
        np.testing.assert_allclose(X.translation(), arm.forward_kinematics(q)[:3, 3], atol=1e-12)
        along = X.rotation().col(0)
        np.testing.assert_allclose(along, arm.forward_kinematics(q)[:3, 0], atol=1e-12)


def test_roll_turns_the_fingers_and_the_gripper_opens(plant):
    context = plant.CreateDefaultContext()
    left, right = (plant.GetBodyByName(name) for name in ("left", "right"))

    def apart(opening, roll):
        plant.SetPositions(context, [0.0, 0.3, 0.0, 0.0, roll, opening, opening])
        places = [body.EvalPoseInWorld(context).translation() for body in (left, right)]
        return places[0] - places[1]

    assert np.linalg.norm(apart(0.0, 0.0)) < 1e-12
    assert np.linalg.norm(apart(0.03, 0.0)) == pytest.approx(0.06)
    assert abs(apart(0.03, 0.0) @ apart(0.03, np.pi / 2)) < 1e-12


def test_servo_counts_come_back_from_the_file(tmp_path):
    solution = fd.labvolt.solve(fd.labvolt.random_targets(6), approach=-1.0)
    angles = np.column_stack([np.linspace(0.0, 1.0, 6), solution.angles])
    path = tmp_path / "counts.csv"
    fd.labvolt.save_servo_counts(path, 0.02 * np.arange(6), angles)
    assert path.read_text("utf-8").startswith("time_s,base_deg,shoulder,elbow,wrist\n0,0.0000,")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    back = fd.labvolt.from_servo_counts(table[:, 2:])
    assert np.rad2deg(np.abs(back - solution.angles)).max() < 1e-3
    tool = fd.labvolt.forward_kinematics(back)
    assert np.linalg.norm(tool - solution.nearest, axis=1).max() < 2e-5


@pytest.mark.parametrize("bad", [np.zeros((2, 3)), np.full((3, 4), np.nan), np.zeros((2, 4))])
def test_bad_motions_write_nothing(bad, tmp_path):
    with pytest.raises(ValueError, match="angles"):
        fd.labvolt.save_servo_counts(tmp_path / "a.csv", [0.0, 0.1, 0.2], bad)
    assert not list(tmp_path.iterdir())
