"""The controller: ports, configuration, and what its runs do, as a Diagram and as one block."""

import re
import threading
from dataclasses import replace

import numpy as np
import pytest
import yaml
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    DiscreteTimeDelay,
    FirstOrderLowPassFilter,
    LogVectorOutput,
    TrajectorySource,
)
from pydrake.trajectories import PiecewisePolynomial

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

PERIOD = 0.02
OUTPUTS = {
    "commanded_position": 7,
    "commanded_velocity": 7,
    "joint_step": 7,
    "task_error": 3,
    "gain": 1,
    "oscillating": 1,
    "status": 1,
}
Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
TARGET = np.array([0.5, -0.45, 0.3])


def config_of(**changes):
    return fd.FuzzyIkConfig(**changes)


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


# Ports and configuration.


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("task", ["position", "xz", "y"])
def test_ports(plant, ports, fused, measured, task):
    config = config_of(fused=fused, measured_position=measured, task=task)
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    m = {"position": 3, "xz": 2, "y": 1}[task]
    inputs = {"desired_position": m} | ({"estimated_position": 7} if measured else {})
    assert ports(controller) == (inputs, OUTPUTS | {"task_error": m})
    assert controller.get_name() == "fuzzy_ik_controller"
    assert isinstance(controller, fd.FusedFuzzyIk if fused else fd.FuzzyIkController)


@pytest.mark.parametrize("measured", [False, True])
def test_direct_feedthrough_is_that_of_the_blocks(plant, fused, measured):
    """The command comes from the state, so any loop may be closed around the controller."""
    controller = fd.MakeFuzzyIkController(
        plant, config=config_of(fused=fused, measured_position=measured)
    )
    for i in range(controller.num_input_ports()):
        through = {
            name
            for j, name in enumerate(OUTPUTS)
            if controller.HasDirectFeedthrough(i, j)
        }
        assert through == {"joint_step", "task_error", "gain", "status"}


def test_the_docstring_begins_with_the_ports(plant, ports):
    for fused, cls in ((False, fd.FuzzyIkController), (True, fd.FusedFuzzyIk)):
        config = config_of(fused=fused, measured_position=True)
        inputs, outputs = ports(fd.MakeFuzzyIkController(plant, config=config))
        block = re.search(r"\.\. pydrake_system::\n\n((?: {8}.*\n)+)", cls.__doc__)
        assert yaml.safe_load(block.group(1)) == {
            "name": cls.__name__,
            "input_ports": list(inputs),
            "output_ports": list(outputs),
        }
    for name in [*inputs, *outputs]:
        assert f"**{name}**" in fd.FuzzyIkController.__doc__


def test_every_public_system_describes_its_ports():
    """The others are in tests/systems."""
    from pydrake.systems.framework import System

    public = [getattr(fd, name) for name in fd.__all__]
    systems = [x for x in public if isinstance(x, type) and issubclass(x, System)]
    assert len(systems) == 9
    for cls in systems:
        assert ".. pydrake_system::" in cls.__doc__


@pytest.mark.parametrize(
    "config",
    [
        fd.FuzzyIkConfig(),
        fd.FuzzyIkConfig(method="direct", frame="arm7::tool", task="xy", control_rate=1000.0),
        fd.FuzzyIkConfig(fused=True, measured_position=True, error_limit=np.inf, tolerance=1e-4),
        fd.FuzzyIkConfig(gain_smoothing=0.0, error_smoothing=0.1, zero_threshold=0.0),
        fd.FuzzyIkConfig(
            supervisor=fd.GainSupervisorConfig(
                12, [0.1, 0.5, 1.0], [1.0, 2.0, 3.0], [0.0, 0.1, 0.2], 3, 1e-9, 0.5
            )
        ),
    ],
)
def test_config_survives_yaml(config, plant):
    text = yaml_dump_typed(config)
    assert yaml_load_typed(schema=fd.FuzzyIkConfig, data=text) == config
    # All fields are written, so that a file tells what there is to set.
    assert len(yaml.safe_load(text)) == len(vars(config))
    fd.MakeFuzzyIkController(plant, config=config)


