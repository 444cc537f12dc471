"""Redundancy resolution by Newton's method and traces: arms with one spare degree of freedom."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs
from fikm_drake.solvers.redundancy.postures_at_joint import PosturesAtJoint
from fikm_drake.solvers.redundancy.workspace_points import (
    random_tool_poses,
    random_workspace_points,
)

STATUS = fd.ResolutionStatus


@pytest.fixture(scope="module")
def arm():
    return fd.load_arm("hassantabar4r")


@pytest.fixture(scope="module")
def resolver(arm):
    return fd.RedundancyResolver(arm, task="pose")


def check(arm, poses, found):
    """Every posture is inside the limits, and the tool is at its pose."""
    assert found.success.all(), found
    assert ((found.q >= arm.lower) & (found.q <= arm.upper)).all()
    assert np.abs(arm.forward_kinematics(found.q) - poses).max() <= 1e-12
    assert found.position_error.max() <= 1e-12 and found.rotation_error.max() <= 1e-12


def test_learned_bounds_of_a_planar_4r(arm, resolver):
    """Claimed: 97 % inside the limits without repair, all with it; the tool at the pose."""
    poses = random_tool_poses(arm, 500, seed=21, near_limits=0.0)
    found = resolver.resolve(poses)
    check(arm, poses, found)
    assert np.mean(found.status == STATUS.SOLVED) >= 0.97
    resolved = found.status == STATUS.SOLVED
    middle = np.clip(0.5 * (found.lower + found.upper)[resolved], arm.lower[0], arm.upper[0])
    np.testing.assert_allclose(found.q[resolved, 0], middle, atol=1e-12)


def test_repair_takes_the_traced_middle(arm):
    """Bounds that are far off change nothing but the status."""
    poses = random_tool_poses(arm, 20, seed=22, near_limits=0.0)
    X = BoundsInputs(arm, "pose", "xy")(poses)
    far = Anfis((1, 1, 1)).fit(X, np.full(20, 40.0), epochs=1)
    bounds = fd.LearnedBounds(arm, "xy", far, far, task="pose", joint=2)
    found = fd.RedundancyResolver(arm, bounds, task="pose", joint=2).resolve(poses)
    check(arm, poses, found)
    repaired = np.flatnonzero(found.status == STATUS.REPAIRED)
    assert len(repaired) > 10
    for k in repaired:
        (interval,) = fd.trace_self_motion(arm, poses[k], "pose").intervals(2)
        np.testing.assert_allclose(
            [found.lower[k], found.upper[k]], [interval.lower, interval.upper], atol=1e-9
        )
        assert found.q[k, 2] == pytest.approx(0.5 * (interval.lower + interval.upper), abs=1e-9)


def test_postures_of_a_component_with_a_joint_at_a_position():
    """A loop passes each position between a joint's extremes twice; past them there is none."""
    arm = fd.load_arm("planar4")
    motion = fd.trace_self_motion(arm, [0.4, 0.9, -0.7, 0.5], "pose")
    component = motion.components[0]
    low, high = component.lower[1], component.upper[1]
    found = component.with_joint_at(1, 0.3 * low + 0.7 * high)
    assert len(found) >= 2
    np.testing.assert_allclose(found[:, 1], 0.3 * low + 0.7 * high, atol=1e-11)
    pose = arm.forward_kinematics([0.4, 0.9, -0.7, 0.5])
    np.testing.assert_allclose(
        arm.forward_kinematics(found), np.stack([pose] * len(found)), atol=1e-12
    )
    assert component.with_joint_at(1, high + 0.1).shape == (0, 4)


@pytest.mark.parametrize(("name", "joint"), [("iiwa14", 2), ("iiwa14", 3), ("planar4", 0)])
def test_arms_without_learned_bounds_are_traced(name, joint):
    """Seven joints; a joint that does not move along the self-motion; no limits at all."""
    arm = fd.load_arm(name)
    poses = random_tool_poses(arm, 2, seed=23, near_limits=0.0)
    found = fd.RedundancyResolver(arm, task="pose", joint=joint).resolve(poses)
    check(arm, poses, found)
    assert (found.status == STATUS.REPAIRED).all()
    assert (found.lower <= found.q[:, joint] + 1e-12).all()
    assert (found.q[:, joint] <= found.upper + 1e-12).all()


