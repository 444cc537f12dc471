"""What holds for every block: ports, feedthrough, bad inputs, purity."""

import copy
import itertools

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, SpatialInertia

import fikm_drake as fd
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

PERIOD = 0.02

MAKERS = {
    "TaskError": lambda plant: fd.TaskError(plant),
    "GainSupervisor": lambda plant: fd.GainSupervisor(3, 7, period=PERIOD, error_limit=0.2),
    "VariableGain": lambda plant: fd.VariableGain(3, limit=0.2),
    "LowPassFilter": lambda plant: fd.LowPassFilter(3, period=PERIOD),
    "DifferentialIk": lambda plant: fd.DifferentialIk(
        plant, law=FuzzyMapping(iterations=3), guarded=True, damped=True, posture_gain=0.02
    ),
    "RestartPlanner": lambda plant: fd.RestartPlanner(plant, period=PERIOD),
    "JointIntegrator": lambda plant: fd.JointIntegrator(
        -2 * np.ones(7), 2 * np.ones(7), period=PERIOD, initial_position=0.1 * np.ones(7)
    ),
    "StatusMonitor": lambda plant: fd.StatusMonitor(3, restart_search=True),
    "CommandSupervisor": lambda plant: fd.CommandSupervisor(7, period=PERIOD),
    "JointReference": lambda plant: fd.JointReference(
        7,
        period=PERIOD,
        time_step=PERIOD / 20,
        velocity_limits=np.full(7, np.inf),
        acceleration_limits=20.0,
    ),
    "LastFinite": lambda plant: fd.LastFinite(3, period=PERIOD),
    "FusedFuzzyIk": lambda plant: fd.FusedFuzzyIk(
        plant,
        law=FuzzyMapping(iterations=3),
        config=fd.FuzzyIkConfig(
            fused=True, measured_position=True, restart_search=True, posture_rate=1.0
        ),
    ),
}

PORTS = {
    "TaskError": (
        {"desired_position": 3, "position": 7},
        {"task_error": 3, "valid": 1},
    ),
    "GainSupervisor": (
        {"task_error": 3, "joint_step": 7, "target": 3, "deviation": 7},
        {
            "gain": 1,
            "oscillating": 1,
            "oscillating_joint": 1,
            "calm": 1,
            "calmed": 1,
            "damping": 1,
            "valid": 1,
        },
    ),
    "VariableGain": ({"gain": 1, "task_error": 3}, {"amplified_error": 3, "valid": 1}),
    "LowPassFilter": ({"u0": 3}, {"y0": 3}),
    "DifferentialIk": (
        {"task_error": 3, "position": 7, "guard": 3, "damping": 1},
        {"joint_step": 7, "valid": 1},
    ),
    "RestartPlanner": (
        {"desired_position": 3, "position": 7, "law_step": 7},
        {"joint_step": 7, "restart_search": 1, "valid": 1},
    ),
    "JointIntegrator": (
        {"joint_step": 7, "estimated_position": 7},
        {
            "position": 7,
            "velocity": 7,
            "valid": 1,
            "following": 1,
            "limited": 1,
            "deviation": 7,
        },
    ),
    "StatusMonitor": (
        {
            "task_error": 3,
            "valid": 1,
            "limited": 1,
            "oscillating": 1,
            "calmed": 1,
            "following": 1,
            "restart_search": 1,
        },
        {"status": 1},
    ),
    "CommandSupervisor": (
        {"commanded_velocity": 7},
        {"calmed_velocity": 7, "gain": 7, "oscillating": 7, "valid": 1},
    ),
    "JointReference": (
        {"commanded_position": 7, "commanded_velocity": 7, "estimated_position": 7},
        {"desired_state": 14},
    ),
    "LastFinite": ({"signal": 3}, {"finite_signal": 3, "valid": 1}),
    "FusedFuzzyIk": (
        {"desired_position": 3, "estimated_position": 7},
        {
            "commanded_position": 7,
            "commanded_velocity": 7,
            "joint_step": 7,
            "task_error": 3,
            "gain": 1,
            "oscillating": 1,
            "oscillating_joint": 1,
            "status": 1,
        },
    ),
}