def test_partial_yaml_keeps_the_defaults():
    data = "{task: xy, error_limit: .inf, supervisor: {window: 12, gains: [1, 2, 3]}}"
    expected = fd.FuzzyIkConfig(
        task="xy",
        error_limit=np.inf,
        supervisor=fd.GainSupervisorConfig(window=12, gains=[1.0, 2.0, 3.0]),
    )
    assert yaml_load_typed(schema=fd.FuzzyIkConfig, data=data) == expected
    base = fd.FuzzyIkConfig(control_rate=100.0, supervisor=fd.GainSupervisorConfig(window=7))
    loaded = yaml_load_typed(schema=fd.FuzzyIkConfig, data="{task: y}", defaults=base)
    assert loaded == replace(base, task="y")


def test_two_configs_share_nothing():
    one, other = fd.FuzzyIkConfig(), fd.FuzzyIkConfig()
    one.supervisor.gains[0] = 9.0
    assert other.supervisor.gains[0] == 1.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"method": "fuzzy"}, ["method", "fuzzy", "indirect", "direct"]),
        ({"task": "pose"}, ["task", "pose", "position", "xy"]),
        ({"frame": "hand"}, ["frame", "hand", "tool", "link7"]),
        ({"frame": "hand", "method": "direct"}, ["frame", "hand", "tool", "link7"]),
        ({"control_rate": 0.0}, ["control_rate", "0.0", "positive"]),
        ({"control_rate": -50.0}, ["control_rate", "-50.0", "positive"]),
        ({"control_rate": np.nan}, ["control_rate", "nan"]),
        ({"control_rate": np.inf}, ["control_rate", "inf"]),
        ({"error_limit": 0.0}, ["error_limit", "0.0", "positive"]),
        ({"error_limit": np.nan}, ["error_limit", "nan"]),
        ({"tolerance": -1.0}, ["tolerance", "-1.0", "positive"]),
        ({"gain_smoothing": 1.0}, ["gain_smoothing", "1.0", "[0, 1)"]),
        ({"error_smoothing": -0.1}, ["error_smoothing", "-0.1", "[0, 1)"]),
        ({"error_smoothing": np.nan}, ["error_smoothing", "nan"]),
        ({"zero_threshold": 2.0}, ["zero_threshold", "2.0", "[0, 1)"]),
        ({"supervisor": fd.GainSupervisorConfig(window=0)}, ["window", "0"]),
        (
            {"supervisor": fd.GainSupervisorConfig(error_breakpoints=[0.0, 0.0, 1.0])},
            ["error_breakpoints", "0.0, 0.0"],
        ),
    ],
)
def test_errors_name_the_bad_value_and_the_valid_ones(plant, fused, changes, words):
    with pytest.raises(ValueError) as error:
        fd.MakeFuzzyIkController(plant, config=config_of(fused=fused, **changes))
    for word in words:
        assert word in str(error.value)


def test_set_positions(plant, fused):
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config_of(fused=fused))
    builder.ExportInput(controller.get_input_port())
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    own = controller.GetMyMutableContextFromRoot(root)
    controller.SetPositions(own, Q0)
    np.testing.assert_array_equal(controller.GetOutputPort("commanded_position").Eval(own), Q0)
    for wrong in (Q0[:6], np.append(Q0, 0.0), np.full(7, np.nan)):
        with pytest.raises(ValueError, match="joint position"):
            controller.SetPositions(own, wrong)
    with pytest.raises(RuntimeError):
        controller.SetPositions(root, Q0)
    np.testing.assert_array_equal(controller.GetOutputPort("commanded_position").Eval(own), Q0)


def test_positions_outside_the_limits_are_refused(plant_with, fused):
    plant = plant_with("panda")
    controller = fd.MakeFuzzyIkController(plant, config=config_of(fused=fused))
    with pytest.raises(ValueError, match="joint position 4"):
        controller.SetPositions(controller.CreateDefaultContext(), np.zeros(7))


def test_the_default_start_is_the_plant_s(plant_with, fused):
    """Inside the limits, whatever the plant's defaults are."""
    plant = plant_with("panda")
    controller = fd.MakeFuzzyIkController(plant, config=config_of(fused=fused))
    start = controller.GetOutputPort("commanded_position").Eval(controller.CreateDefaultContext())
    np.testing.assert_array_equal(start, fd.load_arm("panda").default_position)


# Runs.


