"""Closed-form postures of planar arms with three joints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.planar_3r import Planar3R, triangle_angle

LENGTH = st.floats(0.1, 3.0)
ANGLE = st.floats(-3.0, 3.0)


def planar(lengths=(2.0, 1.5, 1.0), thetas=(0.0, 0.0, 0.0), base=0.0, convention="craig", d=0.0):
    """An arm without limits."""
    a, b, c = lengths
    if convention == "standard":
        rows = [DhJoint(a=length, theta=theta, d=d) for length, theta in zip(lengths, thetas)]
        return DhArm(DhTable("planar", "standard", rows, DhTransform(a=base)))
    rows = [DhJoint(a=x, theta=theta, d=d) for x, theta in zip((base, a, b), thetas)]
    return DhArm(DhTable("planar", "craig", rows, DhTransform(a=c)))


@given(st.tuples(LENGTH, LENGTH, LENGTH), st.tuples(*[ANGLE] * 3), st.tuples(*[ANGLE] * 3), ANGLE)
def test_postures_reach_the_point_and_one_is_the_arms_own(lengths, thetas, q, base):
    arm = planar(lengths, thetas, base, d=0.1)
    point = arm.forward_kinematics(q)[:2, 3]
    postures = Planar3R(arm).postures(point, q[0])
    assert postures.shape == (2, 3)
    reached = arm.forward_kinematics(postures)[:, :2, 3]
    # Flat triangles: the root of a rounding error.
    np.testing.assert_allclose(reached, [point, point], rtol=0, atol=1e-12)
    turns = (postures - q) / (2 * np.pi)
    assert np.abs(turns - np.round(turns)).max(axis=1).min() < 1e-5


def test_standard_convention_and_negative_lengths():
    for arm in (planar(convention="standard"), planar((2.0, -1.5, 1.0))):
        q = np.array([0.3, 0.8, -0.4])
        postures = Planar3R(arm).postures(arm.forward_kinematics(q)[:2, 3], 0.3)
        assert np.abs(postures - q).max(axis=1).min() < 1e-12


def test_postures_are_vectorised_and_out_of_reach_is_nan():
    geometry = Planar3R(load_arm("hassantabar3r"))
    points = np.array([[1.0, 2.0], [9.0, 0.0]])
    postures = geometry.postures(points[:, None], np.linspace(0.0, 1.0, 5))
    assert postures.shape == (2, 5, 2, 3)
    assert np.isnan(postures[1, ..., 1:]).all()
    assert not geometry.is_inside(postures[1]).any()
    np.testing.assert_array_equal(postures[0, 3, 1], geometry.postures(points[0], 0.75)[1])


def test_postures_are_within_limits_past_half_a_turn():
    rows = [DhJoint(), DhJoint(a=1.0, lower=4.0, upper=6.0), DhJoint(a=1.0, lower=-9.0, upper=-7.0)]
    arm = DhArm(DhTable("turned", "craig", rows, DhTransform(a=1.0)))
    q = np.array([0.5, 5.0, -8.0])
    geometry = Planar3R(arm)
    postures = geometry.postures(arm.forward_kinematics(q)[:2, 3], 0.5)
    assert np.abs(postures - q).max(axis=1).min() < 1e-12
    assert geometry.is_inside(postures).any()


def test_self_motion_is_the_null_vector():
    arm = load_arm("hassantabar3r")
    q = np.random.default_rng(1).uniform(-3, 3, (200, 3))
    motion = Planar3R(arm).self_motion(q)
    assert (motion[:, 0] >= 0).all()
    moved = np.einsum("nij,nj->ni", arm.jacobian(q)[:, 3:5], motion)
    np.testing.assert_allclose(moved, 0.0, atol=1e-14)


def test_triangle_angles_add_up_to_half_a_turn():
    a, b, c = np.random.default_rng(2).uniform(1.0, 1.9, (3, 100))
    total = triangle_angle(a, b, c) + triangle_angle(b, c, a) + triangle_angle(c, a, b)
    np.testing.assert_allclose(total, np.pi, rtol=1e-14)
    assert np.isnan(triangle_angle(1.0, 1.0, 2.1)) and np.isnan(triangle_angle(1.0, 3.0, 1.0))
    assert triangle_angle(1.0, 0.1, 1.1) == np.pi  # 1.0 + 0.1 is a little over 1.1


@pytest.mark.parametrize(
    ("arm", "words"),
    [
        (load_arm("planar2"), "three revolute joints"),
        (load_arm("puma560"), "three revolute joints"),
        (planar((1.0, 0.0, 1.0)), "without length"),
        (
            DhArm(DhTable("tilted", "craig", [DhJoint(), DhJoint(alpha=0.1, a=1), DhJoint(a=1)])),
            "planar",
        ),
        (
            DhArm(
                DhTable("slide", "craig", [DhJoint(), DhJoint(a=1, type="prismatic"), DhJoint(a=1)])
            ),
            "prismatic",
        ),
    ],
)
def test_other_arms_are_told_apart(arm, words):
    with pytest.raises(ValueError, match=words):
        Planar3R(arm)
