"""Traced self-motions: against closed forms, on the target, within the limits, whole."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.kinematics.add_dh_arm import AddDhArm, MakeDhArmPlant
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.self_motion import spare_task
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import (
    feasible_interval_table,
    feasible_intervals,
)
from fikm_drake.solvers.self_motion.self_motion import SelfMotionStatus
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer, trace_self_motion

GRIPPER = """
<robot name="gripper">
  <link name="palm"/>
  <link name="finger"/>
  <joint name="slide" type="prismatic">
    <parent link="palm"/> <child link="finger"/> <axis xyz="0 1 0"/>
    <limit effort="1" lower="0" upper="0.05" velocity="1"/>
  </joint>
</robot>
"""


def planar(lengths, limits):
    rows = [
        DhJoint(a=a, lower=low, upper=high) for a, (low, high) in zip((0.0, *lengths[:-1]), limits)
    ]
    return DhArm(DhTable("planar", "craig", rows, DhTransform(a=lengths[-1])))


def check(arm, motion, target, rows=slice(None), task_tolerance=1e-12):
    """Every point on the target and within the limits, every end where it says, extents right."""
    for component in motion.components:
        q = component.q
        assert (q >= arm.lower - 1e-12).all() and (q <= arm.upper + 1e-12).all()
        off = arm.forward_kinematics(q) - target
        assert np.abs(off[..., :3, 3][..., rows]).max() <= task_tolerance
        assert (np.diff(component.arc_length) > 0).all()
        np.testing.assert_allclose(np.linalg.norm(component.tangents, axis=1), 1.0, rtol=1e-12)
        for end, point in zip(component.ends, (q[0], q[-1])):
            if end != "closed":
                _, joint, side = end.split()
                limit = (arm.lower if side == "lower" else arm.upper)[int(joint) - 1]
                assert point[int(joint) - 1] == limit
        assert (component.lower <= q.min(axis=0)).all()
        assert (component.upper >= q.max(axis=0)).all()


def test_150_points_of_the_thesis_against_the_closed_form():
    arm = load_arm("hassantabar3r")
    tracer = SelfMotionTracer(arm, "xy")
    q = np.random.default_rng(11).uniform(arm.lower, arm.upper, (150, 3))
    points = arm.forward_kinematics(q)[:, :2, 3]
    table = feasible_interval_table(arm, points)
    for i, point in enumerate(points):
        motion = tracer.trace(point)
        assert motion.status == SelfMotionStatus.TRACED
        (interval,), (exact,) = motion.intervals(0), table[i]
        assert interval.lower == pytest.approx(exact.lower, abs=1e-9)
        assert interval.upper == pytest.approx(exact.upper, abs=1e-9)


def test_a_target_that_is_nearly_singular():
    """At r = 2.5 m two branches meet; near it the tracer must not pass from one to the other."""
    arm = load_arm("hassantabar3r")
    tracer = SelfMotionTracer(arm, "xy")
    for gap in (1e-2, 1e-4, 1e-6, -1e-6, -1e-4, -1e-2):
        point = (2.5 + gap) * np.array([np.cos(1.23), np.sin(1.23)])
        (interval,), (exact,) = tracer.trace(point).intervals(0), feasible_intervals(arm, point)
        assert interval.lower == pytest.approx(exact.lower, abs=1e-9)
        assert interval.upper == pytest.approx(exact.upper, abs=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_random_planar_arms_with_several_components(seed):
    rng = np.random.default_rng(seed)
    limits = np.sort(rng.uniform(-3.1, 3.1, (3, 2)), axis=1).tolist()
    if seed % 4 == 3:
        limits[1] = (None, None)
    if seed % 4 == 2:
        limits[2] = (None, None)
    arm = planar(rng.uniform(0.3, 2.0, 3), limits)
    tracer = SelfMotionTracer(arm, "xy")
    for point in rng.uniform(-2.5, 2.5, (15, 2)):
        motion, exact = tracer.trace(point), feasible_intervals(arm, point)
        traced = motion.intervals(0)
        assert len(traced) == len(exact)
        for ours, theirs in zip(traced, exact):
            assert (ours.lower, ours.upper) == pytest.approx((theirs.lower, theirs.upper), abs=1e-9)
        reached = SelfMotionStatus.TRACED if exact else SelfMotionStatus.INFEASIBLE
        assert motion.status in (reached, SelfMotionStatus.UNREACHABLE)
        assert bool(motion.components) == bool(exact)


def test_a_joint_with_hardly_any_range():
    """A piece of the self-motion that is far shorter than a step along it is found."""
    arm = planar((0.6, 1.5, 1.1), [(0.7, 0.7005), (-2.5, 2.0), (-3.0, 2.8)])
    tracer = SelfMotionTracer(arm, "xy")
    q = np.random.default_rng(8).uniform(arm.lower, arm.upper, (30, 3))
    for point in arm.forward_kinematics(q)[:, :2, 3]:
        traced, exact = tracer.trace(point).intervals(0), feasible_intervals(arm, point)
        assert len(traced) == len(exact) == 1
        assert traced[0].lower == pytest.approx(exact[0].lower, abs=1e-9)
        assert traced[0].upper == pytest.approx(exact[0].upper, abs=1e-9)


@pytest.mark.parametrize("name", ["iiwa14", "panda"])
def test_poses_of_7_joint_arms(name):
    arm = load_arm(name)
    tracer = SelfMotionTracer(arm, "pose")
    for q in np.random.default_rng(5).uniform(arm.lower, arm.upper, (5, 7)):
        motion, X = tracer.trace(q), arm.forward_kinematics(q)
        assert motion.status == SelfMotionStatus.TRACED
        check(arm, motion, X)
        for component in motion.components:
            assert np.abs(arm.forward_kinematics(component.q) - X).max() <= 1e-11
        first = motion.components[0]
        assert np.linalg.norm(first.q - q, axis=1).min() < 1e-9
        by_pose = tracer.trace(X)
        assert len(by_pose.components) == len(motion.components)
        lengths = [sorted(c.length for c in m.components) for m in (by_pose, motion)]
        assert lengths[0] == pytest.approx(lengths[1], abs=1e-3)


def test_elbow_of_an_iiwa_does_not_move():
    """A 7-joint arm with a spherical shoulder and wrist: joint 4 sets their distance."""
    arm = load_arm("iiwa14")
    component = trace_self_motion(arm, [0.2, 0.6, 0.1, -1.4, 0.3, 1.0, 0.4], "pose").components[0]
    assert component.upper[3] - component.lower[3] < 1e-12
    assert (component.upper - component.lower)[[0, 1, 2, 4, 5, 6]].min() > 0.1


def test_elbow_circle_of_a_free_arm_closes():
    """arm7 has no limits: its elbow turns about the line from shoulder to wrist and comes back."""
    arm = load_arm("arm7")
    q = np.array([0.4, -0.5, 0.8, 1.1, -0.3, 0.9, 0.2])
    motion = trace_self_motion(arm, q, "pose")
    assert motion.status == SelfMotionStatus.TRACED
    check(arm, motion, arm.forward_kinematics(q))
    for component in motion.components:
        assert component.closed
        turns = (component.q[-1] - component.q[0]) / (2 * np.pi)
        np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)


def test_a_singular_posture_is_reported():
    """All joints of arm7 alike: no direction of its self-motion is distinguished."""
    motion = trace_self_motion(load_arm("arm7"), np.full(7, 0.4), "pose")
    assert motion.status == SelfMotionStatus.INCOMPLETE
    assert motion.components[0].ends == ("singular", "singular")
    np.testing.assert_allclose(motion.components[0].q, [np.full(7, 0.4)], atol=1e-9)


@pytest.mark.parametrize(
    "name, task, count",
    [("iiwa14", "pose", 4), ("panda", "pose", 6), ("hassantabar3r", "xy", 12), ("arm7", "pose", 4)],
)
def test_the_kernel_traces_what_numpy_traces(native_kernel, monkeypatch, name, task, count):
    arm = load_arm(name)
    q = np.random.default_rng(5).uniform(
        np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0), (count, arm.num_joints)
    )
    monkeypatch.setattr(spare_task, "kernel", lambda: native_kernel)
    native = SelfMotionTracer(arm, task)
    ours = [native.trace(row) for row in q]
    monkeypatch.setattr(spare_task, "kernel", lambda: None)
    numpy = SelfMotionTracer(arm, task)
    for one, row in zip(ours, q):
        two = numpy.trace(row)
        assert one.status == two.status and len(one.components) == len(two.components)
        for a, b in zip(one.components, two.components):
            assert a.curve.native and not b.curve.native
            assert a.ends == b.ends
            moves = a.upper - a.lower > 1e-9  # of a joint that stands any point may be the least
            for ends in ("lower_end", "upper_end"):
                assert (np.array(getattr(a, ends)) == getattr(b, ends))[moves].all()
            assert a.length == pytest.approx(b.length, rel=1e-4)
            np.testing.assert_allclose([a.lower, a.upper], [b.lower, b.upper], rtol=0, atol=1e-9)


def test_four_joints_with_planar_pose_are_three_joints_with_position():
    """With its orientation held a planar 4R arm's first three joints are a planar 3R arm."""
    limits = [(-1.0, 2.0), (-2.0, 1.5), (-1.0, 2.5), (-9.0, 9.0)]
    four = planar((1.0, 0.8, 0.6, 0.3), limits)
    three = planar((1.0, 0.8, 0.6), limits[:3])
    q = np.array([0.3, 0.5, 0.7, -0.4])
    motion = trace_self_motion(four, q, "pose")
    point = three.forward_kinematics(q[:3])[:2, 3]
    check(four, motion, four.forward_kinematics(q))
    traced, exact = motion.intervals(0), feasible_intervals(three, point)
    assert len(traced) == len(exact) > 0
    for ours, theirs in zip(traced, exact):
        assert (ours.lower, ours.upper) == pytest.approx((theirs.lower, theirs.upper), abs=1e-9)
    for component in motion.components:
        np.testing.assert_allclose(component.q.sum(axis=1), q.sum(), atol=1e-11)


