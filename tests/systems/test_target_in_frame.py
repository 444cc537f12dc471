"""Targets in frames that move."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw

import fikm_drake as fd

X_WF = RigidTransform(RollPitchYaw(0.3, -0.4, 1.0), [1.0, 2.0, 0.5])
X_FE = RigidTransform(RollPitchYaw(1.0, 0.2, -0.3), [0.1, -0.2, 0.3])


def test_a_pose_and_a_position_come_into_the_world():
    block = fd.TargetInFrame()
    context = block.CreateDefaultContext()
    block.GetInputPort("desired_pose").FixValue(context, Value(X_FE))
    block.GetInputPort("reference_pose").FixValue(context, Value(X_WF))
    assert block.get_output_port().Eval(context).IsNearlyEqualTo(X_WF @ X_FE, 1e-14)
    block = fd.TargetInFrame("position")
    context = block.CreateDefaultContext()
    block.GetInputPort("desired_position").FixValue(context, X_FE.translation())
    block.GetInputPort("reference_pose").FixValue(context, Value(X_WF))
    point = block.get_output_port().Eval(context)
    np.testing.assert_allclose(point, X_WF @ X_FE.translation(), atol=1e-14)


def test_the_frame_may_be_a_plants():
    arm = fd.load_arm("panda")
    plant = fd.MakeDhArmPlant(arm)
    q = np.random.default_rng(0).uniform(-1, 1, 7)
    block = fd.TargetInFrame(plant=plant, frame="link5")
    context = block.CreateDefaultContext()
    block.GetInputPort("desired_pose").FixValue(context, Value(X_FE))
    block.GetInputPort("plant_state").FixValue(context, np.concatenate([q, np.zeros(7)]))
    expected = arm.link_poses(q)[4] @ X_FE.GetAsMatrix4()
    np.testing.assert_allclose(
        block.get_output_port().Eval(context).GetAsMatrix4(), expected, rtol=0, atol=1e-12
    )
    block.GetInputPort("plant_state").FixValue(context, np.full(14, np.nan))
    assert np.isnan(block.get_output_port().Eval(context).translation()).all()


def test_bad_arguments_are_named():
    plant = fd.MakeDhArmPlant(fd.load_arm("planar2"))
    with pytest.raises(ValueError, match="'x'"):
        fd.TargetInFrame("x")
    with pytest.raises(ValueError, match="a plant and a frame"):
        fd.TargetInFrame(plant=plant)
    with pytest.raises(ValueError, match="link9"):
        fd.TargetInFrame(plant=plant, frame="link9")
