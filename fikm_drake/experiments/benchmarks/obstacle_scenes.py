"""Scenes in which obstacles stand between an arm and its target, all from a seed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Box, Shape, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.planning import RobotDiagramBuilder, SceneGraphCollisionChecker

from fikm_drake.arrays import Array
from fikm_drake.control.clearance import Clearance
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.make_collision_checker import MakeCollisionChecker
from fikm_drake.solvers.paths.path_solver import PathSolver

HOME = {
    "iiwa14": (0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0),
    "panda": (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
    "ur5": (0.0, -1.3, 1.6, -1.9, -1.57, 0.0),
}
"""Where an arm starts [rad]."""
KINDS = ("spheres", "boxes", "shelf", "second arm")
TASKS = ("position", "pose")
WAY = (0.3, 0.8)
"""How far the target is from where the tool starts [m]."""
ROOM = (0.03, 0.02)
"""Least clearance of the start, and of the posture that shows that the target can be reached [m]."""
TRIES = 4000
Things = list[tuple[Shape, RigidTransform]]


@dataclass(frozen=True)
class ObstacleScene:
    """One job: from `start` to `target`, past what `populate` puts into the world."""

    arm: str
    kind: str
    task: str
    start: Array
    """(n,) [rad]."""
    target: Array
    """X_WE (4,4)."""
    populate: Callable[[RobotDiagramBuilder], None]

    def checker(self) -> SceneGraphCollisionChecker:
        """Checker of the arm in its world."""
        arm = load_arm(self.arm)
        return MakeCollisionChecker(arm, self.populate, robots=[arm.name])


def obstacle_scenes(arm: str, kind: str, task: str, count: int, seed: int) -> list[ObstacleScene]:
    """Scenes whose start is clear, whose target has a posture that is, with obstacles between them.

    Args:
        arm: of `HOME`.
        kind: of `KINDS`.
        task: of `TASKS`.
        count: how many.
        seed: of the scenes.

    Raises:
        RuntimeError: no scene was found in `TRIES` tries.
    """
    words = [list(HOME).index(arm), KINDS.index(kind), TASKS.index(task)]
    rng = np.random.default_rng([seed, *words])
    scenes: list[ObstacleScene] = []
    for _ in range(TRIES):
        if len(scenes) == count:
            return scenes
        scene = _try(load_arm(arm), arm, kind, task, rng)
        if scene is not None:
            scenes.append(scene)
    if len(scenes) < count:
        raise RuntimeError(f"found {len(scenes)} of {count} scenes: {arm}, {kind}, {task}")
    return scenes


def _try(
    arm: DhArm, name: str, kind: str, task: str, rng: np.random.Generator
) -> ObstacleScene | None:
    chain, start = arm.chain, np.array(HOME[name])
    if kind == "shelf":  # some arms are at home where it stands
        start = np.clip(start + rng.normal(0.0, 0.6, len(start)), chain.lower, chain.upper)
    tool = chain.forward_kinematics(start)
    low, high = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
    posture = rng.uniform(low, high)
    target = chain.forward_kinematics(posture)
    if kind == "shelf":
        target = _in_shelf(rng)
    way = float(np.linalg.norm(target[:3, 3] - tool[:3, 3]))
    if not WAY[0] < way < WAY[1] or target[2, 3] < 0.1 or np.linalg.norm(target[:2, 3]) < 0.25:
        return None
    populate = _populate(arm, kind, tool[:3, 3], target[:3, 3], rng)
    scene = ObstacleScene(name, kind, task, start, target, populate)
    guard = Clearance(scene.checker(), period=0.01)
    if not guard.distance(start) > ROOM[0]:
        return None
    if kind == "shelf":
        starts = rng.uniform(low, high, (40, arm.num_joints))
        aim = target if task == "pose" else target[:3, 3]
        found = PathSolver(chain, 0.3, 1e-6).search(aim, starts)
        return scene if any(guard.distance(q) > ROOM[1] for q in found) else None
    return scene if guard.distance(posture) > ROOM[1] else None


def _populate(
    arm: DhArm, kind: str, tool: Array, target: Array, rng: np.random.Generator
) -> Callable[[RobotDiagramBuilder], None]:
    if kind == "second arm":
        return _second_arm(arm, tool, target, rng)
    things: Things = []
    if kind == "spheres":
        middle = 0.5 * (tool + target) + rng.normal(0.0, 0.02, 3)
        things.append((Sphere(rng.uniform(0.06, 0.12)), RigidTransform(middle)))
        for _ in range(2):
            place = rng.uniform([-0.7, -0.7, 0.1], [0.7, 0.7, 0.9])
            things.append((Sphere(rng.uniform(0.05, 0.1)), RigidTransform(place)))
    elif kind == "boxes":
        middle = 0.5 * (tool + target) + rng.normal(0.0, 0.02, 3)
        for place in (middle, rng.uniform([-0.7, -0.7, 0.1], [0.7, 0.7, 0.9])):
            sides = rng.uniform(0.08, 0.22, 3)
            turn = RollPitchYaw(rng.uniform(-0.5, 0.5, 3))
            things.append((Box(*sides), RigidTransform(turn, place)))
    else:
        things = _shelf()
    return lambda robot: _add(robot.plant(), things)


def _add(plant: MultibodyPlant, things: Things) -> None:
    friction = CoulombFriction()
    for i, (shape, X) in enumerate(things):
        plant.RegisterCollisionGeometry(plant.world_body(), X, shape, f"thing{i}", friction)


def _shelf() -> Things:
    """Three boards and two sides, open toward the arm."""
    boards = [(Box(0.3, 0.9, 0.02), RigidTransform([0.65, 0.0, z])) for z in (0.15, 0.5, 0.85)]
    sides = [(Box(0.3, 0.02, 0.72), RigidTransform([0.65, y, 0.5])) for y in (-0.46, 0.46)]
    return [*boards, *sides]


def _in_shelf(rng: np.random.Generator) -> Array:
    """A pose between two boards that points into the shelf."""
    place = rng.uniform([0.52, -0.32, 0.24], [0.62, 0.32, 0.41])
    place[2] += rng.choice([0.0, 0.35])
    turn = RollPitchYaw(rng.uniform(-3.0, 3.0), np.pi / 2 + rng.uniform(-0.2, 0.2), 0.0)
    return RigidTransform(turn, place).GetAsMatrix4()


def _second_arm(
    arm: DhArm, tool: Array, target: Array, rng: np.random.Generator
) -> Callable[[RobotDiagramBuilder], None]:
    """The same arm once more, on the far side of the way, in some posture."""
    posture = rng.uniform(0.6 * np.maximum(arm.lower, -2.0), 0.6 * np.minimum(arm.upper, 2.0))
    middle = 0.5 * (tool + target)
    out = middle[:2] / max(float(np.linalg.norm(middle[:2])), 1e-9)
    X = RigidTransform(
        RollPitchYaw(0.0, 0.0, rng.uniform(-3.0, 3.0)), [*(middle[:2] + 0.12 * out), 0.0]
    )

    def populate(robot: RobotDiagramBuilder) -> None:
        plant = robot.plant()
        parser = Parser(plant)
        parser.SetAutoRenaming(True)
        (instance,) = parser.AddModelsFromString(arm.to_urdf(), "urdf")
        base = plant.GetFrameByName("base", instance)
        plant.WeldFrames(plant.world_frame(), base, X)
        for joint, q in zip(arm.chain.joint_names, posture):
            plant.GetJointByName(joint, instance).set_default_positions([q])

    return populate