def test_tracing_agrees_with_the_closed_form():
    """The planar 3R by another joint: joint 1 is within its exact bounds, the tool at the point."""
    arm = fd.load_arm("hassantabar3r")
    points = random_workspace_points(arm, 15, seed=24)
    for joint in (1, 2):
        found = fd.RedundancyResolver(arm, joint=joint).resolve(points)
        assert found.success.all() and found.position_error.max() <= 1e-12
        for k, point in enumerate(points):
            (region,) = fd.feasible_intervals(arm, point)
            assert region.lower - 1e-9 <= found.q[k, 0] <= region.upper + 1e-9


def test_prismatic_joints():
    """A slide and two joints in the plane, the task xy: no closed form, joint 1 in metres."""
    up = fd.DhJoint(alpha=np.pi / 2, type="prismatic", lower=0.0, upper=1.0)
    first = fd.DhJoint(alpha=-np.pi / 2, a=0.2, lower=-1.5, upper=1.5)
    second = fd.DhJoint(a=0.6, lower=-2.0, upper=2.0)
    arm = fd.DhArm(fd.DhTable("slide", "craig", [up, first, second], fd.DhTransform(a=0.5)))
    points = random_tool_poses(arm, 5, seed=25, near_limits=0.0)[:, :2, 3]
    found = fd.RedundancyResolver(arm).resolve(points)
    assert found.success.all() and found.position_error.max() <= 1e-12
    np.testing.assert_allclose(found.q[:, 0], 0.5 * (found.lower + found.upper), atol=1e-9)


def test_newton_finds_every_pose_with_its_joint_in_its_region(arm):
    """The joint where a posture inside the limits has it: some posture is found, and it has it."""
    rng = np.random.default_rng(26)
    q = arm.lower + (arm.upper - arm.lower) * rng.uniform(0.02, 0.98, (300, 4))
    poses = arm.forward_kinematics(q)
    found, good = PosturesAtJoint(arm, Task("pose"), 1).solve(poses, q[:, 1])
    assert good.mean() >= 0.95
    np.testing.assert_array_equal(found[:, 1], q[:, 1])
    assert np.abs(arm.forward_kinematics(found[good]) - poses[good]).max() <= 1e-9


def test_what_cannot_be_reached_is_flagged(arm, resolver):
    good = arm.forward_kinematics([0.8, 0.7, 1.0, 0.3])
    bad = np.tile(good, (6, 1, 1))
    bad[0, 0, 3], bad[1, 0, 3], bad[2, 2, 3] = 9.0, 1e99, 0.1
    bad[3, 0, 3], bad[4, 0, 0], bad[5, 0, 0] = np.nan, np.inf, 3.0
    found = resolver.resolve([*bad, good])
    wanted = [STATUS.INFEASIBLE] * 3 + [STATUS.INVALID_INPUT] * 3 + [STATUS.SOLVED]
    assert found.status.tolist() == wanted
    columns = (found.q, found.lower, found.upper, found.position_error, found.rotation_error)
    for values in columns:
        assert np.isnan(values[:6]).all() and np.isfinite(values[6]).all()


@settings(max_examples=40)
@given(st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-4, 4)))
def test_whatever_the_pose_there_is_an_answer(arm, resolver, place):
    x, y, angle = place
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:2, 3] = x, y
    found = resolver.resolve([pose])
    assert found.success[0] == (found.status[0] <= STATUS.REPAIRED)
    assert np.isfinite(found.q).all() == found.success[0]
    if found.success[0]:
        check(arm, pose[None], found)


def test_rotations_that_are_rounded_are_reached(arm, resolver):
    poses = np.round(random_tool_poses(arm, 20, seed=27, near_limits=0.0), 6)
    found = resolver.resolve(poses)
    assert found.success.all() and found.rotation_error.max() <= 1e-12


