"""An arm in somebody's world: other joints, other arms and free bodies are left alone."""

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

SHARP = fd.FuzzyMapping.iterated()


def config(**changes):
    return fd.FuzzyIkConfig(
        **{"frame": "iiwa14::tool", "control_rate": 100.0, "law": SHARP, **changes}
    )


def add_world(plant, *, torso=False):
    """Two arms, the first with a finger, on a torso or not; a ball that is free; a locked-up door."""
    inertia = SpatialInertia.SolidSphereWithMass(0.1, 0.02)
    others = plant.AddModelInstance("others")
    base = plant.world_frame()
    if torso:
        bodies = [plant.AddRigidBody(name, others, inertia) for name in ("lift", "turn")]
        plant.AddJoint(PrismaticJoint("up", base, bodies[0].body_frame(), [0, 0, 1], 0.0, 0.5))
        plant.AddJoint(
            RevoluteJoint("yaw", bodies[0].body_frame(), bodies[1].body_frame(), [0, 0, 1], -1, 1)
        )
        for name in ("up", "yaw"):
            plant.AddJointActuator(f"{name}_motor", plant.GetJointByName(name))
        base = bodies[1].body_frame()
    ball = plant.AddRigidBody("ball", others, inertia)
    if plant.geometry_source_is_registered():
        friction = CoulombFriction(0.9, 0.8)
        plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(0.02), "ball", friction)
        ground = RigidTransform([0, 0, -0.05])
        world = plant.world_body()
        plant.RegisterCollisionGeometry(world, ground, Box(4, 4, 0.1), "ground", friction)
    for y in (-0.6, 0.6):
        add_arm(plant, base, y)
    finger = plant.AddRigidBody("finger", others, inertia)
    plant.AddJoint(
        PrismaticJoint(
            "grip",
            plant.GetFrameByName("tool", plant.GetModelInstanceByName("iiwa14")),
            finger.body_frame(),
            [0, 1, 0],
            0.0,
            0.04,
            50.0,
        )
    )
    plant.Finalize()
    return plant


def add_arm(plant, base, y):
    from pydrake.multibody.parsing import Parser

    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    (arm,) = parser.AddModelsFromString(fd.load_arm("iiwa14").to_urdf(capsules=False), "urdf")
    plant.WeldFrames(base, plant.GetFrameByName("base", arm), RigidTransform([0, y, 0.1]))
    return arm


HOME = np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0])


def drive(plant, target, seconds, *, start=HOME, cfg=None, **options):
    builder = DiagramBuilder()
    ik = fd.AddFuzzyIkController(builder, plant, config=cfg or config(), **options)
    builder.ExportInput(ik.get_input_port(0), "target")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    diagram.GetInputPort("target").FixValue(root, target)
    own = ik.GetMyMutableContextFromRoot(root)
    ik.SetPositions(own, start)
    simulator.AdvanceTo(seconds)
    status = fd.ControllerStatus(int(ik.GetOutputPort("status").Eval(own)[0]))
    return ik.GetOutputPort("commanded_position").Eval(own), status


@pytest.fixture(scope="module")
def world():
    return add_world(MultibodyPlant(0.0))


@pytest.fixture(scope="module")
def with_torso():
    return add_world(MultibodyPlant(0.0), torso=True)


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("options", [{}, {"restart_search": True, "posture_rate": 0.5}])
def test_only_the_joints_on_the_way_are_commanded(fused, options, world):
    """A ball, a finger and a second arm in the plant; the same command as for the arm alone."""
    target = np.array([0.5, -0.4, 0.5])
    q, status = drive(world, target, 2.0, cfg=config(fused=fused, **options))
    assert q.shape == (7,) and status == fd.ControllerStatus.CONVERGED
    alone = MultibodyPlant(0.0)
    add_arm(alone, alone.world_frame(), -0.6)
    alone.Finalize()
    expected, _ = drive(alone, target, 2.0, cfg=config(fused=fused, **options))
    np.testing.assert_allclose(q, expected, rtol=0, atol=1e-9)


def test_out_of_reach_nothing_else_is_searched(world):
    q, status = drive(world, np.array([3.0, 0.0, 0.5]), 4.0, cfg=config(restart_search=True))
    assert q.shape == (7,) and status != fd.ControllerStatus.CONVERGED


def test_joints_by_instance_and_names_and_a_torso_when_wanted(with_torso):
    panda = with_torso.GetModelInstanceByName("iiwa14_1")
    cfg = config(frame="iiwa14_1::tool")
    for joints, n in ((None, 9), (panda, 7), (["yaw", "iiwa14_1::joint1", "iiwa14_1::joint4"], 3)):
        ik = fd.MakeFuzzyIkController(with_torso, config=cfg, joints=joints)
        assert ik.GetOutputPort("commanded_position").size() == n
        assert ik.GetInputPort("estimated_position").size() == n
    with pytest.raises(ValueError, match=r"on the way.*grip"):
        fd.MakeFuzzyIkController(with_torso, config=cfg, joints=["grip"])


