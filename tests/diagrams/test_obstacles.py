"""Obstacles and null-space motion in the controller, as a Diagram and fused."""

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.systems.framework import LeafSystem

import fikm_drake as fd

ARM = fd.load_arm("iiwa14")
HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
TOOL = ARM.forward_kinematics(HOME)[:3, 3]
SAFE = fd.ClearanceConfig().safe_distance


@pytest.fixture(scope="module")
def plant():
    return fd.MakeDhArmPlant(ARM)


def config(fused, **changes):
    return fd.FuzzyIkConfig(
        **{"law": fd.FuzzyMapping(iterations=3), "control_rate": 100.0, "fused": fused} | changes
    )


def drive(controller, target, cycles, each=None, start=HOME):
    """Commands (N,n) and statuses (N,); `each(k, context)` is called before a cycle."""
    context = controller.CreateDefaultContext()
    controller.SetPositions(context, start)
    controller.get_input_port(0).FixValue(context, target)
    commands, statuses = [], []
    for k in range(cycles):
        if each:
            each(k, context)
        statuses.append(int(controller.GetOutputPort("status").Eval(context)[0]))
        after = controller.EvalUniquePeriodicDiscreteUpdate(context)
        context.SetDiscreteState(after)
        commands.append(controller.GetOutputPort("commanded_position").Eval(context).copy())
    return np.array(commands), np.array(statuses), context


WALL = Box(0.05, 1.0, 1.0), TOOL + [0.2, 0.0, 0.0]


def test_diagram_and_fused_are_one(plant, checker_with):
    target = TOOL + [0.3, -0.1, 0.0]
    seen = checker_with(WALL, (Sphere(0.1), TOOL + [0.1, -0.3, 0.0]))
    runs = []
    for fused in (False, True):
        controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=seen)
        q, status, context = drive(controller, target, 80)
        ports = [
            controller.GetOutputPort(x).Eval(context) for x in ("clearance", "blocking_bodies")
        ]
        runs.append((q, status, *ports, controller.BlockingPair(context)))
    for one, two in zip(*runs):
        np.testing.assert_array_equal(one, two)


def test_before_a_wall_it_is_blocked_rests_and_names_the_wall(plant, fused, checker_with):
    seen = checker_with(WALL)
    controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=seen)
    q, status, context = drive(controller, TOOL + [0.4, 0.0, 0.0], 400)
    guard = fd.Clearance(seen, period=0.01)
    assert min(guard.distance(x) for x in q) >= SAFE - 1e-3
    assert np.abs(np.diff(q[-20:], axis=0)).max() <= 1e-5
    assert fd.ControllerStatus.BLOCKED in status
    assert status[-1] in (fd.ControllerStatus.BLOCKED, fd.ControllerStatus.CALMED)
    assert controller.GetOutputPort("clearance").Eval(context)[0] == pytest.approx(SAFE, abs=2e-3)
    one, two = controller.BlockingPair(context)
    assert one.startswith("iiwa14::") and two == "WorldModelInstance::world"


def test_behind_a_ball_it_gets_there(plant, fused, checker_with):
    target = TOOL + [-0.1, -0.45, 0.05]
    seen = checker_with((Sphere(0.1), 0.5 * (TOOL + target)))
    controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=seen)
    q, status, _ = drive(controller, target, 300)
    guard = fd.Clearance(seen, period=0.01)
    assert min(guard.distance(x) for x in q) >= SAFE - 1e-3
    assert status[-1] == fd.ControllerStatus.CONVERGED


def test_what_comes_is_evaded_and_lost_obstacles_hold_the_arm(plant, fused, checker_with):
    seen = checker_with((Sphere(0.08), [0.0, 0.0, 0.0]), floating=True)
    controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=seen)
    guard, clear = fd.Clearance(seen, period=0.01), []

    def each(k, context):
        position = np.r_[1.0, 0.0, 0.0, 0.0, TOOL + [0.0, 0.35 - 0.2 * min(k, 150) / 100.0, 0.0]]
        if k >= 170:
            position[4] = np.nan
        controller.GetInputPort("obstacle_position").FixValue(context, position)
        q = controller.GetOutputPort("commanded_position").Eval(context)
        clear.append(guard.distance(q, position if k < 170 else None))

    q, _, _ = drive(controller, TOOL, 190, each)
    assert min(clear[:170]) >= SAFE - 1e-3
    assert np.linalg.norm(q[160] - HOME) > 0.02  # it had to go
    assert (q[171:] == q[171]).all() and np.isfinite(q).all()


