"""What is near the robot of a run: for the controller that keeps clear, and for the log."""

from collections import Counter
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointIndex
from pydrake.planning import CollisionChecker, RobotDiagramBuilder

from fikm_drake.arrays import Array
from fikm_drake.kinematics.make_collision_checker import MakeCollisionChecker
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.simulation.scenario.environment import Obstacle
from fikm_drake.simulation.scenario.robots import Robot
from fikm_drake.simulation.scenario.schema import Scenario

EVERYWHERE = 1e3
"""Pairs farther apart than this are not looked for; Drake wants a finite distance [m]."""


NO_PAIR = -1
"""The number of no pair."""


class Surroundings:
    """The robot and its obstacles in a world of Drake's collision checker.

    Args:
        robot: the robot.
        obstacles: what stands about it.
        chain: the joints that the controller moves, of a plant with the same robot and obstacles.

    Attributes:
        checker: for controllers that keep clear.
        pairs: names of the pairs of bodies whose distance the joints change, `link - body`.
    """

    def __init__(self, robot: Robot, obstacles: Sequence[Obstacle], chain: SerialChain) -> None:
        def fill(builder: RobotDiagramBuilder) -> None:
            add_world(builder.plant(), robot, obstacles)

        self.checker: CollisionChecker = MakeCollisionChecker(fill)
        self._context = self.checker.MakeStandaloneModelContext()
        plant = self.checker.plant()
        found = _felt_pairs(self.checker, chain)
        self._number = {frozenset(pair): i for i, pair in enumerate(found)}
        names = _names(plant)
        self.pairs = [f"{names[a]} - {names[b]}" for a, b in found]

    @classmethod
    def of(cls, scenario: Scenario, robot: Robot, chain: SerialChain) -> "Surroundings | None":
        """Those of a scenario; None where there is nothing that could come near the robot.

        Raises:
            ValueError: the controller is to keep clear and there is nothing to keep clear of, as where the
                robot has no collision shapes.
        """
        if not scenario.obstacles and not scenario.avoids:
            return None
        found = cls(robot, scenario.obstacles, chain)
        if scenario.avoids and not found.pairs:
            raise ValueError(
                f"nothing to keep clear of: {robot.name} has no collision shapes that its joints move, or "
                "the world has none; with avoid: false obstacles are only shown"
            )
        return found if found.pairs else None

    def nearest(self, position: Array) -> tuple[float, int]:
        """Distance of the nearest pair [m], negative in penetration, and its number in `pairs`.

        Args:
            position: all positions of the plant; where they are not finite the distance is NaN.
        """
        if not np.isfinite(position).all():
            return np.nan, NO_PAIR
        found = self.checker.CalcContextRobotClearance(self._context, position, EVERYWHERE)
        pairs = zip(found.robot_indices(), found.other_indices())
        numbers = [self._number.get(frozenset((int(a), int(b))), NO_PAIR) for a, b in pairs]
        distances = np.where(np.array(numbers) >= 0, found.distances(), np.inf)
        if not np.isfinite(distances).any():
            return np.inf, NO_PAIR
        i = int(distances.argmin())
        return float(distances[i]), numbers[i]


def add_world(plant: MultibodyPlant, robot: Robot, obstacles: Sequence[Obstacle]) -> None:
    """Add a robot and its obstacles to a plant, in the order that all plants of a scenario have.

    Raises:
        ValueError: the robot's file is not valid.
    """
    robot.add(plant)
    for i, obstacle in enumerate(obstacles, start=1):
        obstacle.add(plant, obstacle.name or f"obstacle{i}")


def _felt_pairs(checker: CollisionChecker, chain: SerialChain) -> list[tuple[int, int]]:
    """Pairs of bodies with shapes whose distance the chain's joints can change, the furthest out first."""
    plant = checker.plant()
    assert chain.position_indices is not None
    moved = set(chain.position_indices.tolist())
    inboard = {}
    for i in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(i))
        inboard[int(joint.child_body().index())] = joint

    def movers(body: int) -> frozenset[int]:
        """The chain's joints between the world and a body."""
        found = set()
        while body in inboard:
            joint = inboard[body]
            if joint.num_positions() == 1 and joint.position_start() in moved:
                found.add(joint.position_start())
            body = int(joint.parent_body().index())
        return frozenset(found)

    shaped = [
        i
        for i in range(plant.num_bodies())
        if plant.GetCollisionGeometriesForBody(plant.get_body(BodyIndex(i)))
    ]
    moves = {i: movers(i) for i in shaped}
    return [
        (a, b) if len(moves[a]) >= len(moves[b]) else (b, a)
        for a, b in combinations(shaped, 2)
        if moves[a] != moves[b]
        and not checker.IsCollisionFilteredBetween(BodyIndex(a), BodyIndex(b))
    ]


def _names(plant: MultibodyPlant) -> list[str]:
    """The bodies' names, with the model instance where several bodies have the same."""
    bodies = [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]
    count = Counter(body.name() for body in bodies)
    return [b.name() if count[b.name()] == 1 else b.scoped_name().get_full() for b in bodies]
