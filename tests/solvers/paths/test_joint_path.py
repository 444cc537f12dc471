"""Joint paths: the tool where it shall be, no leaps, limits, obstacles, times."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import PiecewisePolynomial, PiecewisePose

import fikm_drake as fd
from fikm_drake.solvers.paths.path_targets import between, load_path_csv

PANDA = fd.load_arm("panda")
HOME = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])


def circle(arm, q, radius=0.1, count=40):
    poses = np.tile(arm.forward_kinematics(q), (count, 1, 1))
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    poses[:, 0, 3] += radius * (np.cos(angle) - 1.0)
    poses[:, 1, 3] += radius * np.sin(angle)
    return poses


@pytest.mark.parametrize("task", ["position", "pose"])
@pytest.mark.parametrize("start", [HOME, None], ids=["start", "free"])
def test_a_circle_is_followed_inside_the_limits_without_leaps(task, start):
    poses = circle(PANDA, HOME)
    path = fd.joint_path(PANDA, poses, task=task, initial_position=start)
    assert path.success and (path.status == fd.PathStatus.FOLLOWED).all()
    found = PANDA.forward_kinematics(path.q)
    assert np.abs(found[:, :3, 3] - poses[:, :3, 3]).max() < 1e-6
    if task == "pose":
        assert np.abs(found - poses).max() < 1e-5
    assert ((path.q >= PANDA.lower) & (path.q <= PANDA.upper)).all()
    tool = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / PANDA.chain.reach
    steps = np.abs(np.diff(path.q, axis=0)).max(axis=1)
    assert (steps <= path.max_ratio * tool + 2e-3).all()
    if start is not None:
        np.testing.assert_allclose(path.q[0], HOME, atol=1e-3)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 1000))
def test_what_is_called_followed_is_followed(seed):
    """Random lines, many of which leave what the arm can do."""
    arm = fd.load_arm("puma560")
    rng = np.random.default_rng(seed)
    ends = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (2, 6)))[:, :3, 3]
    path = fd.joint_path(arm, np.linspace(*ends, 25), seed=seed)
    away = np.linalg.norm(arm.forward_kinematics(path.q)[:, :3, 3] - path.targets, axis=1)
    assert (away[path.reached] <= 1e-6).all()
    np.testing.assert_allclose(path.error, away, atol=1e-12)
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    leaps = np.abs(np.diff(path.q, axis=0)).max(axis=1)
    allowed = path.max_ratio * np.linalg.norm(ends[1] - ends[0]) / 24 / arm.chain.reach + 0.02
    followed = path.status[1:] == fd.PathStatus.FOLLOWED
    both = followed & path.reached[:-1]
    assert (leaps[both] <= allowed).all()


def test_a_reconfiguration_is_told_with_its_place():
    """A two-link arm with an elbow that bends one way only cannot go on past its shoulder's limit."""
    joint = {"type": "revolute", "lower": -1.0, "upper": 3.1}
    joints = [fd.DhJoint(**joint), fd.DhJoint(a=0.5, type="revolute", lower=-2.8, upper=2.8)]
    arm = fd.DhArm(fd.DhTable("elbow", joints=joints, tool=fd.DhTransform(a=0.5)))
    angle = np.linspace(0.5, -1.3, 40)
    points = 0.7 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    start = np.array([0.5 - np.arccos(0.7), 2.0 * np.arccos(0.7)])
    path = fd.joint_path(arm, points, initial_position=start)
    (k,) = path.reconfigurations
    assert path.q[k - 1][1] > 0.5 and path.q[k][1] < -0.5  # the elbow turned over
    assert -1.0 <= path.q[k - 1][0] < -0.9  # where the shoulder came to its limit
    assert path.reached.all() and not path.success
    assert f"at target {k}" in repr(path)
    (line,) = path.explain()
    turn = path.q[k] - path.q[k - 1]
    assert f"target {k}: RECONFIGURED" in line and f"joint2 by {turn[1]:.3g} rad" in line
    with pytest.raises(ValueError, match=f"target {k} is RECONFIGURED"):
        path.trajectory()


def test_out_of_reach_and_bad_targets_have_a_status_and_the_joints_stay():
    points = circle(PANDA, HOME)[:6, :3, 3]
    points[2], points[4] = np.nan, [9.0, 0.0, 0.0]
    path = fd.joint_path(PANDA, points, initial_position=HOME)
    names = [fd.PathStatus(k).name for k in path.status]
    assert names[2] == "INVALID_INPUT" and names[4] == "NOT_REACHED"
    assert all(names[k] == "FOLLOWED" for k in (0, 1, 3, 5))
    assert (path.q[2] == path.q[1]).all() and np.isfinite(path.q).all()
    assert np.isnan(path.error[2]) and path.error[4] > 1.0
    lines = path.explain(1)
    assert lines == ["target 2: INVALID_INPUT, not finite, or no pose", "and 1 more"]
    assert fd.joint_path(PANDA, np.full((2, 3), np.inf)).status.tolist() == [0, 0]
    bent = np.tile(np.diag([1.0, 1.0, -1.0, 1.0]), (2, 1, 1))
    assert fd.joint_path(PANDA, bent).status.tolist() == [0, 0]