def test_orientation_of_four_joints():
    rows = [DhJoint(alpha=a, lower=-2.5, upper=2.5) for a in (0.0, np.pi / 2, -np.pi / 2, 1.0)]
    arm = DhArm(DhTable("wrist", "craig", rows, DhTransform(d=0.1)))
    q = np.array([0.3, -0.6, 0.8, 0.5])
    motion = trace_self_motion(arm, q, "orientation")
    for component in motion.components:
        turned = arm.forward_kinematics(component.q)[:, :3, :3] - arm.forward_kinematics(q)[:3, :3]
        assert np.abs(turned).max() < 1e-12
    assert np.linalg.norm(motion.components[0].q - q, axis=1).min() < 1e-9


def test_prismatic_joint_has_a_closed_form():
    """Turn, slide, turn in the plane: the last joint's angle determines the other two."""
    rows = [
        DhJoint(lower=-1.5, upper=1.5),
        DhJoint(alpha=np.pi / 2, type="prismatic", lower=0.5, upper=2.0),
        DhJoint(alpha=-np.pi / 2, lower=-3.0, upper=3.0),
    ]
    arm = DhArm(DhTable("slide", "craig", rows, DhTransform(a=0.4)))
    q = np.array([0.2, 1.2, 0.5])
    X = arm.forward_kinematics(q)
    motion = trace_self_motion(arm, q, "xy")
    check(arm, motion, X, slice(2))
    # The end of the slide is 0.4 m from the point, so its reach is between r - 0.4 and r + 0.4.
    r = np.hypot(*X[:2, 3])
    slide = motion.intervals(1)
    assert slide[0].lower == pytest.approx(max(r - 0.4, 0.5), abs=1e-6)
    assert slide[-1].upper <= min(r + 0.4, 2.0) + 1e-12


