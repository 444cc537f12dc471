"""Runs among obstacles: who keeps clear, what the log tells of it, and options that are not used."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.simulation.scenario import Fuzzy, Model, Obstacle, Path, Pose, Scenario

START = [-0.54, 0.55, 0.0, -1.6, 0.0, 1.0, 0.0]
BALL = Obstacle([0.5, 0.0, 0.5], radius=0.08, name="ball")
TABLE = Obstacle([0.5, 0.0, -0.15], box=[1.0, 1.0, 0.1])
LINE = Path(positions=[[0.5, -0.3, 0.5], [0.5, 0.3, 0.5]], duration=1.5, hold=0.5)
DOWN = [3.14159, 0.0, 0.0]
POSES = Path(poses=[Pose([0.45, y, 0.55], DOWN) for y in (-0.3, 0.3)], duration=1.5, hold=0.5)


def scenario(**changes):
    return Scenario(
        **{
            "robot": "iiwa14",
            "target": LINE,
            "obstacles": [BALL, TABLE],
            "initial_position": START,
            **changes,
        }
    )


@pytest.mark.parametrize(
    "changes, least",
    [
        ({}, 9.7e-3),
        ({"controller": Fuzzy(fd.FuzzyIkConfig(fused=True))}, 9.7e-3),
        ({"controller": "frmrc"}, 9.7e-3),
        ({"controller": "supervised_drake", "target": POSES}, 9.7e-3),
        ({"plant": "torque_driven"}, 5e-3),  # the arm is behind its reference
        ({"clearance": fd.ClearanceConfig(safe_distance=0.03)}, 29.7e-3),
    ],
    ids=["fuzzy", "fused", "frmrc", "supervised", "torque", "wider"],
)
def test_the_arm_keeps_clear_of_a_ball_in_its_way_and_the_log_says_so(changes, least):
    log = fd.simulate(scenario(**changes))
    assert log.clearance.min() >= least
    blind = fd.simulate(scenario(**changes | {"avoid": False, "clearance": None}))
    assert blind.clearance.min() < 0.0  # with torques the ball pushes back
    assert blind.metrics().clearance == blind.clearance.min()
    assert "ball" in blind.names_of_values("nearest_pair")[int(blind.clearance.argmin())]
    assert "BLOCKED" in log.status_names and "clearance" in str(log.metrics())


@pytest.mark.parametrize("plant", ["kinematic", "servos"])
def test_the_clearance_is_the_distance_that_the_runs_own_scene_knows(plant):
    """Of the last row, by Drake's query of the Diagram's SceneGraph."""
    from pydrake.systems.analysis import Simulator

    blind = scenario(avoid=False, plant=plant)
    log, built = fd.simulate(blind), fd.build_scenario(blind)
    simulator = Simulator(built.diagram)
    root = simulator.get_mutable_context()
    built.set_start(root)
    simulator.AdvanceTo(2.0)
    query = built.scene_graph.get_query_output_port().Eval(
        built.scene_graph.GetMyContextFromRoot(root)
    )
    link, other = log.names_of_values("nearest_pair")[-1].split(" - ")
    one, two = (
        built.plant.GetCollisionGeometriesForBody(built.plant.GetBodyByName(name))
        for name in (link, other)
    )
    found = min(
        query.ComputeSignedDistancePairClosestPoints(a, b).distance for a in one for b in two
    )
    assert log.clearance[-1] == pytest.approx(found, abs=1e-9)
    tool = built.plant.GetFrameByName("tool").CalcPoseInWorld(built.plant_context(root))
    np.testing.assert_allclose(tool.translation(), log.actual[-1], atol=1e-9)


def test_the_log_keeps_the_names_and_tables_have_them(tmp_path):
    log = fd.simulate(scenario(target=Path(positions=[[0.5, -0.3, 0.5]], hold=0.1)))
    log.save(tmp_path / "run.npz")
    log.to_csv(tmp_path / "run.csv")
    found = fd.RunLog.load(tmp_path / "run.npz")
    assert found.scenario.obstacles == [BALL, TABLE]
    header, *rows = (tmp_path / "run.csv").read_text().splitlines()
    assert "clearance_m" in header and header.endswith("nearest_pair_name")
    pairs = {row.split(",")[-1] for row in rows}
    assert pairs == set(found.names_of_values("nearest_pair"))
    assert all(other in ("ball", "obstacle2") for other in (pair.split(" - ")[1] for pair in pairs))


def test_a_sweep_tells_the_clearance():
    base = scenario(target=Path(positions=[[0.5, 0.1, 0.5]], hold=0.5))
    table = fd.sweep(fd.Grid(base, {"avoid": [True, False]}))
    kept, blind = table.column("clearance")
    assert kept > 9.7e-3 > 0.0 > blind


def test_obstacles_of_the_robots_own_file(tmp_path):
    """A post in the arm's file: `clearance` alone makes the controller see it."""
    post = (
        '<link name="post"><collision><origin xyz="1.2 0.5 0"/><geometry><sphere radius="0.15"/>'
        '</geometry></collision></link><joint name="fixed" type="fixed"><parent link="base"/>'
        '<child link="post"/></joint></robot>'
    )
    urdf = fd.load_arm("planar4").to_urdf()
    (tmp_path / "mine.urdf").write_text(urdf.replace("</robot>", post))
    run = Scenario(
        robot=Model(str(tmp_path / "mine.urdf"), frame="tool"),
        target=Path(positions=[[1.3, 0.8]], hold=3.0),
        clearance=fd.ClearanceConfig(influence_distance=0.2),
        initial_position=[0.3, -0.3, -0.3, -0.3],
    )
    log = fd.simulate(run)
    assert log.clearance.min() >= 9.7e-3
    assert any("post" in pair for pair in log.names_of_values("nearest_pair"))
    without = fd.simulate(run.but(clearance=None))
    assert "clearance" not in without


