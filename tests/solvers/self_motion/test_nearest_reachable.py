"""The nearest reachable point of planar 3R arms of any lengths and limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.solvers.labvolt.geometry import labvolt

LIMITS = st.one_of(
    st.just((None, None)),
    st.tuples(st.floats(-4.0, 0.5), st.floats(0.6, 5.0)),
    st.tuples(st.floats(-3.0, 1.0), st.none()),
)


def planar(lengths, limits, thetas=(0.0, 0.0, 0.0)):
    rows = [
        DhJoint(a=a, theta=theta, lower=low, upper=high)
        for a, theta, (low, high) in zip((0.1, *lengths[:2]), thetas, limits)
    ]
    return DhArm(DhTable("planar", "craig", rows, DhTransform(a=lengths[2])))


@settings(max_examples=60)
@given(
    st.tuples(*[st.floats(0.2, 2.0)] * 3),
    st.tuples(*[LIMITS] * 3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.integers(0, 1000),
)
def test_postures_are_inside_and_no_other_posture_is_nearer(lengths, limits, thetas, seed):
    arm = planar(lengths, limits, thetas)
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.2, 1.2, (12, 2)) * sum(lengths)
    found = fd.nearest_reachable(arm, points)
    tool = arm.forward_kinematics(found.q)[:, :2, 3]
    assert ((found.q >= arm.lower) & (found.q <= arm.upper)).all()
    np.testing.assert_allclose(tool, found.point, rtol=0, atol=1e-7)
    np.testing.assert_allclose(np.hypot(*(tool - points).T), found.distance, rtol=0, atol=1e-7)
    low = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    high = np.where(np.isfinite(arm.upper), arm.upper, low + 2.0 * np.pi)
    sampled = arm.forward_kinematics(rng.uniform(low, high, (2000, 3)))[:, :2, 3]
    least = np.linalg.norm(points[:, None] - sampled, axis=2).min(axis=1)
    assert (found.distance <= least + 1e-12).all()


def test_hole_in_the_middle_and_out_of_reach():
    arm = planar((2.0, 0.5, 0.3), [(None, None)] * 3)
    found = fd.nearest_reachable(
        arm, [[0.1, 0.0], [0.1, 1.0], [4.1, 0.0], [1.6, 0.0], [np.nan, 0.0]]
    )
    np.testing.assert_allclose(found.distance[:4], [1.2, 0.2, 1.2, 0.0], rtol=0, atol=1e-12)
    assert found.reachable.tolist() == [False, False, False, True, False]
    assert np.isnan(found.q[4]).all() and np.isnan(found.distance[4])


def test_the_labvolt_arm_is_one_of_them():
    geometry = labvolt()
    limits = list(zip(geometry.lower, geometry.upper))
    rows = [
        DhJoint(a=a, lower=low, upper=high)
        for a, (low, high) in zip((0.0, *geometry.lengths[:2]), limits)
    ]
    arm = DhArm(DhTable("labvolt3r", "craig", rows, DhTransform(a=geometry.lengths[2])))
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (400, 2))
    found, solution = fd.nearest_reachable(arm, points), fd.labvolt.solve(points)
    assert found.reachable.tolist() == solution.success.tolist()
    np.testing.assert_allclose(found.distance, solution.distance, rtol=0, atol=1e-12)


def test_other_arms_and_shapes_are_refused():
    with pytest.raises(ValueError, match="three revolute"):
        fd.nearest_reachable(fd.load_arm("planar2"), [[1.0, 0.0]])
    with pytest.raises(ValueError, match=r"\(N, 2\)"):
        fd.nearest_reachable(fd.load_arm("hassantabar3r"), [1.0, 0.0])