def test_with_obstacles_the_forearm_gives_way(checker_with):
    points = np.tile(PANDA.forward_kinematics(HOME)[:3, 3], (30, 1))
    points[:, 1] += np.linspace(0.0, 0.35, 30)
    alone = fd.joint_path(PANDA, points, initial_position=HOME)
    arm = PANDA.link_poses(alone.q)[:, [3, 5], :3, 3].mean(axis=1)  # middle of the forearm
    beside = arm[-1] + 0.07 * (arm[-1] - arm[0]) / np.linalg.norm(arm[-1] - arm[0])

    checker = checker_with((Sphere(0.02), beside), arm="panda", padding=0.03)
    guard = fd.Clearance(checker, period=0.01)
    assert guard.is_clear(HOME) and not all(guard.is_clear(q) for q in alone.q)
    path = fd.joint_path(PANDA, points, initial_position=HOME, collision_checker=checker)
    assert path.success
    assert all(guard.is_clear(q) for q in path.q)


@pytest.fixture(scope="module")
def two_arms():
    """A plant of two UR5 side by side, half a metre apart, and its scene."""
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    urdf, parser = fd.load_arm("ur5").to_urdf(), Parser(plant)
    for name, y in (("left", 0.25), ("right", -0.25)):
        named = urdf.replace('<robot name="ur5"', f'<robot name="{name}"')
        (arm,) = parser.AddModelsFromString(named, "urdf")
        base = plant.GetFrameByName("base", arm)
        plant.WeldFrames(plant.world_frame(), base, RigidTransform([0.0, y, 0.0]))
    plant.Finalize()
    return plant, scene_graph


UR5_HOME = np.array([0.0, -1.3, 1.6, -1.9, -1.57, 0.0])


def test_one_arm_of_two_in_a_plant_follows_in_the_world(two_arms):
    plant, _ = two_arms
    chain = fd.SerialChain.from_plant(plant, "right::tool")
    start = chain.forward_kinematics(UR5_HOME)[:3, 3]
    points = start + np.outer(np.linspace(0.0, 1.0, 20), [0.0, 0.1, 0.1])
    path = fd.joint_path(chain, points, initial_position=UR5_HOME)
    assert path.success and path.trajectory().rows() == 6
    context = plant.CreateDefaultContext()
    everything = plant.GetPositions(context)
    tool = plant.GetFrameByName("tool", plant.GetModelInstanceByName("right"))
    for q, point in zip(path.q, points):
        plant.SetPositions(context, chain.to_full(q, everything))
        np.testing.assert_allclose(tool.CalcPoseInWorld(context).translation(), point, atol=2e-6)
        left = plant.GetPositions(context, plant.GetModelInstanceByName("left"))
        np.testing.assert_array_equal(left, everything[:6])


def test_one_arm_of_two_keeps_clear_of_the_other(two_arms):
    """Their joints have the same names; the other arm stands where the plant has it by default."""
    plant, scene_graph = two_arms
    checker = fd.MakeCollisionChecker(plant, scene_graph=scene_graph, robot_padding=0.02)
    chain = fd.SerialChain.from_plant(plant, "right::tool")
    assert chain.scoped_joint_names[0] == "right::joint1"
    guard = fd.Clearance(checker, period=0.01, joints=chain.scoped_joint_names)
    start = chain.forward_kinematics(UR5_HOME)[:3, 3]
    elbow = plant.GetBodyByName("link3", plant.GetModelInstanceByName("left"))
    there = plant.EvalBodyPoseInWorld(plant.CreateDefaultContext(), elbow).translation()
    toward = np.linspace(start, there + [-0.1, 0.0, 0.02], 30)  # into the other forearm
    alone = fd.joint_path(chain, toward, initial_position=UR5_HOME)
    assert alone.success and not all(guard.is_clear(q) for q in alone.q)
    path = fd.joint_path(chain, toward, initial_position=UR5_HOME, collision_checker=checker)
    assert 20 < path.reached.sum() < 30
    assert all(guard.is_clear(q) for q in path.q[path.reached])
    with pytest.raises(ValueError, match="right::joint1.*panda::joint1"):
        other = fd.MakeCollisionChecker(PANDA)
        fd.joint_path(chain, toward, collision_checker=other)


def test_relative_to_another_arms_tool(two_arms):
    """In the frame of one tool, which stands where its arm is by default."""
    plant, _ = two_arms
    chain = fd.SerialChain.from_plant(plant, "right::tool", base="left::tool")
    q = UR5_HOME
    points = np.tile(chain.forward_kinematics(q)[:3, 3], (15, 1))
    points[:, 2] += np.linspace(0.0, 0.1, 15)
    path = fd.joint_path(chain, points, initial_position=q)
    assert path.success
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, chain.to_full(path.q[-1], plant.GetPositions(context)))
    right, left = (
        plant.GetFrameByName("tool", plant.GetModelInstanceByName(name))
        for name in ("right", "left")
    )
    found = right.CalcPose(context, left).translation()
    np.testing.assert_allclose(found, points[-1], atol=2e-6)


