"""Feasible intervals of planar 3R arms: against a scan, against postures, on edges."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fikm_drake.experiments.reproduce.anfis.scan import scan_intervals
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.self_motion.feasible_intervals import (
    feasible_interval_table,
    feasible_intervals,
)
from fikm_drake.solvers.self_motion.interval_table import END_NAMES


def planar(lengths, limits):
    """A planar 3R arm; a limit of None is none."""
    rows = [
        DhJoint(a=a, lower=low, upper=high) for a, (low, high) in zip((0.0, *lengths[:2]), limits)
    ]
    return DhArm(DhTable("planar", "craig", rows, DhTransform(a=lengths[2])))


@st.composite
def arms(draw):
    lengths = draw(st.tuples(*[st.floats(0.3, 2.0)] * 3))
    limits = []
    for _ in range(3):
        low = draw(st.floats(-3.0, 2.5))
        limits.append((low, draw(st.floats(low + 0.3, 3.1))))
    return planar(lengths, limits)


@settings(max_examples=60, deadline=None)
@given(arms(), st.integers(0, 2**32 - 1))
def test_intervals_hold_exactly_what_is_feasible(arm, seed):
    """Random arms: the posture that made a point is inside, and ends separate feasible from not."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(arm.lower, arm.upper, (50, 3))
    points = arm.forward_kinematics(q)[:, :2, 3]
    table = feasible_interval_table(arm, points)
    assert table.feasible.all()
    geometry = Planar3R(arm)
    for i, point in enumerate(points):
        intervals = table[i]
        assert any(part.lower - 1e-9 <= q[i, 0] <= part.upper + 1e-9 for part in intervals)
        feasible = np.array([rng.uniform(part.lower, part.upper, 20) for part in intervals])
        assert geometry.is_inside(geometry.postures(point, feasible), 1e-9).any(axis=-1).all()
        gaps = [arm.lower[0], *np.ravel([(p.lower, p.upper) for p in intervals]), arm.upper[0]]
        for low, high in zip(gaps[::2], gaps[1::2]):
            between = low + (high - low) * rng.uniform(1e-3, 1 - 1e-3, 20)
            inside = geometry.is_inside(geometry.postures(point, between), -1e-9).any(axis=-1)
            assert high - low < 1e-9 or not inside.any()


def test_the_workspace_of_the_thesis_against_scan_and_bisection():
    """The bounds of Hassantabar 2021, figures 3.6 and 3.13, over its whole workspace."""
    arm = load_arm("hassantabar3r")
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, (6000, 3))
    points = arm.forward_kinematics(q)[:, :2, 3]
    table = feasible_interval_table(arm, points)
    assert (table.count == 1).all()  # one component everywhere for these limits
    for start in range(0, 6000, 1000):
        part = slice(start, start + 1000)
        rows, lower, upper = scan_intervals(arm, points[part], q[part, 0])
        np.testing.assert_array_equal(rows, np.arange(1000))
        np.testing.assert_allclose(table.lower[part, 0], lower, rtol=0, atol=1e-12)
        np.testing.assert_allclose(table.upper[part, 0], upper, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_several_components_and_wide_limits_against_scan(seed):
    rng = np.random.default_rng(seed)
    limits = np.sort(rng.uniform(-3.1, 3.1, (3, 2)), axis=1)
    limits[0] = (-5.0, 4.5) if seed % 2 else (-3.0, 3.0)
    limits[2] = (-np.pi, np.pi) if seed % 3 == 0 else limits[2]
    arm = planar(rng.uniform(0.3, 2.0, 3), limits.tolist())
    points = rng.uniform(-3, 3, (60, 2))
    rows, lower, upper = scan_intervals(arm, points, cells=5000)
    table = feasible_interval_table(arm, points)
    found = ~np.isnan(table.lower)
    np.testing.assert_array_equal(np.bincount(rows, minlength=60), table.count)
    np.testing.assert_allclose(table.lower[found], lower, rtol=0, atol=1e-11)
    np.testing.assert_allclose(table.upper[found], upper, rtol=0, atol=1e-11)


def test_there_are_points_with_several_intervals():
    arm = planar((1.0, 1.0, 0.5), [(-3.0, 3.0), (-2.0, 2.0), (-1.0, 1.0)])
    (first, second) = feasible_intervals(arm, [1.2, 0.0])
    assert first.upper < 0.0 < second.lower
    assert first.lower == pytest.approx(-second.upper, abs=1e-14)
    assert first.middle == pytest.approx(-second.middle, abs=1e-14)


def test_ends_name_the_constraint():
    arm = load_arm("hassantabar3r")
    geometry = Planar3R(arm)
    rng = np.random.default_rng(3)
    points = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (500, 3)))[:, :2, 3]
    table = feasible_interval_table(arm, points)
    seen = set()
    for bound, codes in ((table.lower, table.lower_end), (table.upper, table.upper_end)):
        postures = geometry.postures(points, bound[:, 0])[:, 0]
        for q, code in zip(postures, codes[:, 0]):
            _, joint, side = END_NAMES[code].split()
            limit = (arm.lower if side == "lower" else arm.upper)[int(joint) - 1]
            assert q[int(joint) - 1] == pytest.approx(limit, abs=1e-7)
            seen.add(END_NAMES[code])
    assert len(seen) == 6


