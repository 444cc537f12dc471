"""Joints that draw back from their limits: more targets reached, and the law's own step near them."""

import dataclasses

import numpy as np
import pytest
from pydrake.all import ConstantValueSource, DiagramBuilder, RigidTransform, Simulator, Value

import fikm_drake as fd
from fikm_drake.control.joint_limits import JointLimits, StepBox
from fikm_drake.control.limit_retreat import FAR
from fikm_drake.control.make_safe_step import make_safe_step
from fikm_drake.experiments.reach_targets import drive, random_targets
from fikm_drake.kinematics.add_dh_arm import MakeChainPlant
from fikm_drake.kinematics.tasks import make_task

REACHING = {
    task: fd.FuzzyIkConfig(task=task, control_rate=100.0).for_reaching()
    for task in ("position", "pose")
}


def plant_arm(name):
    return fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm(name)))


def reached(name, config, count, seed, start):
    arm = plant_arm(name)
    cycle = fd.ControlCycle(make_task(arm, config.task), config)
    drives = [
        drive(cycle, arm.chain, target, start, 600)
        for target in random_targets(arm.chain, count, seed=seed)
    ]
    assert all(one.honest and one.outside <= 1e-9 for one in drives)
    assert all(one.largest_speed <= 1.0 + 1e-9 for one in drives)
    return sum(one.reached for one in drives)


def corner(name):
    """A start with every other joint at its lower limit."""
    chain = fd.load_arm(name).chain
    start = np.where(np.arange(chain.num_joints) % 2, chain.lower, 0.0)
    return np.clip(start, np.maximum(chain.lower, -3.0), np.minimum(chain.upper, 3.0))


def test_from_a_corner_of_the_limits_more_targets_are_reached():
    """By a seventh, over arms and tasks for which that start is hard (63 of 80, before 50)."""
    mine = other = 0
    for name, task in [(n, "pose") for n in ("panda", "puma560", "jaco", "xarm7")] + [
        ("puma560", "position")
    ]:
        config = REACHING[task]
        plain = dataclasses.replace(config, law=fd.FuzzyMapping.iterated(), limit_retreat=0.0)
        mine += reached(name, config, 16, 5, corner(name))
        other += reached(name, plain, 16, 5, corner(name))
    assert mine >= 1.15 * other


def step_of(arm, task, q, error, retreat):
    safe = make_safe_step(
        arm, REACHING[task].law, limit_margin=0.1, limit_retreat=retreat, num_rows=len(error)
    )
    limits = JointLimits(arm.lower, arm.upper, period=0.01, velocity_limits=100.0)
    return safe.inside(q, make_task(arm, task).jacobian(q), error, StepBox(limits, q))


def test_near_the_target_the_step_is_the_laws_to_the_bit():
    arm = plant_arm("panda")
    rng = np.random.default_rng(0)
    middle = 0.5 * (arm.lower + arm.upper)
    for _ in range(50):
        q = middle + 0.8 * rng.uniform(-0.5, 0.5, 7) * (arm.upper - arm.lower)
        error = rng.normal(size=6)
        error *= 0.5 * FAR * arm.chain.reach / np.linalg.norm(error)
        step, limited = step_of(arm, "pose", q, error, 0.06)
        assert not limited
        assert (step == REACHING["pose"].law.step(make_task(arm, "pose").jacobian(q), error)).all()


def near_a_limit(arm):
    q = 0.5 * (arm.lower + arm.upper)
    q[1], q[3], q[5] = 0.6, -1.2, 0.8
    q[2] = 0.97 * arm.upper[2]
    return q


def test_far_away_a_joint_near_its_limit_is_drawn_to_the_middle_and_the_tool_still_approaches():
    arm = plant_arm("iiwa14")
    q, error = near_a_limit(arm), np.array([0.0, 0.0, 0.2])
    own, drawn = (step_of(arm, "position", q, error, w)[0] for w in (1e-9, 0.06))
    assert drawn[2] < own[2] - 0.01
    assert np.abs(drawn - own).argmax() == 2
    J = make_task(arm, "position").jacobian(q)
    assert error @ J @ drawn > 0.5 * (error @ J @ own) > 0.0


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_arms_of_any_size_do_the_same(scale):
    chain = fd.load_arm("iiwa14").chain
    before, tool = chain.before.copy(), chain.tool.copy()
    before[:, :3, 3] *= scale
    tool[:3, 3] *= scale
    other = dataclasses.replace(chain, before=before, tool=tool)
    arms = [fd.PlantArm(MakeChainPlant(each), "tool") for each in (chain, other)]
    q, error = near_a_limit(arms[0]), np.array([0.05, 0.0, 0.15])
    steps = [
        step_of(arm, "position", q, size * error, 0.06)[0] for arm, size in zip(arms, (1.0, scale))
    ]
    np.testing.assert_allclose(*steps, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("target", [[1.6, 0.2, 0.4], [0.02, 0.0, -1.4]])
def test_out_of_reach_it_comes_to_rest(target):
    arm = plant_arm("iiwa14")
    cycle = fd.ControlCycle(make_task(arm, "position"), REACHING["position"])
    state, goal = cycle.start(np.full(7, 0.3)), np.array(target)
    for _ in range(1500):
        cycle.advance(state, goal, state.command, cycle.tick(state, goal, state.command))
    assert np.abs(state.velocity).max() < 1e-3


def test_diagram_is_the_fused_block():
    arm, q = plant_arm("panda"), np.array([1.0, 0.5, -1.0, -2.0, 0.7, 2.0, -1.0])
    target = RigidTransform(arm.chain.forward_kinematics(q))
    config = dataclasses.replace(REACHING["pose"], control_rate=50.0)
    ends = [
        run(dataclasses.replace(config, fused=fused), arm.default_position, target)
        for fused in (False, True)
    ]
    np.testing.assert_allclose(*ends, atol=1e-9)
    assert np.abs(np.diff(ends[0], axis=0)).max() > 0.01


def run(config, start, target):
    plant = fd.MakeDhArmPlant(fd.load_arm("panda"))
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    source = builder.AddSystem(ConstantValueSource(Value(target)))
    builder.Connect(source.get_output_port(), controller.GetInputPort("desired_pose"))
    simulator = Simulator(builder.Build())
    context = controller.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    controller.SetPositions(context, start)
    commands = []
    for k in range(1, 300):
        simulator.AdvanceTo(k / 50.0)
        commands.append(controller.GetOutputPort("commanded_position").Eval(context).copy())
    return np.array(commands)


def test_bad_options():
    with pytest.raises(ValueError, match="limit_retreat needs a law that minimises something"):
        fd.ControlCycle(
            make_task(plant_arm("panda"), "pose"),
            dataclasses.replace(REACHING["pose"], law=fd.PseudoInverse()),
        )
    with pytest.raises(ValueError, match="limit_retreat"):
        fd.FuzzyIkConfig(limit_retreat=-1.0).validate()
