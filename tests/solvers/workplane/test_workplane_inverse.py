"""Exact joint positions for points of a workplane, beside the arms' own forward kinematics."""

import dataclasses

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.solvers.workplane.integer_fuzzy_ik import tojo_inverse

PITCH, ROLL, ELBOW, WRIST = range(4)


@pytest.fixture(scope="module")
def tojo():
    return tojo_inverse()


def test_tool_is_on_every_millimetre_of_the_desk(tojo):
    points = tojo.workplane.grid()
    reached = tojo.reached(tojo(points))
    np.testing.assert_allclose(reached[..., :2], points, atol=1e-9)
    np.testing.assert_allclose(reached[..., 2], 0.0, atol=1e-9)


def test_pitch_depends_on_y_alone_as_the_rows_of_table_1(tojo):
    q = tojo(tojo.workplane.grid())
    np.testing.assert_allclose(np.ptp(q[..., PITCH], axis=0), 0.0, atol=1e-12)
    degrees = np.rad2deg(q[0, [0, 150, 300], PITCH])
    np.testing.assert_allclose(degrees, [59.68, 69.52, 74.66], atol=0.005)


def test_heading_changes_linearly_with_y(tojo):
    points = tojo.workplane.grid()[::40, ::30]
    q = tojo(points)
    heading = q[..., ROLL] - q[..., ELBOW] - q[..., WRIST]
    np.testing.assert_allclose(heading, -0.71 + 0.30 * (points[..., 1] - 150) / 150, atol=1e-12)


def test_other_lengths_desk_and_heading():
    table = fd.load_arm("tojo4dof").table
    table.joints[2].a, table.joints[3].a, table.tool.a = 0.35, 0.3, 0.1
    workplane = fd.Workplane(origin=[0.2, 0.3, -0.2], yaw=-1.2, size=[300, 200])
    inverse = fd.TiltedPlaneInverse(fd.DhArm(table), workplane, heading=(0.1, -0.3))
    points = workplane.grid()[::10, ::10]
    reached = inverse.reached(inverse(points))
    np.testing.assert_allclose(reached[..., :2], points, atol=1e-9)
    np.testing.assert_allclose(reached[..., 2], 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", [fd.WorkplaneInverse, fd.TiltedPlaneInverse])
def test_an_arm_of_a_plant_is_taken_as_its_table_is(tojo, kind):
    """A chain out of a plant has other frames on the same axes: the joints go where the table's go."""
    chain = fd.SerialChain.from_plant(fd.MakeDhArmPlant(fd.load_arm("tojo4dof")), "tool")
    points = tojo.workplane.grid()[::100, ::100]
    start = () if kind is fd.TiltedPlaneInverse else (tojo([200, 150]),)
    inverse = kind(chain, tojo.workplane, *start)
    q = inverse(points)
    np.testing.assert_allclose(tojo.reached(q), inverse.reached(q), atol=1e-9)
    np.testing.assert_allclose(inverse.reached(q)[..., :2], points, atol=2e-3)
    singletons = inverse.singletons((3, 3), "min", least_squares=False)[2]
    assert singletons.shape == (3, 3, 4)


def test_a_point_out_of_reach_is_named(tojo):
    with pytest.raises(ValueError, match=r"does not reach the point \(900, 40\) mm"):
        tojo([[10, 10], [900, 40], [950, 40]])
    far = fd.Workplane(origin=[2.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"\(0, 0\) mm"):
        fd.IntegerFuzzyIk(fd.TiltedPlaneInverse(tojo.chain, far))


def test_another_geometry_is_refused(tojo):
    with pytest.raises(ValueError, match="'panda' does not have the geometry of 'tojo4dof'"):
        fd.TiltedPlaneInverse(fd.load_arm("panda"), tojo.workplane)
    table = fd.load_arm("tojo4dof").table
    table.joints[1].d = 0.01
    with pytest.raises(ValueError, match="geometry"):
        fd.TiltedPlaneInverse(fd.DhArm(table), tojo.workplane)


def test_prismatic_joints_are_refused(tojo):
    table = fd.load_arm("tojo4dof").table
    table.joints[2].type = "prismatic"
    for make in (
        fd.TiltedPlaneInverse,
        lambda arm, workplane: fd.WorkplaneInverse(arm, workplane, np.zeros(4)),
    ):
        with pytest.raises(ValueError, match="joint3 of 'tojo4dof'"):
            make(fd.DhArm(table), tojo.workplane)


@pytest.mark.parametrize(
    ("name", "start"),
    [("puma560", [0.0, 0.5, -2.5, 0.0, 0.5, 0.0]), ("iiwa14", [0, 0.6, 0, -1.4, 0, 1.0, 0])],
)
def test_any_arm_by_solve_batch(name, start):
    workplane = fd.Workplane(origin=[0.35, 0.2, 0.15], yaw=-np.pi / 2)
    inverse = fd.WorkplaneInverse(fd.load_arm(name), workplane, start)
    points = workplane.grid()[::50, ::50]
    q = inverse(points)
    assert q.shape == (*points.shape[:2], len(start))
    np.testing.assert_allclose(inverse.reached(q)[..., :2], points, atol=2e-3)
    assert np.abs(np.diff(q, axis=0)).max() < 0.5  # neighbours get neighbouring postures
    with pytest.raises(ValueError, match=r"\(5000, 0\) mm"):
        inverse([[5000, 0]])


def test_desks_are_copied_and_checked(tojo):
    workplane = tojo.workplane
    workplane.size[0] = 999
    assert tojo.workplane.size == [400, 300]
    with pytest.raises(ValueError, match="size"):
        fd.WorkplaneInverse(tojo.chain, dataclasses.replace(workplane, size=[0, 1]), np.zeros(4))


@pytest.mark.parametrize("points", [[], [1.0], [[1.0, 2.0, 3.0]], None])
def test_points_of_another_shape_are_named(tojo, points):
    with pytest.raises(ValueError, match=r"points must be \(…, 2\), got \("):
        tojo(points)


@pytest.mark.parametrize("start", [[0.0], [np.nan] * 4, None, "home"])
def test_bad_initial_position_is_named(tojo, start):
    with pytest.raises(ValueError, match="initial_position must be 4 finite numbers"):
        fd.WorkplaneInverse(tojo.chain, tojo.workplane, start)