def test_plant_with_joints_that_do_not_move_the_tool():
    """An arm with a gripper, beside another arm, in a world frame that is not its base."""
    arm = load_arm("hassantabar3r")
    plant = MultibodyPlant(0.0)
    AddDhArm(plant, load_arm("planar2"))
    instance = AddDhArm(plant, arm)
    Parser(plant).AddModelsFromString(GRIPPER, "urdf")
    plant.WeldFrames(plant.GetFrameByName("tool", instance), plant.GetFrameByName("palm"))
    plant.Finalize()
    point = [1.0, 2.0]
    motion = trace_self_motion(plant, point, "xy", frame="palm")
    (exact,) = feasible_intervals(arm, point)
    (component,) = motion.components
    assert component.q.shape[1] == plant.num_positions() == 6
    (interval,) = motion.intervals(plant.GetJointByName("joint1", instance).position_start())
    assert (interval.lower, interval.upper) == pytest.approx((exact.lower, exact.upper), abs=1e-9)
    q = component.q[2].copy()
    finger = plant.GetJointByName("slide").position_start()
    q[finger] = 0.03
    again = trace_self_motion(plant, q, "xy", frame="palm").components[0]
    np.testing.assert_array_equal(again.q[:, finger], 0.03)


def test_arm_and_its_plant_are_the_same():
    arm = load_arm("panda")
    q = np.array([0.1, -0.7, 0.2, -2.2, 0.1, 1.6, 0.7])
    ours = trace_self_motion(arm, q, "pose")
    theirs = trace_self_motion(MakeDhArmPlant(arm), q, Task("pose"))
    assert [c.ends for c in ours.components] == [c.ends for c in theirs.components]
    np.testing.assert_array_equal(ours.components[0].q, theirs.components[0].q)