# Outputs that do not feed through from an input; all others do.
STATE_ONLY = {
    "GainSupervisor": {(i, "gain") for i in ("joint_step", "target", "deviation")}
    | {
        (i, o)
        for i in ("task_error", "joint_step", "target", "deviation")
        for o in ("oscillating", "oscillating_joint", "calm", "calmed", "damping")
    },
    "RestartPlanner": {(i, "restart_search") for i in ("desired_position", "position", "law_step")},
    "JointIntegrator": {
        *itertools.product(("joint_step", "estimated_position"), ("position", "velocity")),
        ("joint_step", "following"),
        ("estimated_position", "valid"),
        ("estimated_position", "limited"),
        ("joint_step", "deviation"),
    },
    "CommandSupervisor": {
        ("commanded_velocity", "gain"),
        ("commanded_velocity", "oscillating"),
    },
    "JointReference": {
        ("commanded_position", "desired_state"),
        ("commanded_velocity", "desired_state"),
        ("estimated_position", "desired_state"),
    },
    "FusedFuzzyIk": {
        (i, o)
        for i in ("desired_position", "estimated_position")
        for o in ("commanded_position", "commanded_velocity", "oscillating", "oscillating_joint")
    },
}

FLAGS = ("limited", "oscillating", "calmed", "following", "restart_search", "valid")
"""Inputs of which only a threshold counts, or a few numbers."""

# The filter is Drake's; it keeps what is fed to it, as its docstring says.
PYTHON_BLOCKS = [name for name in MAKERS if name != "LowPassFilter"]

GOOD = {
    "desired_position": np.array([0.3, -0.5, 0.5]),
    "position": 0.3 * np.ones(7),
    "estimated_position": 0.3 * np.ones(7),
    "task_error": np.array([0.03, -0.02, 0.01]),
    "joint_step": 0.01 * np.array([1.0, -1, 1, -1, 1, -1, 1]),
    "law_step": 0.01 * np.array([1.0, -1, 1, -1, 1, -1, 1]),
    "gain": np.ones(1),
    "calmed": np.zeros(1),
    "target": np.array([0.3, -0.5, 0.5]),
    "deviation": 0.001 * np.ones(7),
    "following": np.ones(1),
    "damping": 0.1 * np.ones(1),
    "restart_search": np.zeros(1),
    "guard": np.zeros(3),
    "valid": np.ones(1),
    "limited": np.zeros(1),
    "oscillating": np.zeros(1),
    "u0": np.ones(3),
    "signal": np.array([0.1, -0.2, 0.3]),
    "commanded_position": 0.3 * np.ones(7),
    "commanded_velocity": 0.5 * np.array([1.0, -1, 1, -1, 1, -1, 1]),
}


def good(name):
    return {port: GOOD[port] for port in PORTS[name][0]}


def random_inputs(name, rng, cycles):
    """Inputs near the good ones, a little other in every cycle."""
    return [
        {port: value * rng.uniform(0.5, 1.5, value.shape) for port, value in good(name).items()}
        for _ in range(cycles)
    ]


@pytest.fixture(params=MAKERS)
def name(request):
    return request.param


@pytest.fixture
def block(name, plant):
    return MAKERS[name](plant)


def test_ports(name, block, ports):
    assert ports(block) == PORTS[name]


def test_direct_feedthrough(name, block):
    inputs, outputs = (list(ports) for ports in PORTS[name])
    for i, source in enumerate(inputs):
        for j, target in enumerate(outputs):
            expected = (source, target) not in STATE_ONLY.get(name, ())
            assert block.HasDirectFeedthrough(i, j) == expected, (source, target)


def test_feedthrough_is_true_to_what_the_outputs_do(name, block, drive):
    """An output that is said not to feed through does not change with the input."""
    driver = drive(block).feed(**good(name))
    for source, target in STATE_ONLY.get(name, ()):
        before = driver[target]
        driver.feed(**{source: 2 * GOOD[source]})
        np.testing.assert_array_equal(driver[target], before)