@pytest.mark.parametrize("acceleration", [[], [30.0]])
def test_what_comes_while_the_target_is_lost_is_evaded_alike(plant, checker_with, acceleration):
    """The arm holds, at first in mid-motion, then gives way; the Diagram and the fused block are one."""
    seen = checker_with((Sphere(0.08), [0.0, 0.0, 0.0]), floating=True)
    guard = fd.Clearance(seen, period=0.01)

    def run(fused):
        chosen, clear, outputs = config(fused, acceleration_limits=acceleration), [], []
        controller = fd.MakeFuzzyIkController(plant, config=chosen, collision_checker=seen)

        def each(k, context):
            ball = TOOL + [0.0, 0.35 - 0.2 * min(k, 150) / 100.0, 0.05]
            position = np.r_[1.0, 0.0, 0.0, 0.0, ball]
            controller.GetInputPort("obstacle_position").FixValue(context, position)
            if k == 10:
                controller.get_input_port(0).FixValue(context, np.full(3, np.nan))
            q = controller.GetOutputPort("commanded_position").Eval(context)
            clear.append(guard.distance(q, position))
            outputs.append(controller.GetOutputPort("clearance").Eval(context).copy())

        q, status, _ = drive(controller, TOOL + [0.0, 0.0, 0.1], 190, each)
        return q, status, np.array(outputs), min(clear)

    runs = [run(fused) for fused in (False, True)]
    for one, two in zip(*runs):
        np.testing.assert_array_equal(one, two)
    q, status, _, nearest = runs[0]
    assert (status[10:] == fd.ControllerStatus.INVALID_INPUT).all()
    assert nearest >= SAFE - 2e-3
    assert np.linalg.norm(q[-1] - q[60]) > 0.02  # it had to go


def test_without_a_checker_nothing_changes(plant, fused, checker_with):
    target = TOOL + [-0.1, -0.25, 0.05]
    free, _, context = drive(fd.MakeFuzzyIkController(plant, config=config(fused)), target, 60)
    far = checker_with((Sphere(0.1), [3.0, 0.0, 0.0]))
    controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=far)
    q, _, _ = drive(controller, target, 60)
    np.testing.assert_allclose(q, free, atol=1e-12)
    assert fd.MakeFuzzyIkController(plant, config=config(fused)).BlockingPair(context) == ("", "")


def test_a_checker_of_another_plant_is_refused(plant, fused):
    other = fd.MakeCollisionChecker(fd.load_arm("panda"))
    with pytest.raises(ValueError, match="iiwa14::joint1.*panda::joint1"):
        fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=other)
    bad = config(fused, clearance=fd.ClearanceConfig(safe_distance=-1.0))
    with pytest.raises(ValueError, match="safe_distance"):
        fd.MakeFuzzyIkController(plant, config=bad)
    with pytest.raises(ValueError, match="MakeCollisionChecker"):
        fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker="cell.dmd.yaml")


def test_from_a_start_in_penetration_it_backs_out_and_goes_on(plant, fused, checker_with):
    seen = checker_with((Sphere(0.1), TOOL + [0.0, 0.08, 0.0]))
    guard = fd.Clearance(seen, period=0.01)
    assert guard.distance(HOME) < -0.01
    controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=seen)
    target = TOOL + [0.0, -0.3, 0.0]
    q, status, _ = drive(controller, target, 300)
    distances = np.array([guard.distance(x) for x in q])
    assert np.isfinite(q).all() and (np.diff(distances[distances < SAFE]) > 0.0).all()
    assert distances[-1] >= SAFE and status[-1] == fd.ControllerStatus.CONVERGED


