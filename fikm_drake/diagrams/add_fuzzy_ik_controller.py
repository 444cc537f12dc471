"""Factories of the fuzzy IK controller."""

from typing import Any

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from fikm_drake.diagrams.fuzzy_ik_controller import FuzzyIkController
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.law import Law
from fikm_drake.systems.fused_fuzzy_ik import FusedFuzzyIk
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.systems.tool_pose_kinematics import make_tool_kinematics


def MakeFuzzyIkController(
    plant: MultibodyPlant, *, config: FuzzyIkConfig | None = None, law: Law | None = None
) -> FuzzyIkController | FusedFuzzyIk:
    """A fuzzy IK controller for `plant`: a Diagram, or one LeafSystem if `config.fused`.

    Args:
        plant: a finalized plant with the arm; it is not copied and must live as long.
        config: by default `FuzzyIkConfig()`.
        law: another law in place of the fuzzy mapping that the config describes, such as
            `DampedLeastSquares()`.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    config = config or FuzzyIkConfig()
    controller = FusedFuzzyIk if config.fused else FuzzyIkController
    return controller(plant, law=law or _make_law(plant, config), config=config)


def AddFuzzyIkController(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: Law | None = None,
    name: str = "fuzzy_ik_controller",
) -> FuzzyIkController | FusedFuzzyIk:
    """Add a fuzzy IK controller for `plant` to `builder` and return it.

    See `FuzzyIkController` for its ports and `MakeFuzzyIkController` for the arguments and errors.
    """
    return builder.AddNamedSystem(name, MakeFuzzyIkController(plant, config=config, law=law))


def _make_law(plant: MultibodyPlant, config: FuzzyIkConfig) -> FuzzyMapping:
    bounds: dict[str, Any] = {}
    if config.method == "direct":
        kinematics = make_tool_kinematics(plant, config.frame, config.make_task())
        bounds["jacobian_range"] = kinematics.jacobian_range()
    return FuzzyMapping(
        config.method,
        iterations=config.iterations,
        damping=config.damping,
        row_floor=config.row_floor,
        column_floor=config.column_floor,
        zero_threshold=config.zero_threshold,
        **bounds,
    )