def test_poses_do_not_influence_each_other(arm, resolver):
    poses = np.tile(random_tool_poses(arm, 50, seed=29, near_limits=0.0), (30, 1, 1))
    found = resolver.resolve(poses)
    np.testing.assert_allclose(found.q[-50:], resolver.resolve(poses[:50]).q, atol=1e-9)


def test_no_poses(resolver):
    found = resolver.resolve(np.empty((0, 4, 4)))
    assert found.q.shape == (0, 4) and len(found) == 0


@pytest.mark.parametrize("inputs", ["xy", "polar"])
def test_bounds_are_learned_from_traces(arm, inputs, tmp_path):
    seen = []
    learned = fd.train_traced_bounds(
        arm, inputs=inputs, memberships=(2, 3, 3), points=60, epochs=3, progress=seen.append
    )
    assert seen[-1] == pytest.approx(1.0) and seen == sorted(seen)
    learned.save(tmp_path / "bounds.yaml")
    read = fd.LearnedBounds.load(tmp_path / "bounds.yaml")
    poses = random_tool_poses(arm, 15, seed=28, near_limits=0.0)
    np.testing.assert_array_equal(read.predict(poses), learned.predict(poses))
    found = fd.RedundancyResolver(arm, read, task="pose").resolve(poses)
    check(arm, poses, found)
    assert np.mean(found.status == STATUS.SOLVED) > 0.5


def test_inputs_of_poses(arm):
    """x, y and the tool's angle, cut opposite to the middle of the limits: 3 pi / 4 + pi / 4."""
    q = np.array([[0.3, 0.4, 0.5, 0.6], [1.5, 1.5, 3.0, 1.5]])
    poses = arm.forward_kinematics(q)
    x, y, psi = BoundsInputs(arm, "pose", "xy")(poses).T
    np.testing.assert_allclose(np.stack([x, y]), poses[:, :2, 3].T)
    np.testing.assert_allclose(psi, [1.8, 7.5 - 2 * np.pi])
    r, phi, relative = BoundsInputs(arm, "pose", "polar")(poses).T
    np.testing.assert_allclose(r * np.cos(phi), x)
    np.testing.assert_allclose(np.cos(relative + phi), np.cos(psi))


@pytest.mark.parametrize(
    ("use", "words"),
    [
        (lambda arm, r: r.resolve(np.eye(4)), ["(N, 4, 4)", "(4, 4)"]),
        (lambda arm, r: r.resolve(np.zeros((3, 2))), ["(N, 4, 4)", "(3, 2)"]),
        (lambda arm, r: fd.RedundancyResolver(arm), ["xy", "leaves 2"]),
        (lambda arm, r: fd.RedundancyResolver(arm, task="round"), ["task", "round"]),
        (lambda arm, r: fd.RedundancyResolver(arm, task="pose", joint=4), ["joint", "0 … 3", "4"]),
        (lambda arm, r: fd.RedundancyResolver(arm, task="pose", joint=-1), ["joint", "-1"]),
        (
            lambda arm, r: fd.RedundancyResolver(arm, r.bounds, task="pose", joint=1),
            ["joint 0", "joint 1"],
        ),
        (
            lambda arm, r: fd.RedundancyResolver(fd.load_arm("planar4"), r.bounds, task="pose"),
            ["hassantabar4r", "planar4"],
        ),
        (lambda arm, r: fd.train_traced_bounds(arm, inputs="round"), ["inputs", "round", "polar"]),
        (lambda arm, r: fd.train_traced_bounds(arm, task="xz"), ["task", "xz", "pose"]),
        (lambda arm, r: fd.train_traced_bounds(arm, joint=4), ["joint", "4"]),
        (lambda arm, r: fd.train_traced_bounds(arm, points=0), ["count", "0"]),
        (lambda arm, r: fd.train_traced_bounds(arm, memberships=(5, 5)), ["memberships", "(5, 5)"]),
        (lambda arm, r: fd.train_traced_bounds(fd.load_arm("iiwa14")), ["iiwa14", "four"]),
    ],
)
def test_refuses(use, words, arm, resolver):
    with pytest.raises(ValueError) as error:
        use(arm, resolver)
    for word in words:
        assert word in str(error.value)
