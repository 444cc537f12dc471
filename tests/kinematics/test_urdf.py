"""The generated URDFs, and arms in a MultibodyPlant."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import ConfigureParser, model_names, models_dir


@pytest.mark.parametrize("name", model_names())
def test_stored_urdf_is_the_generated_one(name):
    """Made by `fikm-drake urdf NAME > models/NAME.urdf`."""
    assert (models_dir() / f"{name}.urdf").read_text("utf-8") == load_arm(name).to_urdf()


def test_no_urdf_without_its_table():
    assert sorted(path.stem for path in models_dir().glob("*.urdf")) == model_names()


@pytest.mark.parametrize("name", model_names())
def test_names_of_bodies_joints_and_actuators(name):
    arm = load_arm(name)
    numbers = range(1, arm.num_joints + 1)
    plant = MultibodyPlant(0.0)
    instance = AddDhArm(plant, arm)
    plant.Finalize()
    assert plant.GetModelInstanceName(instance) == name
    bodies = [plant.get_body(i).name() for i in plant.GetBodyIndices(instance)]
    assert bodies == ["base", *(f"link{i}" for i in numbers), "tool"]
    joints = [plant.get_joint(i) for i in plant.GetJointIndices(instance)]
    moving = [joint.name() for joint in joints if joint.num_velocities()]
    assert moving == [f"joint{i}" for i in numbers]
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices(instance)]
    assert [actuator.joint().name() for actuator in actuators] == moving
    assert [actuator.name() for actuator in actuators] == [f"joint{i}_motor" for i in numbers]
    assert plant.num_positions() == plant.num_velocities() == arm.num_joints
    context = plant.CreateDefaultContext()
    np.testing.assert_array_equal(plant.GetPositions(context), arm.default_position)
    base = plant.GetBodyByName("base")
    assert plant.EvalBodyPoseInWorld(context, base).IsExactlyIdentity()


@pytest.mark.parametrize("name", model_names())
def test_limits_of_the_plant_are_the_arms(name):
    arm = load_arm(name)
    plant = MultibodyPlant(0.0)
    AddDhArm(plant, arm)
    plant.Finalize()
    np.testing.assert_array_equal(plant.GetPositionLowerLimits(), arm.lower)
    np.testing.assert_array_equal(plant.GetPositionUpperLimits(), arm.upper)
    np.testing.assert_array_equal(plant.GetVelocityUpperLimits(), arm.velocity_limits)
    np.testing.assert_array_equal(plant.GetVelocityLowerLimits(), -arm.velocity_limits)


def test_one_sided_limits_survive_the_urdf():
    rows = [DhJoint(upper=1.0), DhJoint(type="prismatic", lower=0.2), DhJoint(type="prismatic")]
    arm = DhArm(DhTable("arm", joints=rows))
    plant = MultibodyPlant(0.0)
    AddDhArm(plant, arm)
    plant.Finalize()
    np.testing.assert_array_equal(plant.GetPositionLowerLimits(), [-np.inf, 0.2, -np.inf])
    np.testing.assert_array_equal(plant.GetPositionUpperLimits(), [1.0, np.inf, np.inf])


def test_two_arms_in_one_plant():
    plant = MultibodyPlant(0.0)
    arms = [load_arm("panda"), load_arm("panda"), load_arm("planar2")]
    instances = [AddDhArm(plant, arm) for arm in arms]
    plant.Finalize()
    names = [plant.GetModelInstanceName(instance) for instance in instances]
    assert len(set(names)) == 3
    assert plant.num_positions() == 16
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(1)
    positions = [rng.uniform(-1, 1, arm.num_joints) for arm in arms]
    for instance, q in zip(instances, positions):
        plant.SetPositions(context, instance, q)
    for arm, instance, q in zip(arms, instances, positions):
        X = plant.GetFrameByName("tool", instance).CalcPoseInWorld(context).GetAsMatrix4()
        np.testing.assert_allclose(X, arm.forward_kinematics(q), rtol=0, atol=1e-12)


def test_finalized_plant_is_refused():
    plant = MultibodyPlant(0.0)
    plant.Finalize()
    with pytest.raises(ValueError, match=r"planar2.*finalized"):
        AddDhArm(plant, load_arm("planar2"))


@pytest.mark.parametrize("name", ["a--b", "a-", "x", "Größe_2", "a" * 200])
def test_every_valid_name_makes_a_valid_urdf(name):
    from xml.etree import ElementTree as ET

    arm = DhArm(DhTable(name, joints=[DhJoint()]))
    assert ET.fromstring(arm.to_urdf()).get("name") == name
    plant = MultibodyPlant(0.0)
    assert plant.GetModelInstanceName(AddDhArm(plant, arm)) == name


def test_package_url_resolves_by_configure_parser():
    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    ConfigureParser(parser)
    (instance,) = parser.AddModelsFromUrl("package://fikm_drake/arm7.urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base", instance))
    plant.Finalize()
    tool = plant.GetFrameByName("tool").CalcPoseInWorld(plant.CreateDefaultContext())
    np.testing.assert_allclose(tool.translation(), [0.2, -0.6, 0.6], rtol=0, atol=1e-12)


def test_shapes_are_seen_where_there_is_a_scene_graph():
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    AddDhArm(plant, load_arm("arm7"))
    plant.Finalize()
    from pydrake.geometry import Role

    inspector = scene_graph.model_inspector()
    assert inspector.NumGeometriesWithRole(Role.kIllustration) >= 7
    assert inspector.NumGeometriesWithRole(Role.kProximity) == 7


@pytest.mark.parametrize("name", model_names())
def test_neighbours_never_collide_and_no_arm_does_when_stretched(name):
    """Links of a spherical wrist and those around a short link touch in every posture: filtered."""
    arm = load_arm(name)
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    AddDhArm(plant, arm)
    plant.Finalize()
    diagram = builder.Build()
    context = plant.GetMyContextFromRoot(diagram.CreateDefaultContext())
    rng = np.random.default_rng(2)
    lower, upper = np.maximum(arm.lower, -3), np.minimum(arm.upper, 3)
    hits = np.zeros(20, dtype=bool)
    for i in range(20):
        plant.SetPositions(context, rng.uniform(lower, upper))
        pairs = plant.get_geometry_query_input_port().Eval(context).ComputePointPairPenetration()
        hits[i] = bool(pairs)
    assert hits.mean() <= 0.5  # the rest is real: arm7 and planar4 can reach themselves
    plant.SetPositions(context, np.clip(np.full(arm.num_joints, 0.3), lower, upper))
    query = plant.get_geometry_query_input_port().Eval(context)
    assert not query.ComputePointPairPenetration()


def scaled(name, scale):
    table = load_arm(name).table
    for row in (*table.joints, table.tool):
        row.a, row.d = scale * row.a, scale * row.d
    return DhArm(table)


@pytest.mark.parametrize("scale", [1e-2, 1e-1, 10.0])
@pytest.mark.parametrize("name", ["panda", "puma560", "planar2"])
def test_arms_of_any_size_keep_their_numbers(name, scale):
    arm = scaled(name, scale)
    plant = MultibodyPlant(0.0)
    AddDhArm(plant, arm)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    tool = plant.GetFrameByName("tool")
    big, big_context = MultibodyPlant(0.0), None
    AddDhArm(big, load_arm(name))
    big.Finalize()
    big_context = big.CreateDefaultContext()
    for q in np.random.default_rng(3).uniform(-2, 2, (4, arm.num_joints)):
        plant.SetPositions(context, q)
        X = tool.CalcPoseInWorld(context).GetAsMatrix4()
        np.testing.assert_allclose(X, arm.forward_kinematics(q), rtol=0, atol=1e-13 * max(1, scale))
        big.SetPositions(big_context, q)
        # Masses are volumes times a density: M of a revolute arm scales by the fifth power.
        np.testing.assert_allclose(
            plant.CalcMassMatrix(context) / scale**5,
            big.CalcMassMatrix(big_context),
            rtol=0,
            atol=2e-4,
        )


def test_no_limit_may_be_written_as_inf_and_velocity_is_always_there():
    rows = [DhJoint(a=1.0, velocity=np.inf), DhJoint(a=1.0, upper=np.inf, velocity=2.0), DhJoint()]
    arm = DhArm(DhTable("arm", joints=rows))
    plant = MultibodyPlant(0.0)
    AddDhArm(plant, arm)
    plant.Finalize()
    np.testing.assert_array_equal(plant.GetVelocityUpperLimits(), [np.inf, 2.0, np.inf])
    assert arm.to_urdf().count('velocity="') == 3 and "inf" not in arm.to_urdf()


def test_random_arms_have_physically_valid_inertias(random_arm):
    rng = np.random.default_rng(21)
    for _ in range(40):
        plant = MultibodyPlant(0.0)
        instance = AddDhArm(plant, random_arm(rng))
        plant.Finalize()
        context = plant.CreateDefaultContext()
        for index in plant.GetBodyIndices(instance):
            inertia = plant.get_body(BodyIndex(index)).default_spatial_inertia()
            assert inertia.IsPhysicallyValid()
        M = plant.CalcMassMatrix(context)
        np.linalg.cholesky(M)  # positive definite: every joint has something to move


@pytest.mark.parametrize("name", model_names())
def test_unactuated_arm_falls_and_keeps_its_energy(name):
    """Half a second under gravity; no damping, limits far away: kinetic + potential is constant."""
    arm = load_arm(name)
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    AddDhArm(plant, arm)
    plant.mutable_gravity_field().set_gravity_vector([0.0, -9.81, 0.0])  # planar arms swing too
    plant.Finalize()
    plant.get_actuation_input_port()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.get_actuation_input_port().FixValue(context, np.zeros(arm.num_joints))
    inside = np.clip(0.3, arm.lower + 0.5, arm.upper - 0.5)
    plant.SetPositions(context, np.broadcast_to(inside, arm.num_joints))

    def energy():
        return plant.CalcPotentialEnergy(context) + plant.CalcKineticEnergy(context)

    before = energy()
    simulator.get_mutable_integrator().set_target_accuracy(1e-8)
    simulator.AdvanceTo(0.5)
    moved = plant.CalcKineticEnergy(context)
    assert moved > 0.01
    assert abs(energy() - before) < 1e-4 * max(moved, 1.0)
