"""Whatever solves at the position level takes a chain of a plant that holds more than the arm."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

import fikm_drake as fd


def chain_in_a_world(name):
    """The arm at the origin, a second one beside it, a free body; the chain of the first."""
    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    for y in (0.0, 2.0):
        (arm,) = parser.AddModelsFromString(fd.load_arm(name).to_urdf(), "urdf")
        plant.WeldFrames(
            plant.world_frame(), plant.GetFrameByName("base", arm), RigidTransform([0, y, 0])
        )
    brick = plant.AddModelInstance("brick")
    plant.AddRigidBody("brick", brick, SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    plant.Finalize()
    return fd.SerialChain.from_plant(plant, f"{name}::tool")


def test_self_motions_of_a_chain_are_the_arms():
    chain, arm = chain_in_a_world("iiwa14"), fd.load_arm("iiwa14")
    q = np.array([0.1, 0.6, 0.2, -1.5, 0.1, 1.0, 0.3])
    motion, expected = (fd.trace_self_motion(x, q, "pose") for x in (chain, arm))
    assert len(motion.components) == len(expected.components)
    for mine, his in zip(motion.components, expected.components):
        assert mine.ends == his.ends
        X = chain.forward_kinematics(mine.q)
        assert np.abs(X - arm.forward_kinematics(q)).max() < 1e-9


@pytest.mark.parametrize("name, task", [("hassantabar3r", "xy"), ("hassantabar4r", "pose")])
def test_redundancy_of_a_chain_is_resolved_by_its_exact_bounds(name, task):
    chain, arm = chain_in_a_world(name), fd.load_arm(name)
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, (4, arm.num_joints))
    poses = arm.forward_kinematics(0.5 * q)
    points = poses[:, :2, 3] if task == "xy" else poses
    found = fd.RedundancyResolver(chain, task=task).resolve(points)
    assert found.success.all()
    X = chain.forward_kinematics(found.q)
    assert np.abs((X - poses)[:, :2, 3]).max() < 1e-9
    assert ((found.q >= chain.lower) & (found.q <= chain.upper)).all()


def test_batches_of_a_chain():
    chain = chain_in_a_world("panda")
    q = np.random.default_rng(1).uniform(chain.lower, chain.upper, (50, 7))
    solution = fd.solve_batch(chain, chain.forward_kinematics(q), task="pose")
    assert solution.success.mean() > 0.95


def test_jacobian_bounds_of_the_direct_law_are_a_chains():
    """In a world with other arms as for the arm alone: the fitted rules give the same step."""
    chain, arm = chain_in_a_world("panda"), fd.load_arm("panda")
    from fikm_drake.kinematics.jacobian_range import jacobian_range

    np.testing.assert_allclose(jacobian_range(chain), arm.jacobian_range(), atol=1e-9)
