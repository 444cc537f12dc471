"""What the controller does with an arm, as a Diagram and as one block."""

import numpy as np
import pytest
from pydrake.geometry import Box
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    LogVectorOutput,
    Multiplexer,
    TrajectorySource,
)
from pydrake.trajectories import PiecewisePolynomial

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

PERIOD = 0.02
Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
TARGET = np.array([0.5, -0.45, 0.3])


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def test_a_fixed_target_is_reached(plant, run, fused):
    series = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, np.tile(TARGET, (300, 1)))
    assert lengths(series["task_error"])[-1] < 1e-6
    assert series["status"][-1] == Status.CONVERGED
    arm = fd.load_arm("arm7")
    np.testing.assert_allclose(arm.forward_kinematics(series["after"])[:3, 3], TARGET, atol=1e-6)


def test_task_error_is_that_of_the_commanded_position(plant, run, fused):
    series = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, np.tile(TARGET, (50, 1)))
    tool = fd.load_arm("arm7").forward_kinematics(series["commanded_position"])[:, :3, 3]
    np.testing.assert_allclose(series["task_error"], TARGET - tool, atol=1e-13)


def test_commanded_velocity_is_the_derivative_of_the_command(plant, run, fused):
    config = fd.FuzzyIkConfig(fused=fused, control_rate=200.0)
    series = run(plant, config, Q0, np.tile(TARGET, (50, 1)))
    q, v = series["commanded_position"], series["commanded_velocity"]
    np.testing.assert_allclose(v[1:], np.diff(q, axis=0) * 200.0, atol=1e-10)
    np.testing.assert_allclose(np.diff(q, axis=0), series["joint_step"][:-1], atol=1e-14)
    assert not v[0].any()


def test_an_unconnected_input_is_an_error_and_not_a_guess(plant, fused):
    controller = fd.MakeFuzzyIkController(plant, config=fd.FuzzyIkConfig(fused=fused))
    with pytest.raises(RuntimeError):
        controller.GetOutputPort("status").Eval(controller.CreateDefaultContext())


def test_every_status_is_reached(plant_with, scenario_inputs, run, checker_with, fused):
    seen = {}
    for name in ("large_step_2", "table6_2s"):
        arm, config, start, desired = scenario_inputs(name, fused=fused)
        desired[-3:] = np.nan
        for status in run(plant_with(arm), config, start, desired)["status"].ravel():
            seen.setdefault(Status(int(status)), name)
    for restart_search in (False, True):
        config = fd.FuzzyIkConfig(fused=fused, restart_search=restart_search)
        series = run(plant_with("arm7"), config, Q0, np.tile([2.0, 0.0, 0.0], (200, 1)))
        for status in series["status"].ravel():
            seen.setdefault(Status(int(status)), f"out of reach, restart search {restart_search}")
    start = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
    series = run(plant_with("panda"), fd.FuzzyIkConfig(fused=fused), start, [[-0.6, 0.0, 0.1]] * 9)
    seen.setdefault(Status(int(series["status"][-1, 0])), "panda")
    start, config = np.array(start), fd.FuzzyIkConfig(fused=fused)
    far = run(plant_with("panda"), config, start, [[0.4, 0.0, 0.4]] * 2, lambda k, q: q + 0.9)
    seen.setdefault(Status(int(far["status"][-1, 0])), "far from its command")
    wall = checker_with((Box(0.05, 2.0, 2.0), [0.75, 0.0, 0.5]), arm="panda")
    before = run(plant_with("panda"), config, start, [[1.0, 0.0, 0.5]] * 100, checker=wall)
    for status in before["status"].ravel():
        seen.setdefault(Status(int(status)), "before a wall")
    assert set(seen) == set(Status)


@pytest.mark.parametrize(
    ("name", "target"), [("planar4", (0.0, 2.0)), ("planar2", (3.0, 3.0)), ("planar4", (1e6, 0.0))]
)
def test_an_unreachable_target_is_approached_in_bounded_steps(name, target, plant_with, run, fused):
    """|dθ_j| c_j ≤ Σ|d_i|, and |d| ≤ 2.6 error_limit: no singularity makes a step larger."""
    arm, config = fd.load_arm(name), fd.FuzzyIkConfig(fused=fused, task="xy")
    desired = np.tile(target, (450, 1))
    series = run(plant_with(name), config, np.full(arm.num_joints, 0.1), desired)
    assert all(np.isfinite(values).all() for values in series.values())
    columns = np.abs(arm.jacobian(series["commanded_position"])[:, 3:5]).sum(axis=1)
    bound = np.sqrt(2) * 2.6 * config.error_limit
    assert (np.abs(series["joint_step"]) * columns <= bound * (1 + 1e-9)).all()
    away = lengths(series["task_error"])
    nearest = np.hypot(*target) - 1.5
    assert away[-1] < away[0] and away[-1] < nearest + 0.05
    assert Status.CONVERGED not in series["status"]