def test_a_target_that_is_not_finite_holds_the_arm_among_obstacles(plant, fused, checker_with):
    seen = checker_with(WALL)
    controller = fd.MakeFuzzyIkController(plant, config=config(fused), collision_checker=seen)
    q, status, _ = drive(controller, np.array([0.5, np.nan, 0.5]), 10)
    assert (q == HOME).all()
    assert (status == fd.ControllerStatus.INVALID_INPUT).all()


def test_null_space_motion_leaves_the_task_alone(plant, fused):
    """The tool stays within 1e-6 of the joint motion in each cycle, while the joints turn."""
    controller = fd.MakeFuzzyIkController(plant, config=config(fused, null_space_motion=True))
    rng = np.random.default_rng(0)
    wishes = np.outer(np.cos(np.arange(50) / 15.0), rng.normal(size=7))

    def each(k, context):
        controller.GetInputPort("null_space_motion").FixValue(context, wishes[k])

    q, _, _ = drive(controller, TOOL, 50, each)
    path = np.vstack([HOME, q])
    assert np.abs(q[-1] - HOME).max() > 0.02
    J = ARM.jacobian(HOME)[3:]
    step = q[0] - HOME
    assert np.linalg.norm(J @ step) <= 1e-6 * np.linalg.norm(step)
    tool = ARM.forward_kinematics(path)[:, :3, 3]
    assert np.linalg.norm(tool - TOOL, axis=1).max() < 1e-3  # curvature, which the law takes back


def test_without_a_target_null_space_motion_moves_nothing(plant, fused):
    """Found by `fikm-drake fuzz`: the Diagram went on."""
    controller = fd.MakeFuzzyIkController(plant, config=config(fused, null_space_motion=True))
    context = controller.CreateDefaultContext()
    controller.SetPositions(context, HOME)
    controller.get_input_port(0).FixValue(context, [np.nan, 0.0, 0.5])
    controller.GetInputPort("null_space_motion").FixValue(context, np.full(7, 0.3))
    assert not controller.GetOutputPort("joint_step").Eval(context).any()
    assert controller.GetOutputPort("status").Eval(context)[0] == fd.ControllerStatus.INVALID_INPUT


def test_null_space_motion_not_finite_is_none(plant, fused):
    controller = fd.MakeFuzzyIkController(plant, config=config(fused, null_space_motion=True))

    def each(k, context):
        controller.GetInputPort("null_space_motion").FixValue(context, np.full(7, np.nan))

    q, _, _ = drive(controller, TOOL, 5, each)
    np.testing.assert_allclose(q, np.tile(HOME, (5, 1)), atol=1e-9)


class Push(LeafSystem):
    """A differential IK that goes straight on, whatever is there."""

    def __init__(self, velocity):
        super().__init__()
        self.DeclareVectorInputPort("position", 7)
        self.DeclareVectorOutputPort(
            "commanded_velocity", 7, lambda _, output: output.set_value(velocity)
        )


def test_behind_somebody_elses_command_it_keeps_clear_too(plant, checker_with):
    seen = checker_with(WALL)
    push = np.linalg.pinv(ARM.jacobian(HOME)[3:]) @ [0.2, 0.0, 0.0]
    system = fd.SupervisedDifferentialIk(Push(push), plant, period=0.01, collision_checker=seen)
    context = system.CreateDefaultContext()
    system.SetPositions(context, HOME)
    guard, pairs = fd.Clearance(seen, period=0.01), set()
    for _ in range(250):
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
        q = system.GetOutputPort("commanded_position").Eval(context)
        assert guard.distance(q) >= SAFE - 1e-3
        pairs.add(system.BlockingPair(context))
    assert np.abs(q - HOME).max() > 0.05
    assert ("iiwa14::link6", "WorldModelInstance::world") in pairs
    with pytest.raises(ValueError, match="panda::joint1"):
        other = fd.MakeCollisionChecker(fd.load_arm("panda"))
        fd.SupervisedDifferentialIk(Push(push), plant, period=0.01, collision_checker=other)
