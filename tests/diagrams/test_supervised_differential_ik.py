"""Drake's differential IK and others, supervised and integrated in one Diagram."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

import fikm_drake as fd
from fikm_drake.diagrams.drake_differential_ik import (
    desired_pose,
    drake_differential_ik,
)
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake

PERIOD = 0.01
HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])


class Proportional(LeafSystem):
    """A differential IK of one's own, in joint space; `position_name` to break it."""

    def __init__(self, n, position_name="position", outputs=None):
        super().__init__()
        target = self.DeclareVectorInputPort("target", n)
        position = self.DeclareVectorInputPort(position_name, n)

        def calc(context, output):
            output.set_value(5.0 * (target.Eval(context) - position.Eval(context))[: output.size()])

        self.DeclareVectorOutputPort("commanded_velocity", outputs or n, calc)


@pytest.fixture(scope="module")
def iiwa():
    return fd.load_arm("iiwa14")


@pytest.fixture(scope="module")
def supervised(iiwa):
    ik = drake_differential_ik(iiwa, period=PERIOD)
    return fd.SupervisedDifferentialIk(ik, ik.plant(), period=ik.time_step())


def test_ports_of_drakes_system_are_passed_on(supervised, ports):
    inputs, outputs = ports(supervised)
    assert set(inputs) == {
        "nominal_posture",
        "desired_cartesian_poses",
        "desired_cartesian_velocities",
    }
    assert outputs == {
        "commanded_position": 7,
        "commanded_velocity": 7,
        "gain": 7,
        "oscillating": 7,
        "valid": 1,
    }


def test_a_pose_is_reached_in_a_users_diagram(iiwa):
    """Built by the factory, its targets from Drake's own sources."""
    q = HOME + 0.2
    T = iiwa.forward_kinematics(q)
    X = RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])
    builder = DiagramBuilder()
    ik = drake_differential_ik(iiwa, period=PERIOD)
    system = fd.AddSupervisedDifferentialIk(builder, ik, ik.plant(), period=PERIOD)
    for source, port in (
        (ConstantValueSource(desired_pose(iiwa, X)), "desired_cartesian_poses"),
        (ConstantVectorSource(HOME), "nominal_posture"),
    ):
        builder.AddSystem(source)
        builder.Connect(source.get_output_port(), system.GetInputPort(port))
    diagram = builder.Build()
    assert diagram.GetSubsystemByName("supervised_differential_ik") is system
    simulator = Simulator(diagram)
    context = system.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    system.SetPositions(context, HOME)
    with quiet_drake():
        simulator.AdvanceTo(3.0)
    reached = iiwa.forward_kinematics(system.GetOutputPort("commanded_position").Eval(context))
    np.testing.assert_allclose(reached, T, atol=1e-4)
    np.testing.assert_array_equal(system.GetOutputPort("gain").Eval(context), np.ones(7))


def test_a_system_of_ones_own_reaches_its_target_inside_the_limits(iiwa, plant_with):
    plant = plant_with("iiwa14")
    system = fd.SupervisedDifferentialIk(Proportional(7), plant, period=PERIOD)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.SetPositions(context, HOME)
    target = np.array([0.5, 3.0, -0.5, -3.0, 0.3, 0.2, 0.1])
    system.GetInputPort("target").FixValue(context, target)
    simulator.AdvanceTo(3.0)
    position = system.GetOutputPort("commanded_position").Eval(context)
    np.testing.assert_allclose(position, np.clip(target, iiwa.lower, iiwa.upper), atol=1e-5)


def test_holds_while_the_command_is_not_finite(plant_with):
    system = fd.SupervisedDifferentialIk(Proportional(7), plant_with("iiwa14"), period=PERIOD)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.SetPositions(context, HOME)
    system.GetInputPort("target").FixValue(context, np.full(7, np.nan))
    simulator.AdvanceTo(0.1)
    np.testing.assert_array_equal(system.GetOutputPort("commanded_position").Eval(context), HOME)
    np.testing.assert_array_equal(
        system.GetOutputPort("commanded_velocity").Eval(context), np.zeros(7)
    )
    assert system.GetOutputPort("valid").Eval(context) == 0


def test_starts_at_the_plants_default_position(plant_with):
    plant = plant_with("panda")
    system = fd.SupervisedDifferentialIk(Proportional(7), plant, period=PERIOD)
    start = system.GetOutputPort("commanded_position").Eval(system.CreateDefaultContext())
    np.testing.assert_array_equal(start, fd.load_arm("panda").default_position)


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (Proportional(6), ["input position", "size 7", "'position': 6"]),
        (Proportional(7, outputs=6), ["output commanded_velocity", "'commanded_velocity': 6"]),
        (Proportional(7, position_name="q"), ["input position", "'q': 7"]),
    ],
)
def test_ports_that_do_not_fit_are_named(system, words, plant_with):
    with pytest.raises(ValueError) as error:
        fd.SupervisedDifferentialIk(system, plant_with("iiwa14"), period=PERIOD)
    assert all(word in str(error.value) for word in words)


def test_the_plant_must_be_finalized():
    with pytest.raises(ValueError, match="finalized"):
        fd.SupervisedDifferentialIk(Proportional(7), MultibodyPlant(0.0), period=PERIOD)


def test_bad_position_and_period_are_named(supervised, plant_with):
    with pytest.raises(ValueError, match=r"joint position\[0\] must be from"):
        supervised.SetPositions(supervised.CreateDefaultContext(), np.full(7, 9.0))
    with pytest.raises(ValueError, match="period"):
        fd.SupervisedDifferentialIk(Proportional(7), plant_with("iiwa14"), period=0.0)
