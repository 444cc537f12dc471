"""Chains against Drake: our models, random plants, joints of one's choice."""

import dataclasses
import pickle

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    JacobianWrtVariable,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    WeldJoint,
)

import fikm_drake as fd
from fikm_drake.kinematics.serial_chain import SerialChain, as_chain
from fikm_drake.resources import model_names

SEEDS = range(12)


def pose(rng, length=1.0):
    """A random pose; often with right angles, as people's models have."""
    if rng.random() < 0.3:
        R = RotationMatrix.MakeXRotation(
            np.pi / 2 * rng.integers(4)
        ) @ RotationMatrix.MakeZRotation(np.pi / 2 * rng.integers(4))
    elif rng.random() < 0.3:  # nearly parallel axes: a right angle to a few digits
        R = RotationMatrix.MakeYRotation(1e-6 * rng.normal())
    else:
        Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        R = RotationMatrix(Q * np.linalg.det(Q))
    return RigidTransform(R, length * rng.normal(size=3) * rng.integers(0, 2, 3))


def random_plant(seed, *, bodies=9, floating=True):
    """A tree of revolute, prismatic, welded and ball joints with frames of their own, some reversed."""
    rng = np.random.default_rng(seed)
    plant = MultibodyPlant(0.0)
    added = [plant.world_body()]
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    for i in range(bodies):
        body = plant.AddRigidBody(f"body{i}", inertia)
        parent = added[-1] if rng.random() < 0.7 else added[rng.integers(len(added))]
        frames = [parent, body]
        kind = rng.choice(["revolute", "prismatic", "weld", "ball"], p=[0.55, 0.25, 0.1, 0.1])
        if kind != "ball" and rng.random() < 0.2 and parent.name() != "world":
            frames.reverse()
        frames = [
            plant.AddFrame(FixedOffsetFrame(f"{'PC'[k]}{i}", f.body_frame(), pose(rng)))
            for k, f in enumerate(frames)
        ]
        axis = np.eye(3)[rng.integers(3)] if rng.random() < 0.5 else rng.normal(size=3)
        axis = axis * rng.choice([-1.0, 1.0])
        name, limits = f"j{i}", np.sort(rng.uniform(-2, 2, 2))
        if kind == "revolute":
            joint = RevoluteJoint(name, *frames, axis, *limits, 0.0)
        elif kind == "prismatic":
            joint = PrismaticJoint(name, *frames, axis, *limits, 0.0)
        elif kind == "weld":
            joint = WeldJoint(name, *frames, pose(rng))
        else:
            joint = BallRpyJoint(name, *frames)
        plant.AddJoint(joint)
        added.append(body)
    if floating:
        plant.AddRigidBody("free", inertia)
    plant.AddFrame(FixedOffsetFrame("tool", added[-1].body_frame(), pose(rng)))
    plant.Finalize()
    return plant


def check(plant, chain, context, rng, *, tool, base=None, count=4):
    """FK and Jacobian of a chain equal Drake's at random positions of its joints."""
    base = plant.world_frame() if base is None else base
    q_plant = plant.GetPositions(context)
    for _ in range(count):
        q = rng.uniform(-3, 3, chain.num_joints)
        full = chain.to_full(q, q_plant)
        np.testing.assert_array_equal(chain.from_full(full), q)
        scratch = context.Clone()
        plant.SetPositions(scratch, full)
        X = tool.CalcPose(scratch, base).GetAsMatrix4()
        J = plant.CalcJacobianSpatialVelocity(
            scratch, JacobianWrtVariable.kV, tool, np.zeros(3), base, base
        )[:, chain.velocity_indices]
        size = max(1.0, chain.reach)
        np.testing.assert_allclose(chain.forward_kinematics(q), X, rtol=0, atol=1e-12 * size)
        np.testing.assert_allclose(chain.jacobian(q), J, rtol=0, atol=1e-12 * size)
        others = np.delete(np.arange(plant.num_positions()), chain.position_indices)
        np.testing.assert_array_equal(full[others], q_plant[others])


