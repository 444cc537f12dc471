"""The arm: equations 1 and 2, its table and its URDF, relative and absolute angles, servo counts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd
from fikm_drake.resources import ConfigureParser
from fikm_drake.solvers.labvolt.geometry import labvolt

ANGLE = st.floats(-4.0, 4.0)


@pytest.fixture(scope="module")
def arm():
    return fd.load_arm("labvolt5250")


def postures(arm, count=200, seed=0):
    """Joint positions (N,4) uniform inside the limits, all round the base."""
    rng = np.random.default_rng(seed)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    return rng.uniform(lower, upper, (count, 4))


def test_limits_are_those_of_equation_5():
    geometry = labvolt()
    np.testing.assert_allclose(np.rad2deg(geometry.lower), [-29.0, -120.0, -78.0], rtol=1e-15)
    np.testing.assert_allclose(np.rad2deg(geometry.upper), [120.0, 118.0, 78.0], rtol=1e-15)
    assert geometry.lengths == (0.3604, 0.2285, 0.1654)
    assert (geometry.offset, geometry.height) == (0.003, 0.384)


def test_stretched_arm_points_along_x(arm):
    tool = arm.forward_kinematics([0.0] * 4)[:3, 3]
    np.testing.assert_allclose(tool, [0.7573, 0.0, 0.384], rtol=0, atol=1e-12)


def test_equations_1_and_2_are_the_tables_kinematics(arm):
    """In the vertical plane that the base turns: radius less offset, height over the shoulder."""
    q = postures(arm)
    tool = arm.forward_kinematics(q)[:, :3, 3]
    plane = fd.labvolt.forward_kinematics(fd.labvolt.to_absolute(q[:, 1:]))
    radius = plane[:, 0] + 0.003
    expected = [radius * np.cos(q[:, 0]), radius * np.sin(q[:, 0]), plane[:, 1] + 0.384]
    np.testing.assert_allclose(tool, np.transpose(expected), rtol=0, atol=1e-12)


def test_urdf_in_a_plant_puts_the_tool_on_solved_targets(arm):
    """Drake's own forward kinematics of models/labvolt5250.urdf, targets in all four quadrants."""
    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    ConfigureParser(parser)
    parser.AddModelsFromUrl("package://fikm_drake/labvolt5250.urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    targets = arm.forward_kinematics(postures(arm))[:, :3, 3]
    solution = fd.labvolt.solve(targets)
    context, tool = plant.CreateDefaultContext(), plant.GetFrameByName("tool")
    assert solution.success.sum() > 100
    assert {tuple(signs) for signs in np.sign(targets[solution.success, :2])} == {
        (x, y) for x in (-1, 1) for y in (-1, 1)
    }
    for target, q in zip(targets[solution.success], solution.joints[solution.success]):
        plant.SetPositions(context, q)
        found = tool.CalcPoseInWorld(context).translation()
        np.testing.assert_allclose(found, target, rtol=0, atol=1e-9)


@given(st.lists(ANGLE, min_size=3, max_size=3))
def test_relative_and_absolute_angles_are_inverse(angles):
    relative = fd.labvolt.to_relative(angles)
    assert relative[0] == angles[0]
    np.testing.assert_allclose(fd.labvolt.to_absolute(relative), angles, rtol=0, atol=1e-12)


def test_angles_convert_in_any_shape():
    angles = np.random.default_rng(0).normal(size=(2, 5, 3))
    again = fd.labvolt.to_absolute(fd.labvolt.to_relative(angles))
    np.testing.assert_allclose(again, angles, rtol=0, atol=1e-12)
    assert fd.labvolt.forward_kinematics(angles).shape == (2, 5, 2)


@given(st.lists(ANGLE, min_size=3, max_size=3))
def test_servo_counts_are_within_half_a_count(angles):
    """.0015, 1/666.66667 and .001699 degrees a count."""
    counts = fd.labvolt.to_servo_counts(angles)
    assert counts.dtype == np.int64
    off = np.rad2deg(np.abs(fd.labvolt.from_servo_counts(counts) - angles))
    assert (off <= 0.5 * np.array([0.0015, 1 / 666.66667, 0.001699]) * (1 + 1e-9)).all()


def test_shoulder_counts_begin_at_105_degrees():
    assert fd.labvolt.to_servo_counts(np.deg2rad([105.0, 0.0, 0.0])).tolist() == [0, 0, 0]
    assert fd.labvolt.to_servo_counts(np.deg2rad([106.5, 3.0, 1.699])).tolist() == [
        1000,
        -2000,
        -1000,
    ]
    with pytest.raises(ValueError, match="finite"):
        fd.labvolt.to_servo_counts([np.nan, 0.0, 0.0])
