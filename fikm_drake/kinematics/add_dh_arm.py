"""A Denavit-Hartenberg arm in a MultibodyPlant."""

import dataclasses

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from fikm_drake.checks import check_not_negative
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.urdf import urdf


def AddDhArm(plant: MultibodyPlant, arm: DhArm, *, capsules: bool = True) -> ModelInstanceIndex:
    """Add `arm` to `plant` with its base welded to the world; returns its model instance.

    Bodies `base`, `link1` … and `tool`, joints and actuators `joint1` … and `joint1_motor` …, the
    tool's frame `tool`. Its default position is the nearest to zero inside the limits. What is to be
    seen and what collides is registered if the plant has a SceneGraph.

    Args:
        plant: not finalized.
        arm: the arm.
        capsules: False leaves out what collides, for shapes of your own.

    Raises:
        ValueError: the plant is finalized already.
    """
    if plant.is_finalized():
        raise ValueError(f"AddDhArm({arm.name!r}): the plant is finalized already")
    return _add_chain(plant, arm.chain, arm.to_urdf(capsules=capsules))


def MakeDhArmPlant(arm: DhArm, *, time_step: float = 0.0) -> MultibodyPlant:
    """A finalized plant with nothing but `arm`; continuous, for its kinematics, by default.

    Args:
        arm: the arm.
        time_step: of a discrete plant [s]; 0: a continuous one.

    Raises:
        ValueError: the time step is negative or not finite.
    """
    plant = MultibodyPlant(time_step=check_not_negative("time_step", time_step))
    AddDhArm(plant, arm)
    plant.Finalize()
    return plant


def MakeChainPlant(chain: SerialChain) -> MultibodyPlant:
    """A finalized, continuous plant with nothing but a chain, in its base frame; frame `tool`.

    What stands between and beside its joints elsewhere is left out. The joints are `joint1` … `jointn`.
    """
    names = tuple(f"joint{i}" for i in range(1, chain.num_joints + 1))
    chain = dataclasses.replace(chain, name="chain", joint_names=names)
    plant = MultibodyPlant(time_step=0.0)
    _add_chain(plant, chain, urdf(chain, capsules=False))
    plant.Finalize()
    return plant


def _add_chain(plant: MultibodyPlant, chain: SerialChain, text: str) -> ModelInstanceIndex:
    parser = Parser(plant)
    parser.SetAutoRenaming(True)  # two arms of a kind in one plant: panda, panda_1
    (instance,) = parser.AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base", instance))
    for name, default, speed in zip(
        chain.joint_names, chain.default_position, chain.velocity_limits
    ):
        joint = plant.GetJointByName(name, instance)
        joint.set_default_positions([default])
        joint.set_velocity_limits([-speed], [speed])  # URDF cannot say that there is none
    return instance
