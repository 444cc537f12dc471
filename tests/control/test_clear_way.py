"""The restart search that sees: postures and ways are clear."""

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction

import fikm_drake as fd
from fikm_drake.control.clear_way import CHECKS, ClearWay

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
    guard = fd.Clearance(checker, period=0.01)
    low, high = np.maximum(ARM.lower, -np.pi), np.minimum(ARM.upper, np.pi)
    starts = low + (high - low) * np.random.default_rng(0).random((40, 2))
    return ClearWay(guard, pace=pace, lower=low, upper=high, starts=starts), guard


def look(finder, q, posture):
    memory, calls, found = finder.initial_memory(), 0, None
    while found is None:
        found, calls = finder.look(memory, q, posture), calls + 1
    return found, memory, calls


def test_a_free_way_is_straight_and_looked_at_as_finely_as_the_motion():
    finder, _ = way()
    q, posture = np.array([0.0, 0.5]), np.array([1.0, 0.5])
    found, memory, calls = look(finder, q, posture)
    assert found and finder.via(memory) is None
    assert calls >= 1.0 / 0.02 / CHECKS
    assert finder.length(memory, q, posture) == pytest.approx(1.0)


def test_round_an_obstacle_there_is_a_bend_and_all_of_it_is_clear():
    finder, guard = way((Sphere(0.12), [1.3, 0.5, 0.0]))
    q, posture = np.array([-0.9, 0.1]), np.array([1.8, 0.1])
    assert guard.is_clear(q) and guard.is_clear(posture)
    found, memory, _ = look(finder, q, posture)
    assert found
    via = finder.via(memory)
    for a, b in ((q, via), (via, posture)):
        for t in np.linspace(0.0, 1.0, 200):
            assert guard.is_clear(a + t * (b - a))
    finder.pass_via(memory)
    assert finder.via(memory) is None


def test_a_posture_that_is_not_clear_is_given_up_at_once():
    finder, _ = way((Sphere(0.2), [0.0, 1.4, 0.0]))
    found, _, calls = look(finder, np.zeros(2), np.array([np.pi / 2, 0.1]))
    assert found is False and calls == 1


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