def test_two_controllers_in_one_diagram(plant, plant_with, run, fused):
    """Each does what it does alone, on one plant and on two."""
    config = fd.FuzzyIkConfig(fused=fused)
    jobs = [(plant, Q0, TARGET), (plant, -Q0, TARGET - 0.1), (plant_with("iiwa14"), Q0, TARGET)]
    builder = DiagramBuilder()
    controllers, sinks = [], []
    for i, (own_plant, _, target) in enumerate(jobs):
        controller = fd.AddFuzzyIkController(builder, own_plant, config=config, name=f"arm_{i}")
        source = builder.AddSystem(ConstantVectorSource(target))
        builder.Connect(source.get_output_port(), controller.get_input_port(0))
        port = controller.GetOutputPort("commanded_position")
        sinks.append(LogVectorOutput(port, builder, PERIOD))
        controllers.append(controller)
    diagram = builder.Build()
    assert diagram.HasSubsystemNamed("arm_1")
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    for controller, (_, start, _) in zip(controllers, jobs):
        controller.SetPositions(controller.GetMyMutableContextFromRoot(root), start)
    simulator.AdvanceTo(99.5 * PERIOD)
    for sink, (own_plant, start, target) in zip(sinks, jobs):
        alone = run(own_plant, config, start, np.tile(target, (100, 1)))["commanded_position"]
        np.testing.assert_array_equal(sink.FindLog(root).data().T, alone)


@pytest.mark.parametrize("method", ["indirect", "direct"])
def test_a_plant_with_two_arms(plant_with, run, fused, method):
    """Each arm by its own controller, which commands the joints of that arm and no others."""
    plant = plant_with("arm7", "arm7")
    with pytest.raises(ValueError) as error:
        fd.MakeFuzzyIkController(
            plant, config=fd.FuzzyIkConfig(fused=fused, law=fd.FuzzyMapping(method))
        )
    assert "arm7::tool" in str(error.value) and "arm7_1::tool" in str(error.value)
    desired = np.tile(TARGET, (150, 1))
    alone = run(plant_with("arm7"), fd.FuzzyIkConfig(fused=fused), Q0, desired)
    for frame in ("arm7::tool", "arm7_1::tool"):
        config = fd.FuzzyIkConfig(fused=fused, frame=frame, law=fd.FuzzyMapping(method))
        series = run(plant, config, Q0, desired)
        q = series["commanded_position"]
        assert q.shape == (150, 7)
        if method == "indirect":
            np.testing.assert_allclose(q, alone["commanded_position"], atol=1e-12)
        assert lengths(series["task_error"])[-1] < 1e-4


def moving_target():
    knots = np.random.default_rng(0).uniform(-0.15, 0.15, (3, 12)) + TARGET[:, None]
    return PiecewisePolynomial.CubicShapePreserving(np.linspace(0, 4, 12), knots, True)


def tracking_simulator(plant, fused):
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=fd.FuzzyIkConfig(fused=fused))
    source = builder.AddSystem(TrajectorySource(moving_target()))
    builder.Connect(source.get_output_port(), controller.get_input_port(0))
    outputs = [controller.get_output_port(i) for i in range(controller.num_output_ports())]
    sinks = [LogVectorOutput(port, builder, PERIOD) for port in outputs]
    simulator = Simulator(builder.Build())

    def run():
        root = simulator.get_mutable_context()
        controller.SetPositions(controller.GetMyMutableContextFromRoot(root), Q0)
        simulator.Initialize()
        simulator.AdvanceTo(4.0)
        return [sink.FindLog(root).data().copy() for sink in sinks]

    return simulator, run


def test_a_reset_run_repeats_itself(plant, fused):
    simulator, run = tracking_simulator(plant, fused)
    system = simulator.get_system()
    first = run()
    context = simulator.get_mutable_context()
    context.SetTime(0.0)
    system.SetDefaultContext(context)
    for sink in (s for s in system.GetSystems() if type(s).__name__.startswith("VectorLogSink")):
        sink.FindMutableLog(context).Clear()
    second = run()
    simulator.reset_context(system.CreateDefaultContext())
    third = run()
    for a, b, c in zip(first, second, third):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(a, c)


def test_simulators_in_threads_give_the_serial_result(plant, fused, in_threads):
    """One plant, one Diagram a thread: what a sweep does."""
    expected = tracking_simulator(plant, fused)[1]()
    runs = [tracking_simulator(plant, fused)[1] for _ in range(3)]
    results = in_threads(lambda i: runs[i]())
    for result in results:
        for a, b in zip(expected, result):
            np.testing.assert_array_equal(a, b)


def test_drives_the_plant_it_computes_with(fused):
    """The command as the set point of a simulated arm whose motors follow it."""
    plant = MultibodyPlant(0.0)
    fd.AddDhArm(plant, fd.load_arm("arm7"))
    plant.Finalize()
    builder = DiagramBuilder()
    robot = MultibodyPlant(1e-3)
    fd.AddDhArm(robot, fd.load_arm("arm7"))
    robot.Finalize()
    builder.AddSystem(robot)
    config = fd.FuzzyIkConfig(fused=fused, control_rate=100.0)
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    target = builder.AddSystem(ConstantVectorSource(TARGET))
    builder.Connect(target.get_output_port(), controller.get_input_port(0))
    n = np.ones(7)
    torque = builder.AddSystem(InverseDynamicsController(robot, 400 * n, 0 * n, 40 * n, False))
    desired = builder.AddSystem(Multiplexer([7, 7]))
    for i, name in enumerate(("commanded_position", "commanded_velocity")):
        builder.Connect(controller.GetOutputPort(name), desired.get_input_port(i))
    builder.Connect(desired.get_output_port(), torque.get_input_port_desired_state())
    builder.Connect(robot.get_state_output_port(), torque.get_input_port_estimated_state())
    builder.Connect(torque.get_output_port_control(), robot.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), Q0)
    own = robot.GetMyMutableContextFromRoot(root)
    robot.SetPositions(own, Q0)
    simulator.AdvanceTo(2.5)
    tool = robot.GetFrameByName("tool").CalcPoseInWorld(own).translation()
    assert np.linalg.norm(tool - TARGET) < 1e-3
