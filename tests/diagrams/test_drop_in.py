"""The controller in the place of Drake's own: the same script runs with either."""

import contextlib
import dataclasses
import io
from pathlib import Path

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import DifferentialInverseKinematicsController
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BusValue, DiagramBuilder

import fikm_drake as fd
from fikm_drake.diagrams.drake_differential_ik import drake_differential_ik

SCRIPT = Path(__file__).parents[2] / "notebooks" / "examples" / "in_place_of_drakes.py"
HOME = np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0])
CONFIG = fd.FuzzyIkConfig(task="pose", control_rate=100.0, fused=True)


@pytest.mark.parametrize("ours", [True, False])
def test_the_script_runs_in_both_forms_with_one_line_changed(ours):
    text = SCRIPT.read_text("utf-8")
    assert len(text.splitlines()) <= 40 and text.count("OURS = True") == 1
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(text.replace("OURS = True", f"OURS = {ours}"), str(SCRIPT), "exec"), {})
    assert float(printed.getvalue().split()[-2]) < 60.0  # [mm]; both lag behind


@pytest.mark.parametrize("ours", [True, False])
def test_in_the_place_of_drakes_controller(ours):
    """desired_poses, estimated_state, nominal_posture, commanded_position, set_initial_position."""
    arm = fd.load_arm("iiwa14")
    plant = fd.MakeDhArmPlant(arm)
    if ours:
        ik = fd.MakeFuzzyIkController(plant, config=CONFIG, ports="controller")
    else:
        own = drake_differential_ik(arm, period=0.01)
        ik = DifferentialInverseKinematicsController(own, [])
    builder = DiagramBuilder()
    builder.AddSystem(ik)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    own = ik.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    target = RigidTransform(arm.forward_kinematics(HOME + 0.1))
    bus = BusValue()
    bus.Set("iiwa14::tool", Value(target))
    ik.GetInputPort("desired_poses").FixValue(own, Value(bus))
    ik.GetInputPort("estimated_state").FixValue(own, np.concatenate([HOME, np.zeros(7)]))
    ik.GetInputPort("nominal_posture").FixValue(own, HOME)
    ik.set_initial_position(own, HOME)
    simulator.AdvanceTo(3.0)
    q = ik.GetOutputPort("commanded_position").Eval(own)
    np.testing.assert_allclose(
        arm.forward_kinematics(q)[:3, 3], target.translation(), rtol=0, atol=2e-3
    )


def one(ports="integrator", **options):
    plant = fd.MakeDhArmPlant(fd.load_arm("iiwa14"))
    ik = fd.MakeFuzzyIkController(plant, config=CONFIG, ports=ports, **options)
    simulator = Simulator(ik)
    return ik, simulator, simulator.get_mutable_context()


def test_starts_where_the_robot_is_or_was_put_and_else_warns():
    X = Value(RigidTransform([0.5, 0.1, 0.6]))
    ik, simulator, context = one()
    ik.GetInputPort("X_AE_desired").FixValue(context, X)
    ik.GetInputPort("robot_state").FixValue(context, np.concatenate([HOME, np.zeros(7)]))
    simulator.Initialize()
    np.testing.assert_array_equal(ik.GetOutputPort("joint_positions").Eval(context), HOME)
    ik, simulator, context = one()
    ik.GetInputPort("X_AE_desired").FixValue(context, X)
    ik.SetPositions(context, HOME)
    simulator.Initialize()
    np.testing.assert_array_equal(ik.GetOutputPort("joint_positions").Eval(context), HOME)
    ik, simulator, context = one()
    ik.GetInputPort("X_AE_desired").FixValue(context, X)
    with pytest.warns(UserWarning, match="starts at the plant's default"):
        simulator.Initialize()


def test_a_bus_without_the_tool_is_no_target():
    ik, simulator, context = one("controller")
    bus = BusValue()
    bus.Set("another::tool", Value(RigidTransform()))
    ik.GetInputPort("desired_poses").FixValue(context, Value(bus))
    ik.SetPositions(context, HOME)
    simulator.AdvanceTo(0.2)
    status = ik.GetOutputPort("status").Eval(context)
    assert status == fd.ControllerStatus.INVALID_INPUT
    np.testing.assert_array_equal(ik.GetOutputPort("commanded_position").Eval(context), HOME)


def test_bad_ports_and_tasks_are_named():
    plant = fd.MakeDhArmPlant(fd.load_arm("iiwa14"))
    with pytest.raises(ValueError, match="integrator.*'qp'"):
        fd.MakeFuzzyIkController(plant, config=CONFIG, ports="qp")
    with pytest.raises(ValueError, match="task='pose'"):
        fd.MakeFuzzyIkController(plant, ports="integrator")


@pytest.mark.parametrize("fused", [True, False])
def test_the_nominal_posture_is_approached_in_the_null_space(fused):
    """Another elbow for the same pose: the joints go there and the tool stays; without one they stay."""
    arm = fd.load_arm("iiwa14")
    target = RigidTransform(arm.forward_kinematics(HOME))
    motion = fd.trace_self_motion(arm, HOME, "pose").components[0]
    along = int(np.argmin(np.abs(motion.q - HOME).max(axis=1)))
    nominal = motion.at(motion.arc_length[along] + 0.5)
    ends = []
    for posture in (None, nominal):
        ik = fd.MakeFuzzyIkController(
            fd.MakeDhArmPlant(arm),
            config=dataclasses.replace(CONFIG, fused=fused),
            ports="controller",
        )
        simulator = Simulator(ik)
        context = simulator.get_mutable_context()
        bus = BusValue()
        bus.Set("iiwa14::tool", Value(target))
        ik.GetInputPort("desired_poses").FixValue(context, Value(bus))
        if posture is not None:
            ik.GetInputPort("nominal_posture").FixValue(context, posture)
        ik.set_initial_position(context, HOME)
        simulator.AdvanceTo(6.0)
        q = ik.GetOutputPort("commanded_position").Eval(context)
        np.testing.assert_allclose(arm.forward_kinematics(q), target.GetAsMatrix4(), atol=2e-3)
        ends.append(q)
    np.testing.assert_allclose(ends[0], HOME, atol=1e-6)
    np.testing.assert_allclose(ends[1], nominal, atol=0.05)
    assert np.abs(nominal - HOME).max() > 0.2