def test_points_between_are_on_the_curve_and_arc_length_is_length():
    arm = load_arm("iiwa14")
    q = np.array([0.2, 0.6, 0.1, -1.4, 0.3, 1.0, 0.4])
    X = arm.forward_kinematics(q)
    component = trace_self_motion(arm, q, "pose").components[0]
    at = np.linspace(0.0, component.length, 2001)
    between = np.array([component.at(s) for s in at])
    assert np.abs(arm.forward_kinematics(between) - X).max() < 1e-12
    chords = np.linalg.norm(np.diff(between, axis=0), axis=1)
    assert chords.sum() == pytest.approx(component.length, rel=1e-6)
    np.testing.assert_allclose(chords, component.length / 2000, rtol=5e-3)
    for bad in (-1e-9, component.length + 1e-6, np.nan):
        with pytest.raises(ValueError, match="arc_length"):
            component.at(bad)


def test_closest_posture_is_the_closed_form_s():
    arm = load_arm("hassantabar3r")
    tracer = SelfMotionTracer(arm, "xy")
    middle = 0.5 * (arm.lower + arm.upper)
    q = np.random.default_rng(6).uniform(arm.lower, arm.upper, (50, 3))
    points = arm.forward_kinematics(q)[:, :2, 3]
    for point, exact in zip(points, closest_to_mid_range(arm, points)):
        np.testing.assert_allclose(tracer.trace(point).closest_to(middle), exact, atol=1e-9)
    assert tracer.trace([-2.0, 1.0]).closest_to(middle) is None


def test_extents_of_every_joint_against_a_scan_of_the_curve():
    arm = load_arm("panda")
    q = np.array([0.1, -0.7, 0.2, -2.2, 0.1, 1.6, 0.7])
    for component in trace_self_motion(arm, q, "pose").components:
        dense = np.array([component.at(s) for s in np.linspace(0.0, component.length, 3000)])
        np.testing.assert_allclose(component.lower, dense.min(axis=0), atol=1e-5)
        np.testing.assert_allclose(component.upper, dense.max(axis=0), atol=1e-5)
        assert (component.lower <= dense.min(axis=0) + 1e-12).all()
        assert (component.upper >= dense.max(axis=0) - 1e-12).all()


def test_start_at_a_limit_and_at_a_corner():
    arm = load_arm("hassantabar3r")
    (interval,) = feasible_intervals(arm, [1.0, 2.0])
    motion = trace_self_motion(arm, [1.0, 2.0], "xy")
    end = motion.components[0].q[0]
    again = trace_self_motion(arm, end, "xy")
    assert len(again.components) == 1
    assert again.components[0].length == pytest.approx(motion.components[0].length, abs=1e-5)
    assert again.intervals(0)[0].upper == pytest.approx(interval.upper, abs=1e-9)
    corner = trace_self_motion(arm, arm.upper, "xy")
    assert corner.status in (SelfMotionStatus.TRACED, SelfMotionStatus.INFEASIBLE)
    check(arm, corner, arm.forward_kinematics(arm.upper), slice(2))