def states_are_finite(driver):
    return all(np.isfinite(group).all() for group in driver.state())


@pytest.mark.filterwarnings("error", "ignore:overflow")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("name", PYTHON_BLOCKS, indirect=True)
def test_what_is_not_finite_reaches_no_output_and_no_state(name, block, bad, drive):
    for port, value in good(name).items():
        if (name, port) == ("JointIntegrator", "estimated_position"):
            continue  # it only starts the command, see test_start.py
        for element in (0, len(value) - 1):
            wrong = value.copy()
            wrong[element] = bad
            driver, untouched = drive(block), drive(block)
            for _ in range(3):
                driver.cycle(**good(name))
                untouched.cycle(**good(name))
            for _ in range(12):
                outputs = driver.cycle(**good(name) | {port: wrong})
                for output, result in outputs.items():
                    assert np.isfinite(result).all(), (port, output)
                # A huge gain is a number still, and so is a flag: they have no length.
                if not (bad == 1e200 and port in FLAGS):
                    if "valid" in outputs:
                        assert outputs["valid"] == 0, port
                    if "status" in outputs:
                        assert outputs["status"] == fd.ControllerStatus.INVALID_INPUT, port
                    for held in ("joint_step", "amplified_error", "velocity"):
                        if held in outputs and _ > 0:
                            np.testing.assert_array_equal(outputs[held], 0.0)
                assert states_are_finite(driver)
            after = driver.feed(**good(name)).read()
            if "valid" in after:
                assert after["valid"] == 1
            if "status" in after:
                assert after["status"] != fd.ControllerStatus.INVALID_INPUT
            for held in ("position", "commanded_position"):
                if held in after:
                    np.testing.assert_array_equal(after[held], untouched[held])
            if not driver.state():  # no memory: as if nothing had been
                assert after.keys() == untouched.read().keys()
                for output, result in untouched.read().items():
                    np.testing.assert_array_equal(after[output], result)


def test_two_contexts_of_one_block_do_not_meet(name, block, drive, equal):
    rng = np.random.default_rng(0)
    inputs = [random_inputs(name, rng, 30) for _ in range(2)]
    serial = [
        [driver.cycle(**i) for i in each]
        for driver, each in zip((drive(block), drive(block)), inputs)
    ]
    drivers = drive(block), drive(block)
    interleaved = [[], []]
    for pair in zip(*inputs):
        for driver, results, i in zip(drivers, interleaved, pair):
            results.append(driver.cycle(**i))
    for a, b in zip(serial, interleaved):
        equal(a, b)


def test_a_cloned_context_goes_on_alike(name, block, drive, equal):
    rng = np.random.default_rng(1)
    inputs = random_inputs(name, rng, 40)
    first = drive(block)
    for i in inputs[:20]:
        first.cycle(**i)
    clone = drive(block, first.context.Clone())
    deep = drive(block, copy.deepcopy(first.context))
    expected = [first.cycle(**i) for i in inputs[20:]]
    equal(expected, [clone.cycle(**i) for i in inputs[20:]])
    equal(expected, [deep.cycle(**i) for i in inputs[20:]])


def test_evaluation_leaves_the_state_and_its_order_alone(name, block, drive):
    driver = drive(block).feed(**good(name))
    before = driver.state()
    first = driver.read()
    driver.outputs.reverse()
    second = driver.feed(**good(name)).read()
    for output in first:
        np.testing.assert_array_equal(first[output], second[output])
    for a, b in zip(before, driver.state()):
        np.testing.assert_array_equal(a, b)


def test_threads_give_the_serial_results(name, block, drive, equal, in_threads):
    rng = np.random.default_rng(2)
    inputs = [random_inputs(name, rng, 60) for _ in range(4)]
    serial = [
        [driver.cycle(**i) for i in each]
        for driver, each in zip([drive(block) for _ in inputs], inputs)
    ]
    drivers = [drive(block) for _ in inputs]

    def work(k):
        return [drivers[k].cycle(**i) for i in inputs[k]]

    results = in_threads(work, len(inputs))
    for a, b in zip(serial, results):
        equal(a, b)


