"""The block that follows a target with the LabVolt 5250."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

import fikm_drake as fd
from fikm_drake.solvers.labvolt import LabVoltStatus

TARGET = [0.3, 0.2, 0.5]
BAD = {
    "NaN": ([np.nan, 0.0, 0.5], LabVoltStatus.INVALID_INPUT),
    "inf": ([0.3, -np.inf, 0.5], LabVoltStatus.INVALID_INPUT),
    "far": ([1e9, 0.0, 0.5], LabVoltStatus.UNREACHABLE),
    "huge": ([1e300, 1e300, 0.5], LabVoltStatus.UNREACHABLE),
    "near the base": ([0.05, 0.0, 0.384], LabVoltStatus.UNREACHABLE),
}


@pytest.fixture(scope="module")
def arm():
    return fd.load_arm("labvolt5250")


@pytest.fixture
def block(drive):
    return drive(fd.LabVoltIk(period=0.01))


def circle(steps, turns=1.0):
    """A smooth path round the base."""
    s = np.linspace(0.0, 2.0 * np.pi * turns, steps)
    r, z = 0.45 + 0.05 * np.cos(2.0 * s), 0.4 + 0.1 * np.sin(s)
    return np.column_stack([r * np.cos(s), r * np.sin(s), z])


def test_ports_and_feedthrough(ports):
    block = fd.LabVoltIk(period=0.01)
    inputs, outputs = ports(block)
    assert inputs == {"desired_position": 3}
    assert outputs == {"commanded_position": 4, "angles": 4, "status": 1}
    assert all(block.HasDirectFeedthrough(0, i) for i in range(3))


def test_position_puts_the_tool_on_the_target(block, arm):
    out = block.cycle(desired_position=TARGET)
    tool = arm.forward_kinematics(out["commanded_position"])[:3, 3]
    np.testing.assert_allclose(tool, TARGET, rtol=0, atol=1e-9)
    assert out["status"] == LabVoltStatus.SOLVED
    np.testing.assert_allclose(out["angles"][0], out["commanded_position"][0])
    np.testing.assert_allclose(out["angles"][1:], np.cumsum(out["commanded_position"][1:]))


def test_smooth_path_without_a_jump(block, arm):
    """No joint moves by more than 5° in a step of some 5 mm; a fuzzy start each cycle does jump."""
    path = circle(600)
    outs = [block.cycle(desired_position=target) for target in path]
    q = np.array([out["commanded_position"] for out in outs])
    tools = arm.forward_kinematics(q)[:, :3, 3]
    np.testing.assert_allclose(tools, path, rtol=0, atol=1e-9)
    assert all(out["status"] == LabVoltStatus.SOLVED for out in outs)
    assert np.rad2deg(np.abs(np.diff(q, axis=0))).max() < 5.0


def test_fuzzy_start_each_cycle_jumps(drive):
    block = drive(fd.LabVoltIk(period=0.01, warm_start=False))
    q = np.array(
        [block.cycle(desired_position=target)["commanded_position"] for target in circle(600)]
    )
    assert np.rad2deg(np.abs(np.diff(q, axis=0))).max() > 5.0


def test_base_turns_on_past_half_a_turn(block):
    yaw = np.array(
        [block.cycle(desired_position=t)["commanded_position"][0] for t in circle(500, turns=1.4)]
    )
    assert np.abs(np.diff(yaw)).max() < 0.1 and yaw[-1] > 2.0 * np.pi


@pytest.mark.parametrize("name", BAD)
def test_bad_target_holds_the_last_good_command(name, block):
    target, status = BAD[name]
    good = block.cycle(desired_position=TARGET)
    for _ in range(3):
        out = block.cycle(desired_position=target)
        np.testing.assert_array_equal(out["commanded_position"], good["commanded_position"])
        assert out["status"] == status
    assert block.cycle(desired_position=TARGET)["status"] == LabVoltStatus.SOLVED


@pytest.mark.parametrize("name", BAD)
def test_bad_target_at_first_holds_the_initial_position(name, drive, arm):
    target, status = BAD[name]
    start = [0.5, 0.4, -0.3, 0.2]
    for initial, held in ((None, arm.default_position), (start, start)):
        out = drive(fd.LabVoltIk(period=0.1, initial_position=initial)).cycle(
            desired_position=target
        )
        np.testing.assert_array_equal(out["commanded_position"], held)
        assert out["status"] == status


def test_target_over_the_base_leaves_the_yaw(block):
    block.cycle(desired_position=[0.0, 0.3, 0.9])
    out = block.cycle(desired_position=[0.0, 0.0, 1.0])
    if out["status"] != LabVoltStatus.UNREACHABLE:
        assert out["commanded_position"][0] == pytest.approx(np.pi / 2)


def test_a_far_target_falls_back_and_the_wish_is_the_last_posture(drive, arm):
    """From the edge of the reach, elbow at its limit, to the other side: some warm starts fail."""
    rng = np.random.default_rng(0)
    plane = fd.labvolt.random_targets(400, seed=21)
    plane = plane[plane[:, 0] > 0.05]
    block, statuses = drive(fd.LabVoltIk(period=0.01)), set()
    for x, y in plane:
        target = [x + 0.003, 0.0, y + 0.384]
        block.system.SetPositions(block.context, [0.0, *rng.uniform(arm.lower[1:], arm.upper[1:])])
        out = block.cycle(desired_position=target)
        statuses.add(int(out["status"][0]))
        tool = arm.forward_kinematics(out["commanded_position"])[:3, 3]
        np.testing.assert_allclose(tool, target, rtol=0, atol=1e-9)
    assert statuses == {LabVoltStatus.SOLVED, LabVoltStatus.FELL_BACK}


def test_outputs_depend_on_the_context_only(drive):
    """Two contexts of one block, used in turns."""
    system = fd.LabVoltIk(period=0.01)
    first, second = drive(system), drive(system)
    alone = drive(fd.LabVoltIk(period=0.01))
    path = circle(40)
    for a, b in zip(path, path[::-1]):
        out = first.cycle(desired_position=a)
        second.cycle(desired_position=b)
        np.testing.assert_array_equal(
            out["commanded_position"], alone.cycle(desired_position=a)["commanded_position"]
        )


def test_set_positions_is_where_the_next_solution_starts(block, arm):
    """Near by, where the elbow is down."""
    q = np.array([0.2, -0.2, 1.2, 0.1])
    block.system.SetPositions(block.context, q)
    np.testing.assert_array_equal(block.state()[0][:4], q)
    target = arm.forward_kinematics(q + [0.0, 0.01, 0.01, 0.0])[:3, 3]
    np.testing.assert_allclose(
        block.cycle(desired_position=target)["commanded_position"], q, rtol=0, atol=0.1
    )
    with pytest.raises(ValueError, match=r"joint position\[1\] must be from"):
        block.system.SetPositions(block.context, [0.0, 3.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="4 finite numbers"):
        block.system.SetPositions(block.context, [0.0, np.nan, 0.0, 0.0])
    other = fd.LabVoltIk(period=0.01).CreateDefaultContext()
    with pytest.raises(RuntimeError):
        block.system.SetPositions(other, q)


def test_in_a_simulator_with_snopt():
    builder = DiagramBuilder()
    ik = builder.AddSystem(fd.LabVoltIk(period=0.02, solver="snopt"))
    path = PiecewisePolynomial.CubicShapePreserving([0.0, 0.5, 1.0], circle(3, 0.3).T)
    source = builder.AddSystem(TrajectorySource(path))
    builder.Connect(source.get_output_port(), ik.GetInputPort("desired_position"))
    log = LogVectorOutput(ik.GetOutputPort("status"), builder, publish_period=0.02)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.0)
    assert (log.FindLog(simulator.get_context()).data() == LabVoltStatus.SOLVED).all()


def test_a_constant_target_holds_still():
    builder = DiagramBuilder()
    ik = builder.AddSystem(fd.LabVoltIk(period=0.1))
    source = builder.AddSystem(ConstantVectorSource(TARGET))
    builder.Connect(source.get_output_port(), ik.GetInputPort("desired_position"))
    log = LogVectorOutput(ik.GetOutputPort("commanded_position"), builder, publish_period=0.1)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(2.0)
    q = log.FindLog(simulator.get_context()).data()
    assert np.abs(q - q[:, :1]).max() < 1e-8


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": 0.0}, "period must be positive"),
        ({"period": np.nan}, "period must be positive"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
        ({"tolerance": np.inf}, "tolerance must be"),
        ({"solver": "ipopt"}, "solver must be one of"),
        ({"initial_position": [0.0] * 3}, "4 finite numbers"),
        ({"initial_position": [0.0, 0.0, 9.0, 0.0]}, r"joint position\[2\] must be from"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(ValueError, match=message):
        fd.LabVoltIk(**{"period": 0.01, **options})


def test_approach_port_keeps_the_hand_down_and_near_the_last_posture(drive, ports, arm):
    block = fd.LabVoltIk(period=0.02, approach=True)
    assert ports(block)[0] == {"desired_position": 3, "approach": 1}
    block, q = drive(block), []
    for x in np.linspace(0.35, 0.45, 20):
        out = block.cycle(desired_position=[x, 0.1, 0.1], approach=[-np.pi / 2])
        assert out["status"] == LabVoltStatus.SOLVED
        assert out["angles"][3] == pytest.approx(-np.pi / 2, abs=1e-12)
        tool = arm.forward_kinematics(out["commanded_position"])[:3, 3]
        np.testing.assert_allclose(tool, [x, 0.1, 0.1], rtol=0, atol=1e-12)
        q.append(out["commanded_position"])
    assert np.abs(np.diff(q, axis=0)).max() < 0.05
    turned = block.cycle(desired_position=[0.7, 0.1, 0.4], approach=[-np.pi / 2])
    assert turned["status"] == LabVoltStatus.TURNED
    tool = arm.forward_kinematics(turned["commanded_position"])[:3, 3]
    np.testing.assert_allclose(tool, [0.7, 0.1, 0.4], rtol=0, atol=1e-9)
    held = block.cycle(desired_position=[0.7, 0.1, 0.4], approach=[np.nan])
    assert held["status"] == LabVoltStatus.INVALID_INPUT
    np.testing.assert_array_equal(held["commanded_position"], turned["commanded_position"])
