"""A joint command that jumps becomes a way that no joint is too fast on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

import fikm_drake as fd
from fikm_drake.control.follower import straight_toward

PERIOD = 0.01


def after(block, context, command, cycles):
    """Outputs after so many periods."""
    block.GetInputPort("commanded_position").FixValue(context, command)
    for _ in range(cycles):
        context.SetDiscreteState(block.EvalUniquePeriodicDiscreteUpdate(context))
    outputs = (block.GetOutputPort(name) for name in ("commanded_position", "limited"))
    return [port.Eval(context).copy() for port in outputs]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), joints=st.integers(1, 9))
def test_a_step_goes_straight_and_no_element_too_far(seed, joints):
    rng = np.random.default_rng(seed)
    position, goal = rng.normal(size=(2, joints))
    most = rng.uniform(0.01, 3.0, joints)
    most[rng.random(joints) < 0.2] = np.inf
    reached = straight_toward(position, goal, most)
    way = reached - position
    assert (np.abs(way) <= most * (1.0 + 1e-12)).all()
    share = way.dot(goal - position) / np.square(goal - position).sum()
    np.testing.assert_allclose(way, share * (goal - position), atol=1e-12)
    if share < 1.0 - 1e-12:
        assert (np.abs(way) / most).max() == pytest.approx(1.0)
    else:
        np.testing.assert_array_equal(reached, goal)


def test_a_jump_takes_the_time_of_the_slowest_joint_and_ends_exactly_there():
    block = fd.SpeedLimiter([1.0, 2.0], period=PERIOD, initial_position=[0.5, 0.0])
    context = block.CreateDefaultContext()
    position, limited = after(
        block, context, [0.0, 0.5], 49
    )  # 0.5 rad at 1 rad/s, 0.25 s for the other
    np.testing.assert_allclose(position, [0.01, 0.49], atol=1e-12)
    assert limited == 1.0
    position, limited = after(block, context, [0.0, 0.5], 2)
    np.testing.assert_array_equal(position, [0.0, 0.5])
    assert limited == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_holds(bad):
    block = fd.SpeedLimiter([1.0, 1.0], period=PERIOD)
    context = block.CreateDefaultContext()
    before, _ = after(block, context, [1.0, 1.0], 3)
    position, limited = after(block, context, [1.0, bad], 3)
    np.testing.assert_array_equal(position, before)
    assert limited == 1.0


def test_behind_a_block_that_jumps_it_starts_at_the_robot():
    """The resolver's first answer is far from where the arm is."""
    arm = fd.load_arm("hassantabar3r")
    robot, speeds = np.array([0.3, 0.2, 0.1]), np.full(3, 2.0)
    builder = DiagramBuilder()
    resolver = builder.AddSystem(fd.RedundancyIk(fd.RedundancyResolver(arm), period=PERIOD))
    limiter = builder.AddSystem(fd.SpeedLimiter(speeds, period=PERIOD))
    point = arm.forward_kinematics(np.array([1.2, 0.6, 0.4]))[:2, 3]
    target = builder.AddSystem(ConstantVectorSource(point))
    measured = builder.AddSystem(ConstantVectorSource(robot))
    builder.Connect(target.get_output_port(), resolver.GetInputPort("desired_position"))
    builder.Connect(measured.get_output_port(), limiter.GetInputPort("estimated_position"))
    builder.Connect(
        resolver.GetOutputPort("commanded_position"), limiter.GetInputPort("commanded_position")
    )
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    output = limiter.GetOutputPort("commanded_position")
    context = limiter.GetMyContextFromRoot(simulator.get_context())
    before = output.Eval(context).copy()
    np.testing.assert_allclose(before, robot, atol=2.0 * PERIOD + 1e-12)
    for k in range(200):
        simulator.AdvanceTo((k + 1) * PERIOD)
        now = output.Eval(context).copy()
        assert (np.abs(now - before) <= PERIOD * speeds * (1.0 + 1e-9)).all()
        before = now
    np.testing.assert_allclose(arm.forward_kinematics(before)[:2, 3], point, atol=1e-9)
    assert limiter.GetOutputPort("limited").Eval(context) == 0.0


@pytest.mark.parametrize(
    ("limits", "arguments", "words"),
    [
        ([1.0, 0.0], {}, "velocity_limits"),
        ([1.0, np.nan], {}, "velocity_limits"),
        ([], {}, "velocity_limits"),
        ([[1.0]], {}, "velocity_limits"),
        ([1.0], {"period": 0.0}, "period"),
        ([1.0], {"initial_position": [0.0, 1.0]}, "initial_position"),
        ([1.0], {"initial_position": [np.nan]}, "initial_position"),
    ],
)
def test_bad_arguments(limits, arguments, words):
    with pytest.raises(ValueError, match=words):
        fd.SpeedLimiter(limits, **{"period": PERIOD, **arguments})


def test_set_positions_checks():
    block = fd.SpeedLimiter([1.0, 1.0], period=PERIOD)
    context = block.CreateDefaultContext()
    block.SetPositions(context, [0.1, -0.1])
    np.testing.assert_array_equal(block.get_output_port(0).Eval(context), [0.1, -0.1])
    with pytest.raises(ValueError, match="2"):
        block.SetPositions(context, [0.1])