def test_a_turning_point_is_links_2_and_3_in_line():
    arm = planar((2.0, 1.5, 1.0), [(None, None), (-3.0, 3.0), (-2.0, 2.0)])
    (interval,) = feasible_intervals(arm, [4.0, 0.0])
    assert (interval.lower_end, interval.upper_end) == ("turning point", "turning point")
    stretched = Planar3R(arm).postures([4.0, 0.0], interval.upper)
    np.testing.assert_allclose(stretched[:, 2], 0.0, atol=1e-6)


def test_without_limits_of_joint_1_an_interval_may_pass_half_a_turn():
    free = planar((2.0, 1.5, 1.0), [(None, None), (-3.0, 3.0), (-2.0, 2.0)])
    wide = planar((2.0, 1.5, 1.0), [(0.0, 6.0), (-3.0, 3.0), (-2.0, 2.0)])
    (ours,), (same,) = (feasible_intervals(arm, [-4.0, 0.1]) for arm in (free, wide))
    assert ours.upper > np.pi > ours.lower
    assert (ours.lower, ours.upper) == pytest.approx((same.lower, same.upper), abs=1e-14)
    (turn,) = feasible_intervals(planar((0.1, 1.5, 1.0), [(None, None)] * 3), [2.0, 0.0])
    assert (turn.lower, turn.upper) == (-np.pi, np.pi)
    assert turn.lower_end == turn.upper_end == "full turn"
    (one_sided,) = feasible_intervals(
        planar((0.1, 1.5, 1.0), [(1.0, None), (None, None), (None, None)]), [2.0, 0.0]
    )
    assert one_sided.lower_end == "joint 1 lower" and one_sided.upper_end == "full turn"
    assert one_sided.upper - one_sided.lower == pytest.approx(2 * np.pi)


@pytest.mark.parametrize("corner", range(8))
def test_corners_of_the_limits_are_on_the_edge_and_feasible(corner):
    arm = load_arm("hassantabar3r")
    q = np.where([corner & 1, corner & 2, corner & 4], arm.upper, arm.lower)
    intervals = feasible_intervals(arm, arm.forward_kinematics(q)[:2, 3])
    assert any(part.lower - 1e-9 <= q[0] <= part.upper + 1e-9 for part in intervals)


def test_point_on_the_axis_of_joint_1():
    arm = planar((1.0, 1.0, 1.0), [(-1.0, 1.0), (-3.0, 3.0), (-3.0, 3.0)])
    (interval,) = feasible_intervals(arm, [0.0, 0.0])
    assert (interval.lower, interval.upper) == (-1.0, 1.0)
    assert feasible_intervals(load_arm("hassantabar3r"), [0.0, 0.0]) == []


@pytest.mark.parametrize("point", [[9.0, 0.0], [-2.0, 1.0], [0.3, 0.1], [1.0, -1.0]])
def test_infeasible_points_have_no_interval(point):
    assert feasible_intervals(load_arm("hassantabar3r"), point) == []


def test_table_keeps_the_rows_of_infeasible_and_invalid_points():
    arm = load_arm("hassantabar3r")
    points = [[9.0, 0.0], [1.0, 2.0], [np.nan, 0.0], [np.inf, 1.0], [0.0, 3.0]]
    table = feasible_interval_table(arm, points)
    np.testing.assert_array_equal(table.feasible, [False, True, False, False, True])
    assert len(table) == 5 and table[0] == [] and table[1] == feasible_intervals(arm, points[1])
    lower, upper = table.widest()
    np.testing.assert_array_equal(np.isnan(lower), ~table.feasible)
    assert lower[4] == table.lower[4, 0] and upper[4] == table.upper[4, 0]
    assert table.lower_end[0, 0] == -1


def test_widest_of_several_and_of_none():
    arm = planar((1.0, 1.0, 0.5), [(-3.0, 3.0), (-2.0, 1.0), (-1.0, 1.0)])
    table = feasible_interval_table(arm, [[1.2, 0.0]])
    lower, upper = table.widest()
    assert upper[0] - lower[0] == max(part.upper - part.lower for part in table[0])
    assert np.isnan(feasible_interval_table(arm, [[9.0, 0.0]]).widest()).all()
    assert len(feasible_interval_table(arm, np.zeros((0, 2)))) == 0


def test_many_points_are_the_same_as_each_alone():
    arm = planar((1.0, 1.0, 0.5), [(-3.0, 3.0), (-2.0, 2.0), (-1.0, 1.0)])
    points = np.random.default_rng(4).uniform(-2.5, 2.5, (5000, 2))  # more than a chunk
    table = feasible_interval_table(arm, points)
    for i in (*range(20), *range(4990, 5000)):
        assert table[i] == feasible_intervals(arm, points[i])


@pytest.mark.parametrize("point", [[1.0], [1.0, 2.0, 0.0], 1.0, [np.nan, 0.0], [[1.0, 2.0]]])
def test_bad_points_are_named(point):
    with pytest.raises(ValueError, match="point must be two finite numbers"):
        feasible_intervals(load_arm("hassantabar3r"), point)


def test_bad_arm_and_table():
    with pytest.raises(ValueError, match="iiwa14"):
        feasible_intervals(load_arm("iiwa14"), [1.0, 2.0])
    with pytest.raises(ValueError, match=r"\(N, 2\)"):
        feasible_interval_table(load_arm("hassantabar3r"), [[1.0, 2.0, 0.0]])
