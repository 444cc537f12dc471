"""Factories of the fuzzy IK controller."""

import dataclasses
from collections.abc import Sequence
from typing import TypeAlias

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, ModelInstanceIndex
from pydrake.planning import CollisionChecker
from pydrake.systems.framework import Context, DiagramBuilder

from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.drakes_ports import DrakesPorts
from fikm_drake.diagrams.fuzzy_ik_controller import FuzzyIkController
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws import LawLike
from fikm_drake.systems.fused_fuzzy_ik import FusedFuzzyIk

Joints: TypeAlias = Sequence[str] | ModelInstanceIndex | None
"""Which joints of a plant move: names, or those of a model instance; None: all that move the tool."""


def MakeFuzzyIkController(
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: LawLike | None = None,
    task: TaskKinematics | None = None,
    collision_checker: CollisionChecker | None = None,
    joints: Joints = None,
    reference_frame: str | Frame | None = None,
    context: Context | None = None,
    ports: str | None = None,
) -> FuzzyIkController | FusedFuzzyIk | DrakesPorts:
    """A fuzzy IK controller for an arm in `plant`: a Diagram, or one LeafSystem if `config.fused`.

    Its n joints are those on the way from `reference_frame` to the tool, in that order; whatever else
    is in the plant, free bodies, a gripper, a second arm, is left alone.

    Args:
        plant: a finalized plant with the arm; it is not copied and must live as long.
        config: by default `FuzzyIkConfig()`.
        law: another law than the config's, such as a plain function (J, dr) to a joint step.
        task: another task than the config's, an object such as `PoseTask(PlantArm(plant, "tool"))`.
        collision_checker: what the arm keeps clear of, such as of `MakeCollisionChecker`; its plant has
            joints of the same names. None: obstacles are not seen.
        joints: which joints on the way to the tool move: names (`instance::name`), or a model instance;
            None: all revolute and prismatic ones that are neither locked in `context` nor fixed by
            equal limits.
        reference_frame: in which targets are, or its name; None: the world. Where other joints
            than the controller's move it, `TargetInFrame` brings targets into the world.
        context: of the plant: where other joints on the way stand, and which are locked; None: the
            default. It is read once: of a joint that is locked later no port tells (the status says
            NOT_FOLLOWING where joints are measured), so make the controller anew.
        ports: `integrator` or `controller`: those of Drake's DifferentialInverseKinematicsIntegrator or
            Controller, see `DrakesPorts`; None: our own.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import fikm_drake as fd
        >>> plant = fd.MakeDhArmPlant(fd.load_arm("planar4"))
        >>> ik = fd.MakeFuzzyIkController(plant, joints=["joint1", "joint3"])
        >>> ik.GetOutputPort("commanded_position").size()
        2
    """
    config = config or FuzzyIkConfig()
    config.validate()
    if ports == "controller":  # its nominal posture comes by that port
        config = dataclasses.replace(config, null_space_motion=True)
    controller = FusedFuzzyIk if config.fused else FuzzyIkController
    whole = as_task(
        plant,
        config.frame,
        task or config.task,
        config.characteristic_length,
        joints=joints,
        reference_frame=reference_frame,
        context=context,
    )
    made = controller(
        plant, config=config, law=law, task=whole, collision_checker=collision_checker
    )
    if ports is None:
        return made
    return DrakesPorts(made, whole.arm, ports=ports, posture_rate=config.posture_rate or 1.0)


def AddFuzzyIkController(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: LawLike | None = None,
    task: TaskKinematics | None = None,
    collision_checker: CollisionChecker | None = None,
    joints: Joints = None,
    reference_frame: str | Frame | None = None,
    context: Context | None = None,
    ports: str | None = None,
    name: str = "fuzzy_ik_controller",
) -> FuzzyIkController | FusedFuzzyIk | DrakesPorts:
    """Add a fuzzy IK controller for an arm in `plant` to `builder` and return it.

    See `FuzzyIkController` for its ports and `MakeFuzzyIkController` for the arguments and errors. Where
    `name` is taken already it is numbered: fuzzy_ik_controller_1.
    """
    controller = MakeFuzzyIkController(
        plant,
        config=config,
        law=law,
        task=task,
        collision_checker=collision_checker,
        joints=joints,
        reference_frame=reference_frame,
        context=context,
        ports=ports,
    )
    return builder.AddNamedSystem(unique_name(builder, name), controller)


def unique_name(builder: DiagramBuilder, name: str) -> str:
    """The name, with a number where a system of the builder has it: Drake ends the process for two."""
    taken = {system.get_name() for system in builder.GetSystems()}
    names = [name, *(f"{name}_{i}" for i in range(1, len(taken) + 1))]
    return next(candidate for candidate in names if candidate not in taken)
