"""The restart search that sees: postures and ways are clear."""

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction

import fikm_drake as fd
from fikm_drake.control.clear_way import CHECKS, GROWTHS, ClearWay
from fikm_drake.control.joint_trees import GOAL, START, JointTrees
from fikm_drake.control.restart_search import AGAIN
from fikm_drake.experiments.benchmarks.obstacle_scenes import obstacle_scenes

ARM = fd.load_arm("planar2")


def way(*shapes, pace=0.02):
    def populate(robot):
        plant = robot.plant()
        for i, (shape, position) in enumerate(shapes):
            X = RigidTransform(position)
            plant.RegisterCollisionGeometry(
                plant.world_body(), X, shape, f"s{i}", CoulombFriction()
            )

    checker = fd.MakeCollisionChecker(ARM, populate)
    guard = Counting(checker, period=0.01)
    low, high = np.maximum(ARM.lower, -np.pi), np.minimum(ARM.upper, np.pi)
    return ClearWay(guard, pace=pace, lower=low, upper=high), guard


class Counting(fd.Clearance):
    """A clearance that counts the postures that are looked at."""

    looks = 0

    def room(self, q, others=None, **options):
        self.looks += 1
        return super().room(q, others, **options)


def look(finder, q, *postures):
    """Look for a way to the postures, one after the other, and to the last again and again."""
    memory, calls = finder.initial_memory(), 0
    for posture in [*postures, *postures[-1:] * AGAIN]:
        found = None
        while found is None:
            found, calls = finder.look(memory, q, posture), calls + 1
        if found or finder.goal(memory) is None:
            break
    return found, memory, calls


def all_clear(guard, legs):
    """As finely as one likes."""
    return all(guard.is_clear(a + t * (b - a)) for a, b in legs for t in np.linspace(0.0, 1.0, 400))


BALL = Sphere(0.12), [1.3, 0.5, 0.0]
BEFORE, BEHIND = np.array([-0.9, 0.1]), np.array([1.8, 0.1])
"""On the two sides of it, stretched nearly."""
WALLS = [(Box(0.05, 1.2, 1.0), [x, 0.8, 0.0]) for x in (0.3, -0.3)]
SHUT_IN = np.array([np.pi / 2, 0.0])
"""Between them."""


def test_a_free_way_is_straight():
    finder, guard = way()
    q, posture = np.array([0.0, 0.5]), np.array([1.0, 0.5])
    found, memory, calls = look(finder, q, posture)
    assert found and finder.via(memory) is None
    np.testing.assert_array_equal(finder.end(memory), posture)
    ((a, b),) = finder.legs(memory, q)
    assert (a == q).all() and (b == posture).all()
    assert guard.looks < 1.0 / 0.02  # nothing is near: fewer than the steps of the motion


def test_near_an_obstacle_a_leg_is_looked_at_as_finely_as_the_motion():
    """The first link is at the safe distance from a box all along: nothing can be left out."""
    finder, guard = way((Box(0.2, 0.02, 1.0), [0.5, -0.2, 0.0]))
    q = np.zeros(2)
    while guard.is_clear(q - [1e-4, 0.0]):
        q[0] -= 1e-4
    guard.looks = 0
    found, _, _ = look(finder, q, q + [0.0, 0.5])
    assert found and guard.looks == 0.5 / 0.02


@pytest.mark.parametrize("pace", [0.002, 0.02, 0.1])
def test_round_an_obstacle_there_are_bends_and_all_of_it_is_clear(pace):
    finder, guard = way(BALL, pace=pace)
    assert guard.is_clear(BEFORE) and guard.is_clear(BEHIND)
    guard.looks = 0
    found, memory, calls = look(finder, BEFORE, BEHIND)
    assert found and guard.looks <= CHECKS * calls
    legs = finder.legs(memory, BEFORE)
    assert len(legs) > 1 and (legs[-1][1] == BEHIND).all()
    if pace < 0.1:  # a coarse pace may step over a corner, as the motion does
        assert all_clear(guard, legs)
    passed = 0
    while finder.via(memory) is not None:
        np.testing.assert_array_equal(finder.via(memory), legs[passed][1])
        finder.pass_via(memory)
        passed += 1
    assert passed == len(legs) - 1


def test_of_several_postures_one_is_enough():
    """To the first there is no way, walls stand about it; what grew for it is used for the next."""
    finder, guard = way(*WALLS)
    assert guard.is_clear(SHUT_IN)
    found, memory, _ = look(finder, np.array([-0.5, 0.5]), SHUT_IN, np.array([-2.5, -0.5]))
    assert found
    np.testing.assert_array_equal(finder.end(memory), [-2.5, -0.5])
    assert all_clear(guard, finder.legs(memory, np.array([-0.5, 0.5])))


def test_a_search_is_the_same_each_time_and_its_memory_is_finite():
    memories = [look(way(BALL)[0], BEFORE, BEHIND)[1] for _ in range(2)]
    np.testing.assert_array_equal(*memories)
    assert np.isfinite(memories[0]).all()