def naive_controller(arm, config, start, desired, rows):
    """Equations 27-34, section 2.7 and figure 1 in a plain loop; K_0 = 1, d_0 = 0."""
    coordinates = [row - 3 for row in rows]
    q, K_applied, d = np.array(start), 1.0, np.zeros(len(rows))
    errors, steps, qs, gains, dthetas = [], [], [], [], []
    for target in desired:
        e = target - arm.forward_kinematics(q)[coordinates, 3]
        size = np.sqrt((e**2).sum())
        if size > config.error_limit:  # ours, not the paper's
            e, size = e * config.error_limit / size, config.error_limit
        errors.append(size)
        last = errors[-10:]
        relative = size / np.mean(last) if len(last) == 10 else 1.0
        signs = np.sign(np.array(steps[-10:]))
        changes = (np.diff(signs, axis=0) != 0).sum(axis=0).max() if len(steps) > 1 else 0
        table = [0.1, 0.4, 0.03] if changes >= 4 else [1.0, 2.6, 0.8]
        K = np.interp(relative, [0.0, 1.0, 2.0], table)
        K_applied = K / 3 + 2 / 3 * K_applied
        d = K_applied * e / 3 + 2 / 3 * d
        J = arm.jacobian(q)[rows]
        r, c = np.abs(J).sum(axis=1), np.abs(J).sum(axis=0)
        dtheta = (J * (d / r)[:, None]).sum(axis=0) / c
        q = q + dtheta
        for series, value in ((steps, dtheta), (qs, q), (gains, K), (dthetas, dtheta)):
            series.append(value)
    return np.array(qs), np.array(dthetas), np.array(gains)


