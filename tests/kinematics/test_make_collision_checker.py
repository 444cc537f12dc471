"""Collision checkers from arms, files, directives and plants."""

import numpy as np
import pytest
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BallRpyJoint, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd
from fikm_drake.kinematics.checker_joints import checker_indices, joint_reach

SDF = """<sdf version="1.9"><model name="table"><static>true</static><link name="top">
<collision name="top"><geometry><box><size>0.5 0.5 0.02</size></box></geometry></collision>
</link></model></sdf>"""
DIRECTIVES = """
directives:
- add_model: {name: table, file: "file://FILE"}
- add_model: {name: arm, file: "package://fikm_drake/panda.urdf"}
- add_weld: {parent: world, child: "arm::base"}
"""


def scene(joint=None):
    """A plant with two arms and a ball that floats, and its SceneGraph."""
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.001)
    for name in ("iiwa14", "panda"):
        arm = fd.load_arm(name)
        fd.AddDhArm(plant, arm)
    ball = plant.AddRigidBody(
        "ball", plant.AddModelInstance("ball"), SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    )
    if joint:
        plant.AddJoint(joint("loose", plant.world_frame(), ball.body_frame()))
    plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(0.1), "ball", CoulombFriction())
    plant.Finalize()
    return plant, scene_graph


def test_plant_and_its_scene_have_the_same_distances():
    plant, scene_graph = scene()
    checker = fd.MakeCollisionChecker(plant, scene_graph=scene_graph, robots=["iiwa14"])
    copy = checker.plant()
    assert copy.GetPositionNames() == plant.GetPositionNames()
    rng = np.random.default_rng(0)
    q = plant.GetPositions(plant.CreateDefaultContext())
    assert (copy.GetPositions(copy.CreateDefaultContext()) == q).all()
    q[:14] = rng.uniform(-1.0, 1.0, 14)
    ours, theirs = plant.CreateDefaultContext(), copy.CreateDefaultContext()
    plant.SetPositions(ours, q)
    copy.SetPositions(theirs, q)
    for name in ("link7", "link4"):
        for instance in ("iiwa14", "panda"):
            poses = [
                p.GetFrameByName(name, p.GetModelInstanceByName(instance)).CalcPoseInWorld(c)
                for p, c in ((plant, ours), (copy, theirs))
            ]
            assert poses[0].IsNearlyEqualTo(poses[1], 1e-12)
    found = checker.CalcRobotClearance(q, 10.0)
    bodies = {checker.get_body(i).scoped_name().get_full() for i in found.other_indices()}
    assert {"ball::ball", "panda::link4", "panda::link7"} <= bodies
    assert not found.jacobians()[:, 7:].any()  # the other arm is no robot


def test_arm_has_capsules_whose_neighbours_are_no_pairs():
    for name in ("iiwa14", "panda", "puma560", "arm7"):
        arm = fd.load_arm(name)
        checker = fd.MakeCollisionChecker(arm)
        assert checker.CheckConfigCollisionFree(arm.default_position)
        folded = np.clip(np.full(arm.num_joints, 3.0), arm.lower, arm.upper)
        assert checker.CalcRobotClearance(folded, 10.0).size() > 0


def test_joint_reach_bounds_every_row():
    for name in ("iiwa14", "panda", "tojo4dof"):
        arm = fd.load_arm(name)
        checker = fd.MakeCollisionChecker(arm, lambda robot: add_ball(robot.plant()))
        reach = joint_reach(checker, checker_indices(checker, None))
        rng = np.random.default_rng(1)
        lower, upper = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
        for q in rng.uniform(lower, upper, (20, arm.num_joints)):
            rows = checker.CalcRobotClearance(q, 10.0).jacobians()
            # Of a pair of the arm's own links both ends can move.
            assert (np.abs(rows) <= 1.0001 * reach).all()


def add_ball(plant):
    X = RigidTransform([0.3, 0.2, 0.5])
    plant.RegisterCollisionGeometry(plant.world_body(), X, Sphere(0.05), "ball", CoulombFriction())


def test_files_and_directives(tmp_path):
    table = tmp_path / "table.sdf"
    table.write_text(SDF)
    directives = tmp_path / "cell.dmd.yaml"
    directives.write_text(DIRECTIVES.replace("FILE", str(table)))
    assert fd.MakeCollisionChecker(directives).plant().num_positions() == 7
    both = fd.MakeCollisionChecker(fd.load_arm("panda"), str(table))
    assert both.plant().HasModelInstanceNamed("table")


@pytest.mark.parametrize(
    ("sources", "options", "words"),
    [
        ((), {}, "needs a file"),
        ((3,), {}, "must be the path"),
        ((MultibodyPlant(0.0),), {}, "scene_graph"),
        ((fd.load_arm("panda"),), {"robots": ["ur5"]}, "'panda'.*'ur5'"),
        ((fd.load_arm("panda"),), {"robot_padding": -1.0}, "robot_padding"),
        ((fd.load_arm("panda"),), {"edge_step_size": 0.0}, "edge_step_size"),
        ((lambda robot: add_ball(robot.plant()),), {}, "no joint"),
    ],
)
def test_bad_arguments(sources, options, words):
    with pytest.raises(ValueError, match=words):
        fd.MakeCollisionChecker(*sources, **options)


def test_bad_files(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere"):
        fd.MakeCollisionChecker("nowhere.urdf")
    for name in ("bad.urdf", "bad.yaml", "bad.txt"):
        (tmp_path / name).write_text("<sdf")
        with pytest.raises(ValueError, match=name):
            fd.MakeCollisionChecker(tmp_path / name)


def test_a_joint_that_cannot_be_copied_is_named():
    plant, scene_graph = scene(BallRpyJoint)
    with pytest.raises(ValueError, match="'loose'"):
        fd.MakeCollisionChecker(plant, scene_graph=scene_graph)