@pytest.mark.parametrize("name", model_names())
def test_our_models_equal_drakes_and_their_tables_chain(name):
    arm = fd.load_arm(name)
    plant = fd.MakeDhArmPlant(arm)
    chain = SerialChain.from_plant(plant, "tool")
    check(
        plant,
        chain,
        plant.CreateDefaultContext(),
        np.random.default_rng(0),
        tool=plant.GetFrameByName("tool"),
    )
    q = np.random.default_rng(1).uniform(-3, 3, (5, arm.num_joints))
    np.testing.assert_allclose(chain.jacobian(q), arm.chain.jacobian(q), rtol=0, atol=1e-13)
    assert chain.joint_names == arm.chain.joint_names and chain.kinds == arm.chain.kinds
    for field in ("lower", "upper", "velocity_limits", "default_position"):
        np.testing.assert_array_equal(getattr(chain, field), getattr(arm.chain, field))
    assert chain.reach == pytest.approx(arm.chain.reach, rel=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_plants_equal_drakes(seed):
    plant, rng = random_plant(seed), np.random.default_rng(seed)
    context = plant.CreateDefaultContext()
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_positions() in (1, 3):
            start = joint.position_start()
            q = plant.GetPositions(context)
            q[start : start + joint.num_positions()] = rng.uniform(-1, 1, joint.num_positions())
            plant.SetPositions(context, q)
    tool = plant.GetFrameByName("tool")
    check(plant, SerialChain.from_plant(plant, tool, context=context), context, rng, tool=tool)
    # From a body somewhere in the tree: the way goes back, then out; all joints of it move.
    for base in (plant.GetFrameByName("body2"), plant.GetFrameByName("P5")):
        names = [
            name
            for name in (f"j{i}" for i in range(9))
            if plant.GetJointByName(name).type_name() in ("revolute", "prismatic")
            and moves(plant, context, plant.GetJointByName(name), tool, base)
        ]
        if names:
            chain = SerialChain.from_plant(plant, tool, base=base, joints=names, context=context)
            assert sorted(chain.joint_names) == sorted(names)
            check(plant, chain, context, rng, tool=tool, base=base)


def moves(plant, context, joint, tool, base):
    J = plant.CalcJacobianSpatialVelocity(
        context, JacobianWrtVariable.kV, tool, np.zeros(3), base, base
    )
    return np.abs(J[:, joint.velocity_start()]).max() > 1e-6


@pytest.fixture
def torso():
    """A torso that lifts and turns, with two Pandas on it, a hand that opens, and a brick beside."""
    plant = MultibodyPlant(0.0)
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    lift, turn = plant.AddRigidBody("lift", inertia), plant.AddRigidBody("turn", inertia)
    plant.AddJoint(
        PrismaticJoint("up", plant.world_frame(), lift.body_frame(), [0, 0, 1], 0.0, 0.5)
    )
    plant.AddJoint(RevoluteJoint("yaw", lift.body_frame(), turn.body_frame(), [0, 0, 1], -1, 1))
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    for side in (-0.2, 0.2):
        (arm,) = parser.AddModelsFromString(fd.load_arm("panda").to_urdf(), "urdf")
        plant.WeldFrames(
            turn.body_frame(), plant.GetFrameByName("base", arm), RigidTransform([0, side, 0.5])
        )
    others = plant.AddModelInstance("others")
    finger = plant.AddRigidBody("finger", others, inertia)
    plant.AddJoint(
        PrismaticJoint(
            "grip",
            plant.GetFrameByName("tool", plant.GetModelInstanceByName("panda")),
            finger.body_frame(),
            [0, 1, 0],
            0.0,
            0.04,
        )
    )
    plant.AddRigidBody("brick", others, inertia)
    plant.Finalize()
    return plant


ARM = tuple(f"joint{i}" for i in range(1, 8))


def test_which_joints_move_by_default_by_name_by_instance_and_from_a_base(torso):
    chain = SerialChain.from_plant(torso, "panda::tool")
    assert chain.joint_names == ("up", "yaw", *ARM)
    panda = torso.GetModelInstanceByName("panda")
    by_instance = SerialChain.from_plant(torso, "panda::tool", joints=panda)
    by_name = SerialChain.from_plant(torso, "panda::tool", joints=[f"panda::{n}" for n in ARM])
    from_base = SerialChain.from_plant(torso, "panda::tool", base="turn")
    for other in (by_instance, by_name, from_base):
        assert other.joint_names == ARM
    q = np.random.default_rng(2).uniform(-1, 1, 7)
    np.testing.assert_array_equal(by_instance.jacobian(q), by_name.jacobian(q))
    lifted = np.eye(4)
    np.testing.assert_allclose(
        by_name.forward_kinematics(q), lifted @ from_base.forward_kinematics(q), atol=1e-14
    )
    second = SerialChain.from_plant(torso, "panda_1::tool", joints=["yaw", *ARM])
    assert not set(second.position_indices[1:]) & set(by_name.position_indices)
    assert second.joint_names == ("yaw", *ARM)
    assert "grip" in SerialChain.from_plant(torso, "finger").joint_names


def test_locked_joints_are_held_where_the_context_has_them(torso):
    context = torso.CreateDefaultContext()
    yaw = torso.GetJointByName("yaw")
    yaw.set_angle(context, 0.4)
    yaw.Lock(context)
    chain = SerialChain.from_plant(torso, "panda::tool", context=context)
    assert chain.joint_names == ("up", *ARM)
    tool = torso.GetFrameByName("tool", torso.GetModelInstanceByName("panda"))
    check(torso, chain, context, np.random.default_rng(3), tool=tool)
    with pytest.raises(ValueError, match=r"not locked.*\['yaw'\]"):
        SerialChain.from_plant(torso, "panda::tool", joints=["yaw"], context=context)


def test_bad_joints_and_frames_are_named(torso):
    for joints, words in (
        (["elbow"], ["elbow", "names 0", "yaw"]),
        (["grip"], ["grip", "on the way"]),
        ([], ["no joint moves", "yaw (revolute)"]),
    ):
        with pytest.raises(ValueError) as error:
            SerialChain.from_plant(torso, "panda::tool", joints=joints)
        assert all(word in str(error.value) for word in words)
    with pytest.raises(ValueError, match="no joint moves frame 'brick'"):
        SerialChain.from_plant(torso, "brick")
    with pytest.raises(ValueError, match="panda::tool"):
        SerialChain.from_plant(torso, "tool")
    with pytest.raises(ValueError, match="finalized"):
        SerialChain.from_plant(MultibodyPlant(0.0), "world")


def test_many_postures_are_those_of_one_at_a_time():
    chain = fd.load_arm("iiwa14").chain
    q = np.random.default_rng(4).uniform(-3, 3, (2, 3, 7))
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(chain.jacobian(q)[index], chain.jacobian(q[index]), atol=1e-15)
        np.testing.assert_allclose(
            chain.forward_kinematics(q)[index], chain.forward_kinematics(q[index]), atol=1e-15
        )


@pytest.mark.parametrize("name", model_names())
def test_no_posture_is_farther_than_the_reach_and_some_are_nearly_so(name):
    arm = fd.load_arm(name)
    chain = arm.chain
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (20000, arm.num_joints))
    q = np.where(chain.revolute, q, np.clip(q, chain.lower, chain.upper))
    links, tool = chain.link_poses(q), chain.forward_kinematics(q)[:, :3, 3]
    across = np.linalg.norm(np.cross(links[:, 0, :3, 2], tool - links[:, 0, :3, 3]), axis=1)
    assert across.max() <= chain.reach * (1 + 1e-9)
    assert across.max() >= 0.6 * chain.reach