@pytest.mark.parametrize("name", ["table6_10s", "table6_5s", "table6_2s"])
def test_simulated_run_equals_a_plain_loop(name, scenario_inputs, fused):
    arm, config, start, desired = scenario_inputs(name, fused=fused)
    q, dtheta, gain = naive_controller(arm, config, start, desired, [3, 4, 5])
    log = fd.simulate(replace(fd.load_scenario(name), config=config))
    assert len(log.q) == len(q)
    np.testing.assert_allclose(log.q, q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(log.joint_step, dtheta, rtol=0, atol=1e-9)
    np.testing.assert_allclose(log.gain, gain, rtol=0, atol=1e-6)


FUSED_RUNS = [
    ("table6_10s", {}),
    ("table6_5s", {}),
    ("table6_2s", {}),
    ("table6_2s", {"method": "direct"}),
    ("large_step_2", {}),
    ("large_step_4", {}),
    ("panda_square", {}),
    ("panda_square", {"measured_position": True}),
]


def assert_equal_series(first, second, tolerance=1e-12):
    """Measured: equal to the last bit. The gain is a function of a ratio of errors, so where they
    are 1e-6 m a last bit more or less shows in it a million times larger.
    """
    for name in first:
        atol = 1e3 * tolerance if name == "gain" else tolerance
        np.testing.assert_allclose(first[name], second[name], rtol=0, atol=atol, err_msg=name)


@pytest.mark.parametrize("lost", [False, True], ids=["", "with-nan"])
@pytest.mark.parametrize(("name", "changes"), FUSED_RUNS)
def test_fused_equals_the_diagram(name, changes, lost, plant_with, scenario_inputs, run):
    arm, config, start, desired = scenario_inputs(name, **changes)
    if lost:
        desired[20:26] = np.nan
        desired[35, 0] = np.inf
    plant = plant_with(arm)

    def late(k, commanded):  # a measurement that lags and fails for a while
        measured = 0.98 * commanded + 0.02 * start
        return np.full(7, np.nan) if lost and 60 <= k < 65 else measured

    measure = late if config.measured_position else None
    runs = [
        run(plant, replace(config, fused=fused), start, desired, measure)
        for fused in (False, True)
    ]
    assert_equal_series(*runs)
    assert np.isfinite(np.concatenate([v.ravel() for v in runs[0].values()])).all()


def test_fused_equals_the_diagram_at_joint_limits(plant_with, run):
    arm = fd.load_arm("panda")
    start = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    angle = np.linspace(0, 2 * np.pi, 600)[:, None]
    desired = np.array([0.2, 0.0, 0.5]) + 0.9 * np.hstack([np.cos(angle), np.sin(angle), 0 * angle])
    runs = [
        run(plant_with("panda"), config_of(fused=fused), start, desired) for fused in (False, True)
    ]
    assert_equal_series(*runs)
    q = runs[0]["commanded_position"]
    assert (runs[0]["status"] == Status.LIMITED).sum() > 20
    assert (q >= arm.lower).all() and (q <= arm.upper).all()
    at_limit = (q == arm.lower) | (q == arm.upper)
    assert at_limit.any()


def test_a_fixed_target_is_reached(plant, run, fused):
    series = run(plant, config_of(fused=fused), Q0, np.tile(TARGET, (300, 1)))
    assert lengths(series["task_error"])[-1] < 1e-6
    assert series["status"][-1] == Status.CONVERGED
    arm = fd.load_arm("arm7")
    np.testing.assert_allclose(arm.forward_kinematics(series["after"])[:3, 3], TARGET, atol=1e-6)


def test_task_error_is_that_of_the_commanded_position(plant, run, fused):
    series = run(plant, config_of(fused=fused), Q0, np.tile(TARGET, (50, 1)))
    tool = fd.load_arm("arm7").forward_kinematics(series["commanded_position"])[:, :3, 3]
    np.testing.assert_allclose(series["task_error"], TARGET - tool, atol=1e-13)


def test_commanded_velocity_is_the_derivative_of_the_command(plant, run, fused):
    config = config_of(fused=fused, control_rate=200.0)
    series = run(plant, config, Q0, np.tile(TARGET, (50, 1)))
    q, v = series["commanded_position"], series["commanded_velocity"]
    np.testing.assert_allclose(v[1:], np.diff(q, axis=0) * 200.0, atol=1e-10)
    np.testing.assert_allclose(np.diff(q, axis=0), series["joint_step"][:-1], atol=1e-14)
    assert not v[0].any()


def stop_and_go(desired, start, stop, bad):
    desired = desired.copy()
    desired[start:stop, 1] = bad
    return desired


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("when", [(0, 5), (3, 4), (8, 40), (100, 130)])
def test_a_lost_target_holds_the_command(plant, run, fused, bad, when):
    start, stop = when
    desired = np.tile(TARGET, (400, 1))
    undisturbed = run(plant, config_of(fused=fused), Q0, desired)
    series = run(plant, config_of(fused=fused), Q0, stop_and_go(desired, start, stop, bad))
    assert all(np.isfinite(values).all() for values in series.values())
    assert (series["status"][start:stop] == Status.INVALID_INPUT).all()
    assert (np.delete(series["status"], np.s_[start:stop]) != Status.INVALID_INPUT).all()
    held = series["commanded_position"][start : stop + 1]
    np.testing.assert_array_equal(held, np.tile(held[0], (len(held), 1)))
    assert not series["commanded_velocity"][start + 1 : stop + 1].any()
    assert not series["task_error"][start:stop].any()
    assert not series["joint_step"][start:stop].any()
    # No jump: nothing larger than the largest step of the run that nothing disturbed.
    largest = np.abs(undisturbed["joint_step"]).max()
    assert np.abs(series["joint_step"][stop:]).max() <= largest * 1.001
    if 0 < start and stop - start > 1:  # and the first step is no larger than the one before
        before, after = (lengths(series["joint_step"][k]) for k in (start - 1, stop))
        assert after <= before * 1.001
    assert lengths(series["task_error"])[-1] < 1e-6


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("joint", [0, 6])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_lost_measurement_holds_the_command(plant, run, fused, bad, joint):
    start, stop = 6, 30

    def measure(k, commanded):
        if start <= k < stop:
            commanded[joint] = bad
        return commanded

    config = config_of(fused=fused, measured_position=True)
    series = run(plant, config, Q0, np.tile(TARGET, (400, 1)), measure)
    assert all(np.isfinite(values).all() for values in series.values())
    assert (series["status"][start:stop] == Status.INVALID_INPUT).all()
    held = series["commanded_position"][start : stop + 1]
    np.testing.assert_array_equal(held, np.tile(held[0], (len(held), 1)))
    assert lengths(series["joint_step"][stop]) <= lengths(series["joint_step"][start - 1])
    assert lengths(series["task_error"])[-1] < 1e-6


def test_a_measurement_beyond_the_frame_counts(plant, run, fused):
    """Joint 7 does not move link4: all the same the status says so and the command holds."""

    def measure(k, commanded):
        if 5 <= k < 9:
            commanded[6] = np.nan
        return commanded

    config = config_of(fused=fused, measured_position=True, frame="link4")
    series = run(plant, config, Q0, np.tile([0.2, -0.2, 0.5], (20, 1)), measure)
    assert (series["status"][5:9] == Status.INVALID_INPUT).all()
    held = series["commanded_position"][5:10]
    np.testing.assert_array_equal(held, np.tile(held[0], (5, 1)))
    assert np.abs(np.diff(series["commanded_position"][9:], axis=0)).max() > 0


def test_an_unconnected_input_is_an_error_and_not_a_guess(plant, fused):
    controller = fd.MakeFuzzyIkController(plant, config=config_of(fused=fused))
    with pytest.raises(RuntimeError):
        controller.GetOutputPort("status").Eval(controller.CreateDefaultContext())


def test_every_status_is_reached(plant_with, scenario_inputs, run, fused):
    seen = {}
    for name in ("large_step_2", "table6_2s"):
        arm, config, start, desired = scenario_inputs(name, fused=fused)
        desired[-3:] = np.nan
        for status in run(plant_with(arm), config, start, desired)["status"].ravel():
            seen.setdefault(Status(int(status)), name)
    start = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
    out_of_reach = np.tile([-0.6, 0.0, 0.1], (300, 1))
    series = run(plant_with("panda"), config_of(fused=fused), start, out_of_reach)
    for status in series["status"].ravel():
        seen.setdefault(Status(int(status)), "panda")
    assert set(seen) == set(Status)


@pytest.mark.parametrize(
    ("name", "target"), [("planar4", (0.0, 2.0)), ("planar2", (3.0, 3.0)), ("planar4", (1e6, 0.0))]
)
def test_an_unreachable_target_is_approached_in_bounded_steps(name, target, plant_with, run, fused):
    """|dθ_j| c_j ≤ Σ|d_i|, and |d| ≤ 2.6 error_limit: no singularity makes a step larger."""
    arm, config = fd.load_arm(name), config_of(fused=fused, task="xy")
    desired = np.tile(target, (450, 1))
    series = run(plant_with(name), config, np.full(arm.num_joints, 0.1), desired)
    assert all(np.isfinite(values).all() for values in series.values())
    columns = np.abs(arm.jacobian(series["commanded_position"])[:, 3:5]).sum(axis=1)
    bound = np.sqrt(2) * 2.6 * config.error_limit
    assert (np.abs(series["joint_step"]) * columns <= bound * (1 + 1e-9)).all()
    away = lengths(series["task_error"])
    nearest = np.hypot(*target) - 1.5
    assert away[-1] < away[0] and away[-1] < nearest + 0.05
    assert Status.CONVERGED not in series["status"]


def in_simulator(plant, config, lag, target, duration, start=Q0):
    """The controller with the command fed back through `lag`, or through nothing; its last error."""
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    source = builder.AddSystem(ConstantVectorSource(target))
    builder.Connect(source.get_output_port(), controller.GetInputPort("desired_position"))
    builder.AddSystem(lag)
    builder.Connect(controller.GetOutputPort("commanded_position"), lag.get_input_port())
    builder.Connect(lag.get_output_port(), controller.GetInputPort("estimated_position"))
    sinks = {
        name: LogVectorOutput(controller.GetOutputPort(name), builder, config.period)
        for name in ("task_error", "status", "commanded_position", "joint_step")
    }
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), start)
    own = lag.GetMyMutableContextFromRoot(root)
    if isinstance(lag, FirstOrderLowPassFilter):
        lag.set_initial_output_value(own, start)
    else:
        delayed = own.get_mutable_discrete_state_vector()
        delayed.SetFromVector(np.tile(start, delayed.size() // len(start)))
    simulator.AdvanceTo(duration)
    return {name: sink.FindLog(root).data().T.copy() for name, sink in sinks.items()}


def largest_gain(delay):
    """Below this K every λ of J C⁻¹ Jᵀ R⁻¹, at most 1, gives a stable loop with so many cycles' delay.

    e is the integral of −λ d, delayed, and d = K e / 3 + 2/3 of the last d (equation 31):
    z^delay (z − 1)(z − 2/3) + λ K z / 3 = 0.
    """

    def stable(gain):
        polynomial = np.zeros(delay + 3)
        polynomial[:3] = 1, -5 / 3, 2 / 3
        polynomial[-2] += gain / 3
        return np.abs(np.roots(polynomial)).max() < 1

    low, high = 0.0, 20.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def test_largest_gain_without_delay_is_that_of_the_paper_s_filter():
    """Stable for 0 < λK < 10, as shared/reference says; one cycle's delay leaves a tenth of it."""
    assert largest_gain(0) == pytest.approx(10.0)
    assert largest_gain(1) == pytest.approx(1.0)
    assert largest_gain(3) < largest_gain(2) < 1.0


def constant_gain(gain):
    return fd.GainSupervisorConfig(gains=[gain] * 3, oscillating_gains=[gain] * 3, initial_gain=gain)


@pytest.mark.parametrize("delay", [1, 2, 3])
def test_converges_on_a_robot_that_is_late(plant, fused, delay):
    gain = 0.8 * largest_gain(delay)
    config = config_of(fused=fused, measured_position=True, supervisor=constant_gain(gain))
    series = in_simulator(plant, config, DiscreteTimeDelay(PERIOD, delay, 7), TARGET, 20.0)
    assert lengths(series["task_error"])[-1] < config.tolerance
    assert series["status"][-1] == Status.CONVERGED
    assert lengths(series["joint_step"])[-50:].max() < 1e-3


def test_converges_on_a_robot_that_follows_with_a_lag(plant, fused):
    """A time constant of one cycle leaves Table I's gains stable."""
    config = config_of(fused=fused, measured_position=True)
    series = in_simulator(plant, config, FirstOrderLowPassFilter(PERIOD, 7), TARGET, 8.0)
    assert lengths(series["task_error"])[-1] < 1e-6
    assert series["status"][-1] == Status.CONVERGED


def test_table_1_is_too_fast_for_a_robot_that_is_late(plant, fused):
    """What `measured_position` warns of; bounded all the same, and never NaN."""
    config = config_of(fused=fused, measured_position=True)
    series = in_simulator(plant, config, DiscreteTimeDelay(PERIOD, 1, 7), TARGET, 8.0)
    assert lengths(series["task_error"])[-100:].max() > 0.1
    assert all(np.isfinite(values).all() for values in series.values())


def test_a_perfect_measurement_changes_nothing(plant, run, fused):
    desired = np.tile(TARGET, (100, 1))
    own = run(plant, config_of(fused=fused), Q0, desired)
    config = config_of(fused=fused, measured_position=True)
    measured = run(plant, config, Q0, desired, lambda k, commanded: commanded)
    assert_equal_series(own, measured, 0.0)


def test_two_controllers_in_one_diagram(plant, plant_with, run, fused):
    """Each does what it does alone, on one plant and on two."""
    config = config_of(fused=fused)
    jobs = [(plant, Q0, TARGET), (plant, -Q0, TARGET - 0.1), (plant_with("iiwa14"), Q0, TARGET)]
    builder = DiagramBuilder()
    controllers, sinks = [], []
    for i, (own_plant, _, target) in enumerate(jobs):
        controller = fd.AddFuzzyIkController(builder, own_plant, config=config, name=f"arm_{i}")
        source = builder.AddSystem(ConstantVectorSource(target))
        builder.Connect(source.get_output_port(), controller.get_input_port(0))
        port = controller.GetOutputPort("commanded_position")
        sinks.append(LogVectorOutput(port, builder, PERIOD))
        controllers.append(controller)
    diagram = builder.Build()
    assert diagram.HasSubsystemNamed("arm_1")
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    for controller, (_, start, _) in zip(controllers, jobs):
        controller.SetPositions(controller.GetMyMutableContextFromRoot(root), start)
    simulator.AdvanceTo(99.5 * PERIOD)
    for sink, (own_plant, start, target) in zip(sinks, jobs):
        alone = run(own_plant, config, start, np.tile(target, (100, 1)))["commanded_position"]
        np.testing.assert_array_equal(sink.FindLog(root).data().T, alone)


@pytest.mark.parametrize("method", ["indirect", "direct"])
def test_a_plant_with_two_arms(plant_with, run, fused, method):
    """Each arm by its own controller; the joints of the other rest."""
    plant = plant_with("arm7", "arm7")
    with pytest.raises(ValueError) as error:
        fd.MakeFuzzyIkController(plant, config=config_of(fused=fused, method=method))
    assert "arm7::tool" in str(error.value) and "arm7_1::tool" in str(error.value)
    desired = np.tile(TARGET, (150, 1))
    alone = run(plant_with("arm7"), config_of(fused=fused), Q0, desired)
    for frame, own, other in (("arm7::tool", 0, 7), ("arm7_1::tool", 7, 0)):
        config = config_of(fused=fused, frame=frame, method=method)
        series = run(plant, config, np.tile(Q0, 2), desired)
        q = series["commanded_position"]
        np.testing.assert_array_equal(q[:, other : other + 7], np.tile(Q0, (150, 1)))
        if method == "indirect":
            expected = alone["commanded_position"]
            np.testing.assert_allclose(q[:, own : own + 7], expected, atol=1e-12)
        assert lengths(series["task_error"])[-1] < 1e-4


def moving_target():
    knots = np.random.default_rng(0).uniform(-0.15, 0.15, (3, 12)) + TARGET[:, None]
    return PiecewisePolynomial.CubicShapePreserving(np.linspace(0, 4, 12), knots, True)


def tracking_simulator(plant, fused):
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config_of(fused=fused))
    source = builder.AddSystem(TrajectorySource(moving_target()))
    builder.Connect(source.get_output_port(), controller.get_input_port(0))
    sinks = [LogVectorOutput(controller.GetOutputPort(n), builder, PERIOD) for n in OUTPUTS]
    simulator = Simulator(builder.Build())

    def run():
        root = simulator.get_mutable_context()
        controller.SetPositions(controller.GetMyMutableContextFromRoot(root), Q0)
        simulator.Initialize()
        simulator.AdvanceTo(4.0)
        return [sink.FindLog(root).data().copy() for sink in sinks]

    return simulator, run


def test_a_reset_run_repeats_itself(plant, fused):
    simulator, run = tracking_simulator(plant, fused)
    system = simulator.get_system()
    first = run()
    context = simulator.get_mutable_context()
    context.SetTime(0.0)
    system.SetDefaultContext(context)
    for sink in (s for s in system.GetSystems() if type(s).__name__.startswith("VectorLogSink")):
        sink.FindMutableLog(context).Clear()
    second = run()
    simulator.reset_context(system.CreateDefaultContext())
    third = run()
    for a, b, c in zip(first, second, third):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(a, c)


def test_simulators_in_threads_give_the_serial_result(plant, fused):
    """One plant, one Diagram a thread: what a sweep does."""
    expected = tracking_simulator(plant, fused)[1]()
    runs, results = [tracking_simulator(plant, fused)[1] for _ in range(3)], [None] * 3

    def work(i):
        results[i] = runs[i]()

    threads = [threading.Thread(target=work, args=(i,)) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        for a, b in zip(expected, result):
            np.testing.assert_array_equal(a, b)


def test_drives_the_plant_it_computes_with(fused):
    """The command as the set point of a simulated arm whose motors follow it."""
    from pydrake.systems.controllers import InverseDynamicsController

    plant = MultibodyPlant(0.0)
    fd.AddDhArm(plant, fd.load_arm("arm7"))
    plant.Finalize()
    builder = DiagramBuilder()
    robot = MultibodyPlant(1e-3)
    fd.AddDhArm(robot, fd.load_arm("arm7"))
    robot.Finalize()
    builder.AddSystem(robot)
    config = config_of(fused=fused, control_rate=100.0)
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    target = builder.AddSystem(ConstantVectorSource(TARGET))
    builder.Connect(target.get_output_port(), controller.get_input_port(0))
    n = np.ones(7)
    torque = builder.AddSystem(InverseDynamicsController(robot, 400 * n, 0 * n, 40 * n, False))
    from pydrake.systems.primitives import Multiplexer

    desired = builder.AddSystem(Multiplexer([7, 7]))
    for i, name in enumerate(("commanded_position", "commanded_velocity")):
        builder.Connect(controller.GetOutputPort(name), desired.get_input_port(i))
    builder.Connect(desired.get_output_port(), torque.get_input_port_desired_state())
    builder.Connect(robot.get_state_output_port(), torque.get_input_port_estimated_state())
    builder.Connect(torque.get_output_port_control(), robot.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), Q0)
    own = robot.GetMyMutableContextFromRoot(root)
    robot.SetPositions(own, Q0)
    simulator.AdvanceTo(2.5)
    tool = robot.GetFrameByName("tool").CalcPoseInWorld(own).translation()
    assert np.linalg.norm(tool - TARGET) < 1e-3