def test_trajectory_keeps_the_limits_and_the_path():
    poses = circle(PANDA, HOME)
    path = fd.joint_path(PANDA, poses, initial_position=HOME)
    trajectory = path.trajectory(acceleration_limits=8.0)
    times = np.linspace(trajectory.start_time(), trajectory.end_time(), 300)
    q = trajectory.vector_values(times).T
    v, a = (np.array([trajectory.EvalDerivative(t, k)[:, 0] for t in times]) for k in (1, 2))
    assert (np.abs(v) <= 1.01 * PANDA.chain.velocity_limits).all()
    assert np.abs(a).max() <= 8.1
    assert np.abs(v[[0, -1]]).max() < 1e-2
    np.testing.assert_allclose(q[[0, -1]], path.q[[0, -1]], atol=1e-9)
    tool = PANDA.forward_kinematics(q)[:, :3, 3]
    centre = poses[0, :3, 3] - [0.1, 0.0, 0.0]
    radius = np.linalg.norm(tool - centre, axis=1)
    assert np.abs(radius - 0.1).max() < 5e-4
    # It uses what it may: some joint is at a limit most of the time.
    used = np.maximum(np.abs(v / PANDA.chain.velocity_limits), np.abs(a) / 8.0).max(axis=1)
    assert np.mean(used > 0.9) > 0.7


def test_targets_of_all_kinds_are_the_same_path():
    poses = circle(PANDA, HOME, count=30)
    ways = [poses, [RigidTransform(X) for X in poses]]
    paths = [fd.joint_path(PANDA, way, initial_position=HOME) for way in ways]
    np.testing.assert_array_equal(paths[0].q, paths[1].q)
    times = np.linspace(0.0, 1.0, 30)
    for curve in (
        PiecewisePose.MakeLinear(times, ways[1]),
        PiecewisePolynomial.FirstOrderHold(times, poses[:, :3, 3].T),
    ):
        sampled = fd.joint_path(PANDA, curve, initial_position=HOME, samples=30)
        assert sampled.success and len(sampled) == 30
        q = sampled.q if sampled.targets.ndim == 3 else paths[0].q
        np.testing.assert_allclose(q, paths[0].q, atol=1e-4)


def test_poses_in_between_turn_about_one_axis():
    one = np.eye(4)
    two = RigidTransform(fd.load_arm("panda").forward_kinematics(HOME)).GetAsMatrix4()
    half = between(between(one, two, 0.5), two, 0.5)
    np.testing.assert_allclose(half, between(one, two, 0.75), atol=1e-9)
    np.testing.assert_allclose(between(one, two, 1.0), two, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("x,y,z\n0.1,0.2,0.3\n\n0.1,0.2,0.4\n", (2, 3)),
        ("0.1,0.2,0.3,0,0,1.5 # up\n", (1, 4, 4)),
        ("0.1;0.2;0.3;1;0;0;0\n", (1, 4, 4)),
    ],
)
def test_csv(tmp_path, text, shape):
    path = tmp_path / "way.csv"
    path.write_text(text)
    assert load_path_csv(path).shape == shape


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no targets"),
        ("0.1,0.2\n", "line 1.*columns"),
        ("1,2,3\n1,2\n", "line 2"),
        ("1,2,3\na,b,c\n", "line 2.*numbers"),
        ("1,2,nan\n", "finite"),
        ("1,2,3,0,0,0,0\n", "quaternion"),
    ],
)
def test_bad_csv(tmp_path, text, words):
    path = tmp_path / "way.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=words):
        load_path_csv(path)


def test_save_csv_is_read_back(tmp_path):
    path = fd.joint_path(PANDA, circle(PANDA, HOME, count=5), initial_position=HOME)
    path.save_csv(tmp_path / "joints.csv")
    first, *lines = (tmp_path / "joints.csv").read_text().splitlines()
    assert first.startswith("target,joint1,") and first.endswith("status,error_m")
    rows = np.array([[float(x) for x in line.split(",")[1:8]] for line in lines])
    np.testing.assert_array_equal(rows, path.q)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"targets": np.zeros((3, 2))}, "positions"),
        ({"task": "xy"}, "task"),
        ({"task": "pose"}, "task"),
        ({"initial_position": [0.0]}, "initial_position"),
        ({"initial_position": np.full(7, 9.0)}, "joint1"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"max_ratio": -1.0}, "max_ratio"),
        ({"arm": 3}, "arm"),
    ],
)
def test_bad_arguments(options, words):
    arguments = {"arm": PANDA, "targets": np.zeros((2, 3))} | options
    with pytest.raises(ValueError, match=words):
        fd.joint_path(arguments.pop("arm"), arguments.pop("targets"), **arguments)