def test_reach_scales_and_does_not_know_where_on_an_axis_a_frame_stands():
    chain = fd.load_arm("panda").chain
    before, tool = chain.before.copy(), chain.tool.copy()
    slide = np.eye(4)
    slide[2, 3] = 7.0
    before[3], before[4] = before[3] @ slide, np.linalg.inv(slide) @ before[4]
    assert replaced(chain, before, tool).reach == pytest.approx(chain.reach)
    before[:, :3, 3] *= 1e-6
    tool[:3, 3] *= 1e-6
    assert replaced(chain, before, tool).reach == pytest.approx(1e-6 * chain.reach)


def replaced(chain, before, tool):
    return dataclasses.replace(chain, before=before, tool=tool)


def test_a_chain_cannot_be_written_to_and_what_is_no_chain_is_named():
    chain = fd.load_arm("panda").chain
    with pytest.raises(ValueError, match="read-only"):
        chain.before[0, 0, 0] = 2.0
    assert as_chain(chain) is chain and as_chain(fd.load_arm("panda")).num_joints == 7
    with pytest.raises(ValueError, match="SerialChain.*got str"):
        as_chain("panda")
    with pytest.raises(ValueError, match="of no plant"):
        chain.from_full(np.zeros(7))
    for field, value, words in (
        ("lower", np.full(7, 9.0), ["joint1", "lower", "9.0"]),
        ("upper", np.zeros(6), ["upper", "(7,)", "(6,)"]),
        ("kinds", ("ball",) * 7, ["joint1", "ball", "revolute"]),
        ("tool", 2 * np.eye(4), ["rigid"]),
        ("velocity_limits", np.full(7, np.nan), ["joint1", "velocity_limits", "nan"]),
    ):
        with pytest.raises(ValueError) as error:
            dataclasses.replace(chain, **{field: value})
        assert all(word in str(error.value) for word in words)


@pytest.mark.parametrize("name", ["iiwa14", "hassantabar4r"])
def test_an_arm_that_has_been_used_can_be_sent_to_another_process(name):
    """The native kernel's addresses hold in one process only."""
    arm = fd.load_arm(name)
    q = np.full(arm.num_joints, 0.2)
    X, J = arm.forward_kinematics(q), arm.jacobian(q)
    copy = pickle.loads(pickle.dumps(arm))
    np.testing.assert_array_equal(copy.forward_kinematics(q), X)
    np.testing.assert_array_equal(copy.jacobian(q), J)