def test_joints_that_stray_while_the_search_goes_on_return_first():
    """The way begins where they are, and all of it is clear."""
    finder, guard = way(BALL)
    memory, q, found = finder.initial_memory(), BEFORE.copy(), None
    while found is None:
        q[1] += 1e-3
        found = finder.look(memory, q, BEHIND) or None
    assert found and all_clear(guard, finder.legs(memory, q))


def test_a_posture_that_is_not_clear_is_given_up_at_once():
    finder, guard = way((Sphere(0.2), [0.0, 1.4, 0.0]))
    found, memory, calls = look(finder, np.zeros(2), np.array([np.pi / 2, 0.1]))
    assert found is False and calls == 1 and guard.looks == 1
    assert finder.goal(memory) is None


def test_shut_in_there_is_no_way_and_the_work_has_an_end():
    """The trees are full in the meantime, and begin anew."""
    finder, guard = way(*WALLS)
    found, memory, calls = look(finder, SHUT_IN, -SHUT_IN)
    assert found is False and guard.looks <= CHECKS * calls < 100 * AGAIN * GROWTHS
    np.testing.assert_array_equal(finder.goal(memory), -SHUT_IN)


def test_trees_that_are_full_begin_anew_from_their_roots():
    trees = JointTrees(np.full(2, -1.0), np.full(2, 1.0))
    memory = np.zeros(1, dtype=trees.fields)[0]
    trees.add(memory, START, np.zeros(2))
    while not trees.full(memory):
        trees.add(memory, GOAL, np.ones(2))
    trees.cut(memory, np.full(2, 0.5))
    assert memory["sizes"].tolist() == [1.0, 1.0]
    np.testing.assert_array_equal(trees.way(memory, (0, 0)), [[0.0, 0.0], [0.5, 0.5]])


def test_what_a_hand_holds_counts_in_how_far_a_posture_is_free():
    """A bar across the tool sweeps far when only the last joint turns, which alone moves next to nothing."""
    arm = fd.load_arm("iiwa14")
    checker = fd.MakeCollisionChecker(arm)
    guard = fd.Clearance(checker, period=0.01)
    alone = guard.reach()
    body = checker.plant().GetBodyByName("tool")
    checker.AddCollisionShapeToBody("bar", body, Box(0.5, 0.02, 0.02), RigidTransform([0, 0, 0.1]))
    assert alone[-1] < 0.1 and guard.reach()[-1] >= 0.25
    assert (guard.reach() >= alone).all()
    checker.RemoveAllAddedCollisionShapes()
    np.testing.assert_array_equal(guard.reach(), alone)


@pytest.mark.parametrize("seed", [3, 4])
def test_room_bounds_what_a_motion_can_use_up(seed):
    """By no more than the joints' reach times their motion: what a leg leaves out is clear."""
    arm = fd.load_arm("panda")
    scene = obstacle_scenes("panda", "shelf", "pose", 1, seed)[0]
    guard = fd.Clearance(scene.checker(), period=0.01)
    rng, reach = np.random.default_rng(seed), guard.reach()
    for _ in range(200):
        q = rng.uniform(arm.lower, arm.upper)
        step = rng.normal(0.0, 0.05, arm.num_joints)
        assert guard.room(q + step) >= guard.room(q) - np.abs(step).dot(reach) - 1e-9


@pytest.mark.parametrize("fused", [False, True])
def test_the_controller_searches_and_drives_a_clear_way(fused):
    """Before the flat side of a box the law is stuck; the search finds its way round, clear all along."""
    arm = fd.load_arm("iiwa14")
    home = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
    tool = arm.forward_kinematics(home)[:3, 3]
    target = tool + [-0.1, -0.45, 0.05]

    def populate(robot):
        plant, X = robot.plant(), RigidTransform(0.5 * (tool + target))
        shape = Box(0.25, 0.1, 0.3)
        plant.RegisterCollisionGeometry(plant.world_body(), X, shape, "box", CoulombFriction())

    checker = fd.MakeCollisionChecker(arm, populate)
    config = fd.FuzzyIkConfig(
        law=fd.FuzzyMapping(iterations=3), control_rate=50.0, fused=fused, restart_search=True
    )
    plant = fd.MakeDhArmPlant(arm)
    controller = fd.MakeFuzzyIkController(plant, config=config, collision_checker=checker)
    context = controller.CreateDefaultContext()
    controller.SetPositions(context, home)
    controller.get_input_port(0).FixValue(context, target)
    guard, seen = fd.Clearance(checker, period=0.02), set()
    for _ in range(500):
        seen.add(int(controller.GetOutputPort("status").Eval(context)[0]))
        context.SetDiscreteState(controller.EvalUniquePeriodicDiscreteUpdate(context))
        q = controller.GetOutputPort("commanded_position").Eval(context)
        assert guard.distance(q) >= guard.config.safe_distance - 1e-3
        if fd.ControllerStatus.CONVERGED in seen:
            break
    assert fd.ControllerStatus.CONVERGED in seen
    assert np.linalg.norm(arm.forward_kinematics(q)[:3, 3] - target) < 1e-3