def test_a_joint_locked_in_the_context_stays(with_torso):
    context = with_torso.CreateDefaultContext()
    up, elbow = (
        with_torso.GetJointByName("up"),
        with_torso.GetJointByName("joint4", with_torso.GetModelInstanceByName("iiwa14")),
    )
    up.set_translation(context, 0.2)
    elbow.set_angle(context, -1.75)
    up.Lock(context)
    elbow.Lock(context)
    start = np.array([0.0, *np.delete(HOME, 3)])
    target = np.array([0.45, -0.5, 0.7])
    q, status = drive(with_torso, target, 3.0, start=start, context=context)
    assert q.shape == (7,) and status == fd.ControllerStatus.CONVERGED
    chain = fd.SerialChain.from_plant(with_torso, "iiwa14::tool", context=context)
    full = chain.to_full(q, with_torso.GetPositions(context))
    with_torso.SetPositions(context, full)
    tool = with_torso.GetFrameByName("tool", with_torso.GetModelInstanceByName("iiwa14"))
    np.testing.assert_allclose(tool.CalcPoseInWorld(context).translation(), target, atol=1e-3)
    assert up.get_translation(context) == 0.2 and elbow.get_angle(context) == -1.75


@pytest.mark.parametrize("reference, start", [("turn", HOME), ("lift", np.array([0.2, *HOME]))])
def test_targets_in_another_frame(reference, start, with_torso):
    """In the torso's frame the arm alone reaches it, in the lift's the torso turns with it."""
    target = RigidTransform([0.5, -0.5, 0.6])
    q, status = drive(
        with_torso,
        target.translation(),
        3.0,
        start=start,
        reference_frame=reference,
    )
    assert status == fd.ControllerStatus.CONVERGED
    chain = fd.SerialChain.from_plant(with_torso, "iiwa14::tool", base=reference)
    np.testing.assert_allclose(
        chain.forward_kinematics(q)[:3, 3], target.translation(), rtol=0, atol=1e-3
    )


def test_two_controllers_in_one_builder_have_names_of_their_own(world):
    builder = DiagramBuilder()
    controllers = [
        fd.AddFuzzyIkController(builder, world, config=config(frame=f"{arm}::tool"))
        for arm in ("iiwa14", "iiwa14_1")
    ]
    for controller in controllers:
        port = controller.get_input_port(0)
        builder.ExportInput(port, f"{controller.get_name()}_target")
    builder.Build()
    assert [c.get_name() for c in controllers] == ["fuzzy_ik_controller", "fuzzy_ik_controller_1"]


def test_a_task_object_has_its_joints_itself(world):
    task = fd.PositionTask(fd.PlantArm(world, "iiwa14::tool", joints=["joint1", "joint2"]))
    ik = fd.MakeFuzzyIkController(world, task=task)
    assert ik.GetOutputPort("joint_step").size() == 2
    with pytest.raises(ValueError, match="PlantArm"):
        fd.MakeFuzzyIkController(world, task=task, joints=["joint1"])


def test_torque_control_of_two_arms_in_a_plant_with_contact():
    """A ball lies on the ground between them, and stays; a finger hangs on one tool."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 2e-3)
    add_world(plant)
    targets = {"iiwa14": [0.5, -0.4, 0.5], "iiwa14_1": [0.4, 0.4, 0.6]}
    ports = {}
    for arm in targets:
        controller = fd.AddFuzzyIkTorqueController(
            builder, plant, config=config(frame=f"{arm}::tool", error_limit=0.1)
        )
        ports[arm] = controller
        builder.ExportInput(controller.get_input_port(0), arm)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    own = plant.GetMyMutableContextFromRoot(root)
    for arm, target in targets.items():
        diagram.GetInputPort(arm).FixValue(root, target)
        plant.SetPositions(own, plant.GetModelInstanceByName(arm), HOME)
    ball = plant.GetBodyByName("ball")
    plant.SetFreeBodyPose(own, ball, RigidTransform([0.4, 0.0, 0.0195]))
    simulator.AdvanceTo(1.5)
    for arm, target in targets.items():
        tool = plant.GetFrameByName("tool", plant.GetModelInstanceByName(arm))
        np.testing.assert_allclose(tool.CalcPoseInWorld(own).translation(), target, atol=3e-3)
        status = ports[arm].GetOutputPort("status")
        assert status.Eval(ports[arm].GetMyContextFromRoot(root)) == fd.ControllerStatus.CONVERGED
    resting = plant.EvalBodyPoseInWorld(own, ball).translation()
    np.testing.assert_allclose(resting, [0.4, 0.0, 0.02], atol=2e-3)
    assert np.abs(plant.GetVelocities(own)).max() < 0.2


def test_torque_control_names_joints_without_an_actuator():
    plant = MultibodyPlant(1e-3)
    add_world(plant)
    with pytest.raises(ValueError, match=r"\['grip'\] have none"):
        fd.FuzzyIkTorqueController(plant, config=config(frame="finger"))