@pytest.mark.parametrize("period", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize(
    "make",
    [
        lambda plant, period: fd.GainSupervisor(3, 7, period=period),
        lambda plant, period: fd.LowPassFilter(3, period=period),
        lambda plant, period: fd.JointIntegrator([-1], [1], period=period, initial_position=[0]),
        lambda plant, period: fd.RestartPlanner(plant, period=period),
    ],
)
def test_a_period_must_be_positive_and_finite(make, period, plant):
    with pytest.raises(ValueError, match="period") as error:
        make(plant, period)
    assert repr(period) in str(error.value)


@pytest.mark.parametrize("size", [0, -1, 2.5, "3"])
@pytest.mark.parametrize(
    ("argument", "make"),
    [
        ("num_rows", lambda size: fd.GainSupervisor(size, 7, period=PERIOD)),
        ("num_joints", lambda size: fd.GainSupervisor(3, size, period=PERIOD)),
        ("size", lambda size: fd.VariableGain(size)),
        ("size", lambda size: fd.LowPassFilter(size, period=PERIOD)),
        ("size", lambda size: fd.StatusMonitor(size)),
    ],
)
def test_sizes_must_be_positive_integers(argument, make, size):
    with pytest.raises(ValueError) as error:
        make(size)
    assert argument in str(error.value) and repr(size) in str(error.value)


def test_sizes_may_be_of_numpy(ports):
    assert ports(fd.VariableGain(np.int64(3)))[0] == {"gain": 1, "task_error": 3}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: fd.GainSupervisor(3, 7, period=PERIOD, error_limit=-1.0), ["error_limit", "-1"]),
        (
            lambda p: fd.GainSupervisor(3, 7, period=PERIOD, error_limit=np.nan),
            ["error_limit", "nan"],
        ),
        (lambda p: fd.VariableGain(3, limit=0.0), ["limit", "0.0", "positive"]),
        (lambda p: fd.VariableGain(3, limit=np.nan), ["limit", "nan", "positive"]),
        (lambda p: fd.StatusMonitor(3, tolerance=0.0), ["tolerance", "0.0", "positive"]),
        (
            lambda p: fd.LowPassFilter(3, period=PERIOD, smoothing=1.0),
            ["smoothing", "1.0", "[0, 1)"],
        ),
        (lambda p: fd.LowPassFilter(3, period=PERIOD, smoothing=-0.1), ["smoothing", "-0.1"]),
        (lambda p: fd.LowPassFilter(3, period=PERIOD, smoothing=np.nan), ["smoothing", "nan"]),
        (
            lambda p: fd.LowPassFilter(3, period=PERIOD, initial_value=np.nan),
            ["initial_value", "nan"],
        ),
        (
            lambda p: fd.DifferentialIk(p, law=fd.JacobianTranspose(), damped=True),
            ["damped", "law"],
        ),
        (lambda p: fd.DifferentialIk(p, max_joint_step=0.0), ["max_joint_step", "0.0", "positive"]),
        (
            lambda p: fd.DifferentialIk(p, singularity_nudge=-0.1),
            ["singularity_nudge", "-0.1", "negative"],
        ),
        (
            lambda p: fd.DifferentialIk(p, singularity_nudge=np.inf),
            ["singularity_nudge", "inf", "finite"],
        ),
        (lambda p: fd.DifferentialIk(p, limit_margin=-0.1), ["limit_margin", "-0.1", "negative"]),
        (lambda p: fd.DifferentialIk(p, limit_margin=np.nan), ["limit_margin", "nan"]),
        (lambda p: fd.DifferentialIk(p, posture_gain=1.1), ["posture_gain", "1.1", "[0, 1]"]),
        (lambda p: fd.DifferentialIk(p, posture_gain=-0.1), ["posture_gain", "-0.1", "[0, 1]"]),
        (lambda p: fd.DifferentialIk(p, posture_gain=np.nan), ["posture_gain", "nan"]),
        (
            lambda p: fd.DifferentialIk(p, posture_gain=0.1, nominal_position=[0.0, 1.0]),
            ["nominal_position", "7", "[0.0, 1.0]"],
        ),
        (lambda p: fd.RestartPlanner(p, period=PERIOD, tolerance=0.0), ["tolerance", "0.0"]),
        (lambda p: fd.RestartPlanner(p, period=PERIOD, tolerance=np.nan), ["tolerance", "nan"]),
        (lambda p: fd.RestartPlanner(p, period=PERIOD, speed=-1.0), ["speed", "-1.0", "positive"]),
        (
            lambda p: fd.DifferentialIk(p, nominal_position=[0.0]),
            ["nominal_position", "[0.0]", "7"],
        ),
        (lambda p: fd.DifferentialIk(p, task=3), ["task", "3", "position"]),
        (lambda p: fd.TaskError(p, frame=None), ["frame", "None", "tool"]),
        (lambda p: fd.RestartPlanner(p, period=PERIOD, speed=np.nan), ["speed", "nan"]),
        (lambda p: fd.RestartPlanner(p, period=PERIOD, task="yx"), ["task", "yx", "position"]),
        (lambda p: fd.RestartPlanner(p, period=PERIOD, frame="hand"), ["frame", "hand", "tool"]),
        (
            lambda p: fd.DifferentialIk(p, task="posture"),
            ["task", "posture", "position", "xy", "pose"],
        ),
        (lambda p: fd.TaskError(p, task="yx"), ["task", "yx", "position", "xy"]),
        (lambda p: fd.TaskError(p, frame="hand"), ["frame", "hand", "link1", "link7", "tool"]),
        (lambda p: fd.DifferentialIk(p, frame=""), ["frame", "''", "link1", "link7", "tool"]),
        (
            lambda p: fd.DifferentialIk(p, frame="no_arm::tool"),
            ["frame", "no_arm::tool", "arm7::tool"],
        ),
    ],
)
def test_errors_name_the_bad_value_and_the_valid_ones(make, words, plant):
    with pytest.raises(ValueError) as error:
        make(plant)
    for word in words:
        assert word in str(error.value)


