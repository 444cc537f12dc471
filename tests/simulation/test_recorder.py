"""Any Diagram's ports into a log."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantValueSource,
    ConstantVectorSource,
    Integrator,
    LogVectorOutput,
    ZeroOrderHold,
)

import fikm_drake as fd


def torque_driven():
    """A builder with an arm under our controller, and the plant."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 1e-3)
    fd.AddDhArm(plant, fd.load_arm("planar4"))
    plant.Finalize()
    controller = fd.AddFuzzyIkTorqueController(builder, plant)
    target = builder.AddNamedSystem("target", ConstantVectorSource([0.4, 0.2, 0.0]))
    builder.Connect(target.get_output_port(), controller.GetInputPort("desired_position"))
    return builder, plant


def test_every_vector_port_of_a_builder_equals_drakes_own_log():
    builder, plant = torque_driven()
    sink = LogVectorOutput(plant.get_state_output_port(), builder, 0.02)
    recorder = fd.record(builder, period=0.02)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.3)
    log, theirs = recorder.log(), sink.FindLog(simulator.get_context())
    np.testing.assert_allclose(log.time, theirs.sample_times(), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(log["plant/state"], theirs.data().T)
    own = "fuzzy_ik_torque_controller/"
    assert {"target/y0", f"{own}status", f"{own}actuation", f"{own}task_error"} <= {*log.names}
    names = log.names_of_values(f"{own}status")
    assert set(names) <= {status.name for status in fd.ControllerStatus}
    assert np.abs(log[f"{own}actuation"]).max() > 1.0


def test_a_simulator_of_a_built_diagram_in_one_call_keeps_its_monitor():
    builder, plant = torque_driven()
    simulator = Simulator(builder.Build())
    seen = []
    simulator.set_monitor(lambda root: seen.append(root.get_time()))
    recorder = fd.record(simulator, {"state": plant.get_state_output_port()})
    simulator.AdvanceTo(0.05)
    log = recorder.log()
    assert log.names == ("state",) and len(seen) >= len(log) > 50
    context = plant.GetMyContextFromRoot(simulator.get_context())
    np.testing.assert_array_equal(log["state"][-1], plant.get_state_output_port().Eval(context))


def test_a_built_diagram_is_attached_to_its_simulator_only():
    builder, _ = torque_driven()
    diagram = builder.Build()
    recorder = fd.record(diagram, period=0.01)
    with pytest.raises(ValueError, match="nothing was recorded"):
        recorder.log()
    with pytest.raises(ValueError, match="attach"):
        recorder.attach(Simulator(Integrator(1)))
    simulator = Simulator(diagram)
    recorder.attach(simulator)
    simulator.AdvanceTo(0.1)
    log = recorder.log()
    assert len(log) == 11
    np.testing.assert_allclose(log.time, 0.01 * np.arange(11), atol=1e-9)


def test_a_continuous_system_is_recorded_at_every_step():
    builder = DiagramBuilder()
    one = builder.AddSystem(ConstantVectorSource([1.0]))
    integrator = builder.AddNamedSystem("x", Integrator(1))
    builder.Connect(one.get_output_port(), integrator.get_input_port())
    recorder = fd.record(builder, {"x": integrator.get_output_port()})
    Simulator(builder.Build()).AdvanceTo(2.0)
    log = recorder.log()
    np.testing.assert_allclose(log["x"][:, 0], log.time, atol=1e-9)
    assert log.time[0] == 0.0 and len(log) > 3


def test_poses_become_quaternion_and_position_and_other_types_are_refused():
    builder = DiagramBuilder()
    pose = builder.AddNamedSystem("pose", ConstantValueSource(Value(RigidTransform([1, 2, 3]))))
    text = builder.AddNamedSystem("text", ConstantValueSource(Value("hello")))
    recorder = fd.record(builder, [pose.get_output_port()], period=0.1)
    with pytest.raises(ValueError, match="text"):
        fd.record(builder, [text.get_output_port()])
    Simulator(builder.Build()).AdvanceTo(0.2)
    log = recorder.log()
    np.testing.assert_array_equal(log["pose/y0"], [[1, 0, 0, 0, 1, 2, 3]] * 3)
    assert log.info.columns["pose/y0"][-1] == "pose/y0_z_m"


def test_ports_that_cannot_be_read_are_left_out_and_named():
    builder = DiagramBuilder()
    builder.AddNamedSystem("alone", ZeroOrderHold(0.1, 2))
    plant = builder.AddNamedSystem("plant", MultibodyPlant(0.0))
    fd.AddDhArm(plant, fd.load_arm("planar2"))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    recorder = fd.record(simulator, period=0.1)
    simulator.Initialize()
    recorder.attach(simulator)
    simulator.get_mutable_context()
    log_names = recorder.log().names
    assert "plant/state" in log_names
    assert not set(recorder.log().info.skipped) & set(log_names)


def test_two_recorders_and_a_file_that_grows(tmp_path, monkeypatch):
    monkeypatch.setattr("fikm_drake.simulation.log_file.BETWEEN_FLUSHES", 0.0)
    builder, plant = torque_driven()
    first = fd.record(builder, period=0.01, file=tmp_path / "run.npz")
    fd.record(builder, [plant.get_state_output_port()], period=0.02)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.1)
    half = fd.RunLog.load(tmp_path / "run.npz")
    assert len(half) >= 10 and half.info.ended
    first.save(tmp_path / "run.npz")
    whole = fd.RunLog.load(tmp_path / "run.npz")
    assert whole.names == half.names and not whole.info.ended
    with pytest.raises(ValueError, match="scenario"):
        whole.metrics()


def test_what_is_no_diagram_is_named():
    with pytest.raises(ValueError, match="DiagramBuilder"):
        fd.record("plant")
    with pytest.raises(ValueError, match="no port"):
        fd.record(DiagramBuilder())


@pytest.mark.parametrize("driven", [False, True])
def test_drakes_default_visualization_beside_our_controller(driven):
    """The wiring that comes to mind first: one plant for scene, visualizer and controller."""
    from pydrake.visualization import AddDefaultVisualization

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 1e-3)
    fd.AddDhArm(plant, fd.load_arm("planar4"))
    plant.Finalize()
    add = fd.AddFuzzyIkTorqueController if driven else fd.AddFuzzyIkController
    controller = add(builder, plant)
    target = builder.AddSystem(ConstantVectorSource([0.4, 0.2, 0.0]))
    builder.Connect(target.get_output_port(), controller.GetInputPort("desired_position"))
    AddDefaultVisualization(builder)
    recorder = fd.record(builder, [controller.GetOutputPort("commanded_position")], period=0.02)
    simulator = Simulator(builder.Build())
    own = controller.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    controller.SetPositions(own, np.zeros(4))
    simulator.AdvanceTo(0.1)
    (name,) = recorder.log().names
    assert np.abs(np.diff(recorder.log()[name], axis=0)).max() > 0.0
