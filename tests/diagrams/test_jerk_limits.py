"""A limit of jerk in whole runs: Diagram, fused, rollout, the torque controller's reference."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.rollout import rollout
from fikm_drake.kinematics.plant_arm import PlantArm

RATE = 100.0
Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
JERK, ACCELERATION, SPEED = 60.0, 6.0, 1.5
CONFIG = fd.FuzzyIkConfig(
    control_rate=RATE,
    velocity_limits=[SPEED],
    acceleration_limits=[ACCELERATION],
    jerk_limits=[JERK],
)


def targets(cycles=400):
    """Two places that the arm reaches, one after the other."""
    arm = fd.load_arm("arm7")
    places = arm.forward_kinematics(np.array([Q0 + 0.4, Q0 - 0.3]))[:, :3, 3]
    return places[np.arange(cycles) * 2 // cycles]


def derivatives(q):
    """Largest speed, acceleration and jerk of a command that starts from rest."""
    q = np.vstack([q[:1], q[:1], q[:1], q])
    return [np.abs(np.diff(q, n=n, axis=0)).max() * RATE**n for n in (1, 2, 3)]


def test_limits_are_kept_diagram_fused_and_rollout_are_one_and_the_target_is_reached(plant, run):
    runs = [run(plant, replace(CONFIG, fused=fused), Q0, targets()) for fused in (False, True)]
    for name, values in runs[0].items():
        np.testing.assert_array_equal(values, runs[1][name], err_msg=name)
    q = np.vstack([runs[0]["commanded_position"], runs[0]["after"]])
    speed, acceleration, jerk = derivatives(q)
    assert speed <= SPEED * (1 + 1e-9)
    assert acceleration <= ACCELERATION * (1 + 1e-9) and jerk <= JERK * (1 + 1e-6)
    assert jerk > 0.5 * JERK  # the limit is used
    assert runs[0]["status"][-1] == Status.CONVERGED
    task = fd.PositionTask(PlantArm(plant, "tool"))
    path = rollout(ControlCycle(task, CONFIG), [*targets()], Q0)
    np.testing.assert_allclose(path.q, q[1:], atol=1e-12)
    # Without the limit there is more.
    free = run(plant, replace(CONFIG, jerk_limits=[]), Q0, targets())["commanded_position"]
    assert derivatives(free)[2] > 5.0 * JERK


def test_it_is_converged_only_where_what_goes_out_is(plant, run, fused):
    config = replace(CONFIG, fused=fused, tolerance=1e-4)
    series = run(plant, config, Q0, targets())
    arm = fd.load_arm("arm7")
    sent = arm.forward_kinematics(series["commanded_position"])[:, :3, 3]
    error = np.linalg.norm(targets() - sent, axis=1)
    converged = series["status"][:, 0] == Status.CONVERGED
    assert converged.any() and (error[converged] <= 1e-4 + 1e-12).all()
    newest = np.linalg.norm(series["task_error"], axis=1)
    assert ((newest <= 1e-4) & ~converged).any()  # it waits for what is late


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_lost_target_brakes_within_the_limits(bad, plant, run, fused):
    desired = targets()
    desired[15:120] = bad
    series = run(plant, replace(CONFIG, fused=fused), Q0, desired)
    q = series["commanded_position"]
    assert np.isfinite(q).all()
    assert derivatives(q)[2] <= JERK * (1 + 1e-6)
    assert not np.diff(q[90:120], axis=0).any()


def test_it_starts_where_the_robot_is(fused):
    arm = fd.load_arm("hassantabar3r")
    builder, q = DiagramBuilder(), np.array([1.0, 0.5, 0.3])
    config = fd.FuzzyIkConfig(fused=fused, task="xy", jerk_limits=[200.0])
    controller = fd.AddFuzzyIkController(builder, fd.MakeDhArmPlant(arm), config=config)
    for values, port in (
        (arm.forward_kinematics(q)[:2, 3], "desired_position"),
        (q, "estimated_position"),
    ):
        source = builder.AddSystem(ConstantVectorSource(values))
        builder.Connect(source.get_output_port(), controller.GetInputPort(port))
    simulator = Simulator(builder.Build())
    own = controller.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    simulator.Initialize()
    command = controller.GetOutputPort("commanded_position")
    np.testing.assert_allclose(command.Eval(own), q, atol=1e-15)
    assert not controller.GetOutputPort("commanded_velocity").Eval(own).any()
    simulator.AdvanceTo(1.0)
    np.testing.assert_allclose(command.Eval(own), q, atol=1e-12)
    assert controller.GetOutputPort("status").Eval(own)[0] == Status.CONVERGED


def test_the_reference_of_torques_keeps_it_too():
    """desired_state of the inner loop, sample by sample; it ends where the command does."""
    step, builder = 1e-3, DiagramBuilder()
    system = builder.AddSystem(
        fd.JointReference(
            7,
            period=0.01,
            time_step=step,
            velocity_limits=np.full(7, SPEED),
            acceleration_limits=20.0,
            jerk_limits=JERK,
        )
    )
    log = LogVectorOutput(system.get_output_port(), builder, step)
    builder.ExportInput(system.GetInputPort("commanded_position"), "command")
    builder.ExportInput(system.GetInputPort("commanded_velocity"), "velocity")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    system.SetPositions(system.GetMyMutableContextFromRoot(root), np.zeros(7))
    diagram.GetInputPort("command").FixValue(root, np.linspace(0.1, 1.0, 7))
    diagram.GetInputPort("velocity").FixValue(root, np.zeros(7))
    simulator.AdvanceTo(4.0)
    data = log.FindLog(root).data().T
    q, v = data[:, :7], data[:, 7:]
    np.testing.assert_allclose(np.diff(q, axis=0), step * v[1:], atol=1e-12)
    a = np.diff(v, axis=0) / step
    assert np.abs(v).max() <= SPEED * (1 + 1e-9)
    assert np.abs(np.diff(a, axis=0)).max() / step <= JERK * (1 + 1e-6)
    np.testing.assert_allclose(q[-1], np.linspace(0.1, 1.0, 7), atol=1e-6)


def test_the_torque_controller_passes_it_on():
    plant = MultibodyPlant(1e-3)
    fd.AddDhArm(plant, fd.load_arm("arm7"))
    plant.Finalize()
    groups = {}
    for config in (CONFIG, replace(CONFIG, jerk_limits=[])):
        controller = fd.FuzzyIkTorqueController(plant, config=config)
        reference = controller.GetSubsystemByName("joint_reference")
        context = reference.CreateDefaultContext()
        groups[bool(config.jerk_limits)] = context.num_discrete_state_groups()
    assert groups == {True: 2, False: 1}


def test_vectors_survive_yaml_and_joints_without_a_limit_have_none(plant, run):
    jerks = [JERK, np.inf, *[5e3] * 5]
    text = yaml_dump_typed(replace(CONFIG, jerk_limits=jerks))
    config = yaml_load_typed(schema=fd.FuzzyIkConfig, data=text)
    assert config.jerk_limits == jerks
    q = run(plant, config, Q0, targets(200))["commanded_position"]
    jerk = np.abs(np.diff(q, n=3, axis=0, prepend=np.tile(q[:1], (3, 1)))).max(axis=0) * RATE**3
    assert (jerk <= np.array(jerks) * (1 + 1e-6)).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"jerk_limits": [0.0]}, ["jerk_limits", "positive"]),
        ({"jerk_limits": [1.0, 2.0]}, ["jerk_limits", "7"]),
        ({"jerk_limits": [1e-6]}, ["jerk_limits", "raise"]),
        (
            {
                "default_velocity_limit": np.inf,
                "velocity_limits": [],
                "acceleration_limits": [],
            },
            ["jerk_limits", "velocity_limits"],
        ),
    ],
)
def test_errors_name_the_bad_value_and_the_remedy(changes, words, plant, fused):
    with pytest.raises(ValueError) as error:
        fd.MakeFuzzyIkController(plant, config=replace(CONFIG, fused=fused, **changes))
    for word in words:
        assert word in str(error.value)


def test_with_obstacles_it_is_refused(fused):
    """What goes out lies between positions that were looked at."""
    arm = fd.load_arm("iiwa14")
    checker = fd.MakeCollisionChecker(arm)
    config = replace(CONFIG, fused=fused)
    with pytest.raises(ValueError, match="collision checker"):
        fd.MakeFuzzyIkController(fd.MakeDhArmPlant(arm), config=config, collision_checker=checker)
