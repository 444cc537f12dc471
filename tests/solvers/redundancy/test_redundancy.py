"""Learned bounds and redundancy resolution: limits, the tool's place, flags, files."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.workspace_points import (
    random_workspace_points,
    workspace_points,
)

STATUS = fd.ResolutionStatus


@pytest.fixture(scope="module")
def arm():
    return fd.load_arm("hassantabar3r")


@pytest.fixture(scope="module")
def resolver(arm):
    return fd.RedundancyResolver(arm)


@pytest.fixture(scope="module")
def other():
    """An arm with offsets, other lengths and two elbows inside its limits."""
    joints = [
        fd.DhJoint(a=0.0, theta=0.3, lower=-2.0, upper=1.0),
        fd.DhJoint(a=1.2, theta=-0.2, lower=-1.5, upper=1.8),
        fd.DhJoint(a=0.7, lower=-2.5, upper=2.0),
    ]
    return fd.DhArm(fd.DhTable("other3r", "craig", joints, fd.DhTransform(a=0.9)))


def inside(arm, q):
    return ((q >= arm.lower) & (q <= arm.upper)).all(axis=1)


def test_random_points_are_reached_inside_the_limits(arm, resolver):
    """Section 4.5: 99.4 % by the learned bounds alone, all after repair, the tool at the point."""
    points = random_workspace_points(arm, 5000, seed=7)
    found = resolver.resolve(points)
    assert found.success.all()
    assert inside(arm, found.q).all()
    tool = arm.forward_kinematics(found.q)[:, :2, 3]
    assert np.abs(tool - points).max() <= 1e-12
    np.testing.assert_allclose(found.position_error, np.hypot(*(tool - points).T), atol=1e-15)
    assert np.mean(found.status == STATUS.SOLVED) >= 0.994


def test_joint_1_is_in_the_middle_of_its_bounds(resolver):
    found = resolver.resolve([[1.0, 2.0], [-1.0, 3.0], [2.0, 3.0]])
    np.testing.assert_allclose(found.q[:, 0], 0.5 * (found.lower + found.upper), atol=1e-15)


def test_repair_takes_the_exact_middle(arm):
    """Bounds that are far off change nothing but the status."""
    points = random_workspace_points(arm, 300, seed=8)
    far = Anfis((2, 2)).fit(points, np.full(300, 1.5), epochs=1)
    found = fd.RedundancyResolver(arm, LearnedBounds(arm, "xy", far, far)).resolve(points)
    assert found.success.all() and inside(arm, found.q).all()
    repaired = found.status == STATUS.REPAIRED
    assert repaired.any()
    lower, upper = fd.feasible_interval_table(arm, points[repaired]).widest()
    np.testing.assert_allclose(found.q[repaired, 0], 0.5 * (lower + upper), atol=1e-12)
    np.testing.assert_array_equal(found.lower[repaired], lower)


def test_what_cannot_be_reached_is_flagged(resolver):
    points = [[5.0, 5.0], [1.0, -2.0], [0.0, 0.0], [np.nan, 1.0], [1.0, np.inf], [1.0, 2.0]]
    found = resolver.resolve(points)
    wanted = [STATUS.INFEASIBLE] * 3 + [STATUS.INVALID_INPUT] * 2 + [STATUS.SOLVED]
    assert found.status.tolist() == wanted
    assert found.success.tolist() == [False] * 5 + [True]
    for values in (found.q, found.lower, found.upper, found.position_error):
        assert np.isnan(values[:5]).all() and np.isfinite(values[5]).all()
    assert "3 infeasible" in repr(found) and "2 invalid_input" in repr(found)


def test_edge_of_the_workspace(arm, resolver):
    """Stretched out along x and y: one posture only."""
    found = resolver.resolve([[4.5, 0.0], [0.0, 4.5]])
    assert found.success.all() and inside(arm, found.q).all()
    assert found.position_error.max() < 1e-6


@given(st.tuples(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9)) | st.tuples(*[st.floats()] * 2))
def test_whatever_the_point_there_is_an_answer(arm, resolver, point):
    found = resolver.resolve([point])
    assert found.success[0] == (found.status[0] in (STATUS.SOLVED, STATUS.REPAIRED))
    assert np.isfinite(found.q).all() == found.success[0]


def test_no_points(resolver):
    found = resolver.resolve(np.empty((0, 2)))
    assert found.q.shape == (0, 3) and len(found) == 0


@pytest.mark.parametrize("inputs", ["xy", "polar"])
def test_another_arm_is_trained_and_resolved(other, inputs, tmp_path):
    seen = []
    options = {"memberships": (4, 4), "points": 300, "epochs": 4, "starts": 1}
    learned = fd.train_bounds(other, inputs=inputs, progress=seen.append, **options)
    assert seen[-1] == 1.0 and seen == sorted(seen)
    learned.save(tmp_path / "other.yaml")
    read = fd.LearnedBounds.load(tmp_path / "other.yaml")
    points = random_workspace_points(other, 400, seed=9)
    np.testing.assert_array_equal(read.predict(points), learned.predict(points))
    found = fd.RedundancyResolver(other, read).resolve(points)
    assert found.success.all() and inside(other, found.q).all()
    assert found.position_error.max() <= 1e-12


def test_training_lowers_the_error(arm):
    options = {"points": 300, "starts": 1, "memberships": (5, 5)}
    points = random_workspace_points(arm, 1000, seed=10)
    exact = np.array(fd.feasible_interval_table(arm, points).widest())
    errors = [
        np.sqrt(np.mean((fd.train_bounds(arm, epochs=n, **options).predict(points) - exact) ** 2))
        for n in (1, 20)
    ]
    assert errors[1] < 0.7 * errors[0]


def test_bounds_that_come_with_the_library(arm):
    """Claimed: rms at most 0.0025 (upper) and 0.0027 rad (lower), none above 0.06."""
    points = random_workspace_points(arm, 5000, seed=11)
    bounds = fd.LearnedBounds.find(arm)
    exact = fd.feasible_interval_table(arm, points).widest()
    for learned, wanted, rms in zip(bounds.predict(points), exact, (0.0027, 0.0025)):
        assert np.sqrt(np.mean((learned - wanted) ** 2)) <= rms
        assert np.abs(learned - wanted).max() <= 0.06


def test_an_arm_without_learned_bounds_has_the_exact_ones(arm, other):
    table = arm.table
    table.joints[1].upper = 1.0
    for changed in (other, fd.DhArm(table)):
        resolver = fd.RedundancyResolver(changed)
        assert resolver.bounds is None
        found = resolver.resolve(random_workspace_points(changed, 100, seed=13))
        assert (found.status == STATUS.REPAIRED).all() and inside(changed, found.q).all()
    with pytest.raises(ValueError, match="hassantabar3r"):
        fd.RedundancyResolver(other, fd.LearnedBounds.find(arm))


def test_workspace_points_cover_the_workspace(arm):
    for edge in (False, True):
        points = workspace_points(arm, 1000, edge=edge)
        assert abs(len(points) - 1000) < 40
        assert fd.feasible_interval_table(arm, points).feasible.all()
        fresh = random_workspace_points(arm, 300, seed=12)
        away = np.linalg.norm(fresh[:, None] - points, axis=2).min(axis=1)
        assert away.max() < (0.11 if edge else 0.25)


def test_polar_inputs_have_their_cut_behind_the_arm(other):
    geometry = fd.Planar3R(other)
    points = geometry.base + np.array([[1.0, 0.0], [0.0, 2.0], [-1.0, -1e-9], [-1.0, 1e-9]])
    r, phi = BoundsInputs(other, "xy", "polar")(points).T
    np.testing.assert_allclose(r, [1, 2, 1, 1])
    np.testing.assert_allclose(np.cos(phi), [1, 0, -1, -1], atol=1e-9)
    ahead = geometry.middle[0] + geometry.offsets[0]
    assert (np.abs(phi - ahead) <= np.pi + 1e-12).all()


@pytest.mark.parametrize(
    ("use", "words"),
    [
        (lambda arm, r: r.resolve([1.0, 2.0]), ["points", "(N, 2)", "(2,)"]),
        (lambda arm, r: r.resolve(np.zeros((3, 3))), ["points", "(3, 3)"]),
        (lambda arm, r: fd.train_bounds(arm, inputs="round"), ["inputs", "round", "polar"]),
        (lambda arm, r: fd.train_bounds(fd.load_arm("planar4")), ["planar4", "three"]),
        (lambda arm, r: fd.RedundancyResolver(fd.load_arm("panda")), ["xy", "leaves 4"]),
        (lambda arm, r: workspace_points(arm, 0), ["count", "0"]),
        (
            lambda arm, r: LearnedBounds(arm, "xy", Anfis((3,)), Anfis((3, 3))),
            ["lower", "2 inputs", "1"],
        ),
    ],
)
def test_refuses(use, words, arm, resolver):
    with pytest.raises(ValueError) as error:
        use(arm, resolver)
    for word in words:
        assert word in str(error.value)


def test_missing_or_bad_files(tmp_path):
    with pytest.raises(FileNotFoundError, match="hassantabar3r"):
        fd.LearnedBounds.load("nothing")
    path = tmp_path / "bad.yaml"
    path.write_text("inputs: polar\n")
    with pytest.raises(ValueError, match=r"bad\.yaml"):
        fd.LearnedBounds.load(path)