def test_statuses_of_targets_without_postures():
    arm = load_arm("hassantabar3r")
    tracer = SelfMotionTracer(arm, "xy")
    assert tracer.trace([9.0, 0.0]).status == SelfMotionStatus.UNREACHABLE
    infeasible = tracer.trace([-2.0, 1.0])
    assert infeasible.status == SelfMotionStatus.INFEASIBLE
    assert infeasible.components == [] and infeasible.intervals(0) == []
    four = planar((1.0, 0.8, 0.6, 0.3), [(-2.0, 2.0)] * 4)
    X = four.forward_kinematics([0.3, 0.5, 0.7, -0.4])
    X[2, 3] = 0.1  # out of the plane, in a row that no joint moves
    assert trace_self_motion(four, X, "pose").status == SelfMotionStatus.UNREACHABLE
    tilted = RigidTransform(RotationMatrix.MakeXRotation(0.2), [1.5, 0.5, 0.0])
    assert trace_self_motion(four, tilted, "pose").status == SelfMotionStatus.UNREACHABLE


def test_posture_outside_the_limits_stands_for_its_target():
    arm = load_arm("hassantabar3r")
    q = np.array([0.5, -0.3, 2.0])
    motion = trace_self_motion(arm, q, "xy")
    exact = feasible_intervals(arm, arm.forward_kinematics(q)[:2, 3])
    assert len(motion.intervals(0)) == len(exact)
    check(arm, motion, arm.forward_kinematics(q), slice(2))


def test_same_every_time():
    arm = load_arm("panda")
    first, second = (
        trace_self_motion(arm, arm.forward_kinematics(arm.default_position), "pose") for _ in "ab"
    )
    assert [c.q.tolist() for c in first.components] == [c.q.tolist() for c in second.components]


@pytest.mark.parametrize(
    ("name", "task", "words"),
    [
        ("planar4", "xy", "leaves 2"),
        ("iiwa14", "position", "leaves 3"),
        ("puma560", "pose", "leaves 0"),
        ("hassantabar3r", "tilt", "task must be one of"),
    ],
)
def test_tasks_that_leave_not_one_degree_of_freedom(name, task, words):
    with pytest.raises(ValueError, match=words):
        SelfMotionTracer(load_arm(name), task)


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ([1.0], "coordinates"),
        ([1.0, np.nan], "finite"),
        ([np.nan, 0.0, 0.0], "finite"),
        (np.diag([2.0, 1.0, 1.0, 1.0]), "a pose"),
        (np.diag([-1.0, 1.0, 1.0, 1.0]), "a pose"),
        (np.full((4, 4), np.nan), "finite"),
    ],
)
def test_bad_targets_are_named(target, words):
    with pytest.raises(ValueError, match=words):
        trace_self_motion(load_arm("hassantabar3r"), target, "xy")


def test_bad_options_plants_and_joints_are_named():
    arm = load_arm("hassantabar3r")
    with pytest.raises(ValueError, match="searches"):
        SelfMotionTracer(arm, "xy", searches=0)
    with pytest.raises(ValueError, match="max_step"):
        SelfMotionTracer(arm, "xy", max_step=np.nan)
    with pytest.raises(ValueError, match="finalized"):
        SelfMotionTracer(MultibodyPlant(0.0), "xy")
    with pytest.raises(ValueError, match="'hand'"):
        SelfMotionTracer(MakeDhArmPlant(arm), "xy", frame="hand")
    with pytest.raises(ValueError, match="a pose"):
        trace_self_motion(load_arm("iiwa14"), [0.5, 0.0, 0.5], "pose")
    with pytest.raises(ValueError, match="joint must be in 0 … 2"):
        trace_self_motion(arm, [1.0, 2.0], "xy").intervals(3)