INTEGER = {
    "robot": "tojo4dof",
    "controller": "integer",
    "target": Path(positions=[[0.265, 0.04, -0.155]], hold=0.1),
    "initial_position": [1.041549546, 1.619400719, 2.062635516, 0.566765204],
}


@pytest.mark.parametrize(
    "changes, words",
    [
        (INTEGER, ["Integer cannot keep clear", "avoid: false", "supervised_drake"]),
        ({"obstacles": [], "avoid": False}, ["avoid", "not used", "no obstacles"]),
        ({"avoid": False, "clearance": fd.ClearanceConfig()}, ["clearance is not used"]),
        ({"avoid": "no"}, ["avoid", "'no'"]),
        ({"obstacles": [BALL, BALL]}, ["ball", "twice"]),
        ({"clearance": fd.ClearanceConfig(safe_distance=-1.0)}, ["safe_distance", "-1"]),
        (
            {
                "obstacles": [],
                "controller": Fuzzy(fd.FuzzyIkConfig(clearance=fd.ClearanceConfig(0.02))),
            },
            ["config.clearance is not used", "nothing to avoid"],
        ),
    ],
)
def test_what_is_not_used_is_an_error(changes, words):
    with pytest.raises(ValueError) as error:
        scenario(**changes)
    for word in words:
        assert word in str(error.value)


def test_a_controller_that_cannot_keep_clear_logs_the_clearance_all_the_same():
    log = fd.simulate(scenario(**INTEGER, avoid=False))
    assert log.clearance.shape == (len(log),) and np.isfinite(log.clearance).all()


def test_a_robot_without_collision_shapes_is_named(tmp_path):
    import re

    bare = re.sub(
        r"<collision.*?</collision>", "", fd.load_arm("iiwa14").to_urdf(), flags=re.DOTALL
    )
    (tmp_path / "bare.urdf").write_text(bare)
    run = scenario(
        robot=Model(str(tmp_path / "bare.urdf"), frame="tool"), target=Path([[0.5, 0.1, 0.5]])
    )
    with pytest.raises(ValueError, match="bare has no collision shapes"):
        fd.simulate(run)
    assert "clearance" not in fd.simulate(run.but(avoid=False))
