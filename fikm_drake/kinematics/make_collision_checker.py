"""Drake's collision checker from what people have, in one line."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias

from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import LoadModelDirectives, ProcessModelDirectives
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointIndex
from pydrake.planning import (
    CollisionCheckerParams,
    RobotDiagramBuilder,
    SceneGraphCollisionChecker,
)

from fikm_drake.checks import check_not_negative, check_positive_finite
from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.copy_plant import copy_plant
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.robot_file import AddRobot
from fikm_drake.resources import ConfigureParser

DIRECTIVES = (".yaml", ".yml")

Populate: TypeAlias = Callable[[RobotDiagramBuilder], None]
Source: TypeAlias = str | Path | DhArm | MultibodyPlant | Populate


def MakeCollisionChecker(
    *sources: Source,
    scene_graph: SceneGraph | None = None,
    robots: Sequence[str] = (),
    robot_padding: float = 0.0,
    self_padding: float = 0.0,
    edge_step_size: float = 0.05,
) -> SceneGraphCollisionChecker:
    """A collision checker for `AddFuzzyIkController(…, collision_checker=…)` and for Drake's own blocks.

        checker = fd.MakeCollisionChecker("cell.dmd.yaml")                     # model directives
        checker = fd.MakeCollisionChecker(plant, scene_graph=scene_graph)      # a plant and its scene
        checker = fd.MakeCollisionChecker(fd.load_arm("iiwa14"), "table.sdf")  # an arm, capsules, a table

    Args:
        sources: one after the other: paths of model directives (.yaml) or models, as of `AddRobot`;
            a `DhArm`, welded to the world, whose shapes are capsules along its links; a function that fills a
            RobotDiagramBuilder; or, alone, a finalized plant, whose joints and collision shapes
            are copied: what is changed of it later is not seen.
        scene_graph: with a plant, the one that it is registered with.
        robots: names of the model instances that count as the robot: only their bodies are checked, against
            each other and against all else; empty: all that have joints of one position.
        robot_padding: between the robot and all else [m]; what is left of a distance counts. The capsules
            of a `DhArm` are thin (3 % of its reach): pad them to the thickness of yours.
        self_padding: between bodies of the robot [m].
        edge_step_size: of Drake's own checks of edges [rad or m].

    Raises:
        ValueError: naming the bad value and the valid ones; a model that Drake cannot read.
        FileNotFoundError: there is no such file.
    """
    if not sources:
        raise ValueError("MakeCollisionChecker needs a file, an arm, a plant or a function")
    robot = RobotDiagramBuilder(time_step=0.0)
    plant = robot.plant()
    ConfigureParser(robot.parser())
    for source in sources:
        _add(robot, source, scene_graph, alone=len(sources) == 1)
    if not plant.is_finalized():
        plant.Finalize()
    names = [plant.GetModelInstanceName(i) for i in _instances(plant)]
    for name in robots:
        if name not in names:
            raise ValueError(
                f"robots must be of the model instances with joints {names}, got {name!r}"
            )
    chosen = [i for i, name in zip(_instances(plant), names) if name in (robots or names)]
    if not chosen:
        raise ValueError("the collision checker's models have no joint that a robot could move")
    return SceneGraphCollisionChecker(
        CollisionCheckerParams(
            model=robot.Build(),
            robot_model_instances=chosen,
            edge_step_size=check_positive_finite("edge_step_size", edge_step_size, "rad or m"),
            env_collision_padding=check_not_negative("robot_padding", robot_padding),
            self_collision_padding=check_not_negative("self_padding", self_padding),
        )
    )


def _add(
    robot: RobotDiagramBuilder, source: Source, scene_graph: SceneGraph | None, *, alone: bool
) -> None:
    plant = robot.plant()
    if isinstance(source, DhArm):
        AddDhArm(plant, source)
    elif isinstance(source, MultibodyPlant):
        if scene_graph is None or not alone:
            raise ValueError("a plant needs its scene_graph, and must be the only source")
        copy_plant(source, scene_graph, plant, robot.scene_graph())
    elif isinstance(source, str | Path):
        path = Path(source)
        if path.suffix not in DIRECTIVES:
            AddRobot(plant, path)
            return
        if not path.is_file():
            raise FileNotFoundError(f"no model directives {path}")
        try:
            ProcessModelDirectives(LoadModelDirectives(str(path)), robot.parser())
        except (RuntimeError, ValueError, SystemExit) as error:
            raise ValueError(f"{path} is no model directives: {error}") from error
    elif callable(source):
        source(robot)
    else:
        raise ValueError(
            "a source must be the path of a file, a DhArm, a MultibodyPlant or a function of a "
            f"RobotDiagramBuilder, got {source!r}"
        )


def _instances(plant: MultibodyPlant) -> list:
    """Model instances that have a joint of one position."""
    joints = [plant.get_joint(JointIndex(i)) for i in plant.GetJointIndices()]
    return sorted(
        {joint.model_instance() for joint in joints if joint.num_positions() == 1}, key=int
    )
