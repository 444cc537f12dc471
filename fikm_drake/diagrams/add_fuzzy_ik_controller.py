"""Factories of the fuzzy IK controller."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.fuzzy_ik_controller import FuzzyIkController
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.laws import LawLike
from fikm_drake.systems.fused_fuzzy_ik import FusedFuzzyIk


def MakeFuzzyIkController(
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: LawLike | None = None,
    task: TaskKinematics | None = None,
) -> FuzzyIkController | FusedFuzzyIk:
    """A fuzzy IK controller for `plant`: a Diagram, or one LeafSystem if `config.fused`.

    Args:
        plant: a finalized plant with the arm; it is not copied and must live as long.
        config: by default `FuzzyIkConfig()`.
        law: another law than the config's, such as a plain function (J, dr) to a joint step.
        task: another task than the config's, an object such as `PoseTask(PlantArm(plant, "tool"))`.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import fikm_drake as fd
        >>> plant = fd.MakeDhArmPlant(fd.load_arm("planar4"))
        >>> fd.MakeFuzzyIkController(plant, law=lambda J, dr: J.T @ dr).num_input_ports()
        2
    """
    config = config or FuzzyIkConfig()
    config.validate()
    controller = FusedFuzzyIk if config.fused else FuzzyIkController
    return controller(plant, config=config, law=law, task=task)


def AddFuzzyIkController(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: LawLike | None = None,
    task: TaskKinematics | None = None,
    name: str = "fuzzy_ik_controller",
) -> FuzzyIkController | FusedFuzzyIk:
    """Add a fuzzy IK controller for `plant` to `builder` and return it.

    See `FuzzyIkController` for its ports and `MakeFuzzyIkController` for the arguments and errors.
    """
    controller = MakeFuzzyIkController(plant, config=config, law=law, task=task)
    return builder.AddNamedSystem(name, controller)