BLOCKS_WITH_A_PLANT = [
    lambda plant: fd.TaskError(plant),
    lambda plant: fd.DifferentialIk(plant),
    lambda plant: fd.RestartPlanner(plant, period=PERIOD),
    lambda plant: fd.MakeFuzzyIkController(plant),
    lambda plant: fd.MakeFuzzyIkController(plant, config=fd.FuzzyIkConfig(fused=True)),
    lambda plant: fd.MakeFuzzyIkController(
        plant, config=fd.FuzzyIkConfig(law=fd.FuzzyMapping("direct"))
    ),
]


@pytest.mark.parametrize("make", BLOCKS_WITH_A_PLANT)
def test_a_plant_must_be_finalized(make, arm7):
    plant = MultibodyPlant(0.0)
    fd.AddDhArm(plant, arm7)
    with pytest.raises(ValueError, match="finalized"):
        make(plant)


@pytest.mark.parametrize("make", BLOCKS_WITH_A_PLANT)
def test_a_free_body_beside_the_arm_is_left_alone(make, arm7):
    plant = MultibodyPlant(0.0)
    instance = fd.AddDhArm(plant, arm7)
    plant.AddRigidBody("ball", instance, SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    plant.Finalize()
    assert plant.num_positions() == 14
    block = make(plant)
    sizes = {block.get_output_port(i).size() for i in range(block.num_output_ports())}
    assert 14 not in sizes and 13 not in sizes


@pytest.mark.parametrize("make", BLOCKS_WITH_A_PLANT)
def test_a_plant_must_have_joints(make):
    plant = MultibodyPlant(0.0)
    body = plant.AddRigidBody("hand", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    plant.WeldFrames(plant.world_frame(), body.body_frame())
    plant.AddFrame(FixedOffsetFrame("tool", body.body_frame(), RigidTransform()))
    plant.Finalize()
    with pytest.raises(ValueError, match="no joint moves frame 'tool'"):
        make(plant)
