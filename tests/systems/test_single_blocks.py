"""Each block alone: what it puts out against the pure functions and the arm's own kinematics."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LinearSystem, LogVectorOutput, Sine

import fikm_drake as fd
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.status import controller_status
from fikm_drake.control.steps import amplify

AXES = {
    "position": [0, 1, 2],
    "xy": [0, 1],
    "xz": [0, 2],
    "yz": [1, 2],
    "x": [0],
    "y": [1],
    "z": [2],
}


@pytest.mark.parametrize("task", AXES)
def test_task_error_is_desired_minus_actual(task, plant, arm7, drive):
    rng = np.random.default_rng(0)
    driver = drive(fd.TaskError(plant, task=task))
    for q in rng.uniform(-3, 3, (20, 7)):
        desired = rng.normal(size=len(AXES[task]))
        expected = desired - arm7.forward_kinematics(q)[AXES[task], 3]
        outputs = driver.cycle(desired_position=desired, position=q)
        np.testing.assert_allclose(outputs["task_error"], expected, atol=1e-14)
        assert outputs["valid"] == 1


@pytest.mark.parametrize(("frame", "joints"), [("tool", 7), ("arm7::tool", 7), ("link4", 4)])
def test_task_error_of_another_frame(frame, joints, plant, arm7, drive):
    """The joints are those that move the frame."""
    q = np.linspace(-1, 1, 7)
    pose = arm7.link_poses(q)[3] if frame == "link4" else arm7.forward_kinematics(q)
    driver = drive(fd.TaskError(plant, frame=frame))
    error = driver.cycle(desired_position=np.zeros(3), position=q[:joints])["task_error"]
    np.testing.assert_allclose(error, -pose[:3, 3], atol=1e-14)


@pytest.mark.parametrize("task", AXES)
@pytest.mark.parametrize("method", ["indirect", "direct"])
def test_fuzzy_ik_is_the_law_at_the_arms_jacobian(task, method, plant, arm7, drive):
    rows = [3 + i for i in AXES[task]]
    law = fd.FuzzyMapping(method, jacobian_range=arm7.jacobian_range()[rows])
    driver = drive(fd.DifferentialIk(plant, law=law, task=task))
    rng = np.random.default_rng(1)
    for q in rng.uniform(-3, 3, (10, 7)):
        error = rng.uniform(-0.05, 0.05, len(rows))
        outputs = driver.cycle(task_error=error, position=q)
        expected = law(arm7.jacobian(q)[rows], error)
        np.testing.assert_allclose(outputs["joint_step"], expected, atol=1e-12)


def test_fuzzy_ik_takes_the_paper_s_law_by_default(plant, arm7, drive):
    q, error = np.linspace(-1, 1, 7), np.array([0.01, 0.02, -0.01])
    step = drive(fd.DifferentialIk(plant)).cycle(task_error=error, position=q)["joint_step"]
    np.testing.assert_allclose(step, fd.FuzzyMapping()(arm7.jacobian(q)[3:], error), atol=1e-13)


def test_fuzzy_ik_takes_another_law(plant, arm7, drive):
    """Any object with `step(J, dr)`: here damped least squares."""

    class Damped:
        def step(self, J, dr):
            return J.T @ np.linalg.solve(J @ J.T + 1e-6 * np.eye(len(J)), dr)

    q, error = np.linspace(-1, 1, 7), np.array([0.01, 0.02, -0.01])
    step = drive(fd.DifferentialIk(plant, law=Damped())).cycle(task_error=error, position=q)[
        "joint_step"
    ]
    np.testing.assert_allclose(step, Damped().step(arm7.jacobian(q)[3:], error), atol=1e-13)
    np.testing.assert_allclose(arm7.jacobian(q)[3:] @ step, error, atol=1e-4)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_fuzzy_ik_guard(plant, drive, bad):
    """The error is good still, filtered as it is, but what it comes from is lost."""
    driver = drive(fd.DifferentialIk(plant, guarded=True))
    good = {"task_error": np.full(3, 0.01), "position": np.ones(7), "guard": np.zeros(3)}
    assert driver.cycle(**good)["joint_step"].any()
    lost = driver.cycle(**good | {"guard": np.array([0.0, bad, 0.0])})
    assert not lost["joint_step"].any() and lost["valid"] == 0
    assert fd.DifferentialIk(plant).num_input_ports() == 2


def test_a_nan_of_a_joint_counts(plant, drive):
    """An arm whose sensors fail must stop, also where only an inner frame counts."""
    q = np.full(4, 0.3)
    q[3] = np.nan
    outputs = drive(fd.TaskError(plant, frame="link4")).cycle(
        desired_position=np.ones(3), position=q
    )
    assert outputs["valid"] == 0 and not outputs["task_error"].any()
    outputs = drive(fd.DifferentialIk(plant, frame="link4")).cycle(
        task_error=np.ones(3), position=q
    )
    assert outputs["valid"] == 0 and not outputs["joint_step"].any()


@given(
    hnp.arrays(float, 3, elements=st.floats(-1, 1)), st.floats(0, 3), st.sampled_from([0.2, np.inf])
)
def test_variable_gain(drive, error, gain, limit):
    driver = drive(fd.VariableGain(3, limit=limit))
    outputs = driver.cycle(gain=[gain], task_error=error)
    expected = amplify(gain, error, float(np.linalg.norm(error)), limit)
    np.testing.assert_allclose(outputs["amplified_error"], expected, rtol=1e-12, atol=1e-15)


def test_fuzzy_ik_hands_the_damping_to_the_law(plant, arm7, drive):
    law = fd.FuzzyMapping(iterations=3, damping=0.1)
    driver = drive(fd.DifferentialIk(plant, law=law, damped=True))
    q, error = np.linspace(-1, 1, 7), np.array([0.01, 0.02, -0.01])
    J = arm7.jacobian(q)[3:]
    for damping in (0.0, 0.3):
        outputs = driver.cycle(task_error=error, position=q, damping=[damping])
        np.testing.assert_allclose(outputs["joint_step"], law(J, error, damping), atol=1e-12)
    assert fd.DifferentialIk(plant, law=law).num_input_ports() == 2


def test_fuzzy_ik_bounds_its_step_and_keeps_off_the_limits(plant_with, drive):
    """See tests/laws for how; here it is the plant's limits and the given length that count."""
    panda = fd.load_arm("panda")
    driver = drive(fd.DifferentialIk(plant_with("panda"), max_joint_step=0.05, limit_margin=0.1))
    free = drive(fd.DifferentialIk(plant_with("panda")))
    rng = np.random.default_rng(4)
    weaker = 0
    for _ in range(50):
        q = np.clip(rng.uniform(-3, 3, 7), panda.lower, panda.upper)  # some at their limits
        error = 0.1 * rng.normal(size=3)
        step = driver.cycle(task_error=error, position=q)["joint_step"]
        assert np.linalg.norm(step) <= 0.05 * (1 + 1e-12)
        asked = free.cycle(task_error=error, position=q)["joint_step"]
        outward = ((q == panda.upper) & (asked > 0)) | ((q == panda.lower) & (asked < 0))
        weaker += outward.sum()
        assert not step[outward].any()
    assert weaker > 30


def test_fuzzy_ik_pulls_to_the_nominal_posture(plant, arm7, drive):
    nominal = np.linspace(0.3, -0.4, 7)
    driver = drive(fd.DifferentialIk(plant, posture_gain=0.1, nominal_position=nominal.tolist()))
    q = np.linspace(-1, 1, 7)
    step = driver.cycle(task_error=np.zeros(3), position=q)["joint_step"]
    J = arm7.jacobian(q)[3:]
    expected = 0.1 * (nominal - q - np.linalg.pinv(J) @ J @ (nominal - q))
    np.testing.assert_allclose(step, expected, atol=5e-5)


@pytest.mark.parametrize("flags", list(itertools.product([0.0, 1.0], repeat=3)))
@pytest.mark.parametrize("restart_search", [None, *fd.RestartState])
def test_status_monitor(drive, flags, restart_search):
    driver = drive(fd.StatusMonitor(2, restart_search=restart_search is not None))
    names = dict(zip(("valid", "limited", "oscillating"), flags))
    state = {} if restart_search is None else {"restart_search": restart_search}
    inputs = {name: [float(value)] for name, value in (names | state).items()}
    flags = {name: bool(flag) for name, flag in names.items()} | state
    for calmed, error in itertools.product([0.0, 1.0], [0.0, 1e-3, 1.1e-3, 2.0]):
        for following in (True, False):
            status = driver.cycle(
                task_error=[0.0, -error], calmed=[calmed], following=[float(following)], **inputs
            )["status"]
            expected = controller_status(
                error=error, tolerance=1e-3, calmed=bool(calmed), following=following, **flags
            )
            assert status == expected


def test_gain_supervisor_is_the_law(drive):
    rng = np.random.default_rng(3)
    law = fd.GainSupervision(3, 7, error_limit=0.2)
    memory = law.initial_memory()
    driver = drive(fd.GainSupervisor(3, 7, period=0.02, error_limit=0.2))
    calms = set()
    for _ in range(300):
        error = 10.0 ** rng.uniform(-4, 0) * rng.normal(size=3)
        step = rng.normal(size=7) * (rng.random(7) < 0.9)
        target = 1e-6 * rng.normal(size=3)
        outputs = driver.cycle(task_error=error, joint_step=step, target=target)
        size = np.linalg.norm(error)
        assert outputs["gain"] == pytest.approx(law.gain(memory, size), rel=1e-12)
        assert outputs["oscillating"] == law.oscillating(memory)
        assert outputs["oscillating_joint"] == law.oscillating_joint(memory)
        assert outputs["calm"] == law.calm(memory)
        assert outputs["calmed"] == law.calmed(memory)
        assert outputs["damping"] == law.damping(memory)
        calms.add(law.calm(memory))
        law.remember(memory, error, step, target)
    assert len(calms) > 10


def test_gain_supervisor_forgets_what_is_not_finite(drive):
    paper = fd.GainSupervisorConfig(calming=1.0)
    block = fd.GainSupervisor(3, 2, period=0.02, config=paper, error_limit=0.2)
    disturbed, expected = drive(block), drive(block)
    rng = np.random.default_rng(4)
    for k in range(60):
        good = {"task_error": rng.normal(size=3), "joint_step": rng.normal(size=2)}
        if k % 3 == 0:
            bad = rng.choice([np.nan, np.inf, -np.inf])
            outputs = disturbed.cycle(task_error=[0, bad, 0], joint_step=[0.0, 0.0])
            assert outputs["gain"] in (0.8, 0.03)  # that of a big error
        # Cycles without a motion age the sign changes: only the errors are compared.
        known = disturbed.cycle(**good)["gain"], expected.cycle(**good)["gain"]
        fields = fd.GainSupervision(3, 2).fields
        errors = [d.state()[0].copy().view(fields)["errors"] for d in (disturbed, expected)]
        np.testing.assert_array_equal(errors[0], errors[1])
        assert all(np.isfinite(known))


@given(st.lists(hnp.arrays(float, 2, elements=st.floats(-3, 3)), min_size=1, max_size=20))
def test_joint_integrator_keeps_the_limits(drive, steps):
    lower, upper = np.array([-1.0, -np.inf]), np.array([2.0, 0.5])
    block = fd.JointIntegrator(lower, upper, period=0.5, initial_position=[0.0, 0.0])
    driver = drive(block)
    q = np.zeros(2)
    for step in steps:
        outputs = driver.cycle(joint_step=step)
        np.testing.assert_array_equal(outputs["position"], q)
        free = q + step
        after = np.clip(free, lower, upper)
        assert outputs["limited"] == (after != free).any()
        np.testing.assert_allclose(driver["velocity"], (after - q) / 0.5, atol=1e-12)
        q = after
    np.testing.assert_array_equal(driver["position"], q)


def test_joint_integrator_velocity_is_the_derivative_of_the_position(drive):
    block = fd.JointIntegrator([-9] * 3, [9] * 3, period=0.01, initial_position=np.zeros(3))
    rng = np.random.default_rng(5)
    driver = drive(block)
    outputs = [driver.cycle(joint_step=step) for step in rng.normal(size=(9, 3))]
    q, v = (np.array([o[name] for o in outputs]) for name in ("position", "velocity"))
    np.testing.assert_allclose(v[1:], np.diff(q, axis=0) / 0.01, rtol=1e-9)
    assert not v[0].any()


def test_joint_integrator_keeps_the_rates(drive):
    """What `JointLimits` does, on the block's own state; the velocity is that of the command."""
    limits = {"velocity_limits": [1.0, np.inf], "acceleration_limits": 20.0}
    block = fd.JointIntegrator(
        [-1.0, -np.inf], [0.5, np.inf], period=0.02, initial_position=[0.4, 0.0], **limits
    )
    law = JointLimits(np.array([-1.0, -np.inf]), np.array([0.5, np.inf]), period=0.02, **limits)
    rng = np.random.default_rng(7)
    driver, q, v = drive(block), np.array([0.4, 0.0]), np.zeros(2)
    limited = set()
    for step in rng.normal(0.01, 0.02, (200, 2)):
        outputs = driver.cycle(joint_step=step)
        np.testing.assert_allclose(outputs["position"], q, atol=1e-12)
        np.testing.assert_allclose(outputs["velocity"], v, atol=1e-10)
        assert outputs["limited"] == law.limits(q, step, v)
        limited.add(bool(outputs["limited"]))
        after = law.integrate(q, step, v)
        assert (np.abs((after - q) / 0.02 - v) <= 20.0 * 0.02 + 1e-9).all()
        q, v = after, (after - q) / 0.02
    assert limited == {False, True}


def test_joint_integrator_brakes_when_its_input_is_lost(drive):
    """No jump of the speed, and it stands after the time that the acceleration takes."""
    block = fd.JointIntegrator(
        [-9.0], [9.0], period=0.02, initial_position=[0.0], acceleration_limits=5.0
    )
    driver = drive(block)
    for _ in range(10):
        driver.cycle(joint_step=[1.0])
    assert driver["velocity"] == pytest.approx(1.0)
    speeds = []
    for _ in range(12):
        assert driver.cycle(joint_step=[np.nan])["limited"] == 0
        speeds.append(float(driver["velocity"][0]))
    np.testing.assert_allclose(speeds, np.maximum(0.9 - 0.1 * np.arange(12), 0.0), atol=1e-9)


def test_set_positions_is_a_start_from_rest(drive):
    block = fd.JointIntegrator(
        [-9.0], [9.0], period=0.02, initial_position=[0.0], acceleration_limits=5.0
    )
    driver = drive(block)
    for _ in range(10):
        driver.cycle(joint_step=[1.0])
    block.SetPositions(driver.context, [1.0])
    driver.cycle(joint_step=[1.0])
    assert driver["position"] == pytest.approx(1.0 + 5.0 * 0.02**2)


@pytest.mark.parametrize("name", ["velocity_limits", "acceleration_limits"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, [1.0, 2.0, 3.0], [1.0, -2.0]])
def test_joint_integrator_errors_of_rates(name, value):
    with pytest.raises(ValueError, match=name) as error:
        fd.JointIntegrator([-1] * 2, [1] * 2, period=0.02, initial_position=[0, 0], **{name: value})
    assert str(value) in str(error.value)


@pytest.mark.parametrize(
    ("lower", "upper", "initial", "words"),
    [
        ([1.0], [-1.0], [0.0], ["lower", "[1.0]", "[-1.0]"]),
        ([0.1], [0.0], [0.0], ["lower", "exceed"]),
        ([np.nan], [1.0], [0.0], ["lower", "nan"]),
        ([-1.0, -1.0], [1.0], [0.0], ["lower", "(2,)", "(1,)"]),
        ([], [], [], ["lower", "(0,)"]),
        (-1.0, 1.0, 0.0, ["lower", "()"]),
        ([-1.0], [1.0], [2.0], ["position[0]", "-1.0", "1.0", "2.0"]),
        ([-1.0, -1.0], [1.0, 1.0], [0.0, -1.5], ["position[1]", "-1.5"]),
        ([-1.0], [1.0], [0.0, 0.0], ["1 finite", "[0.0, 0.0]"]),
        ([-1.0], [1.0], [np.nan], ["finite", "nan"]),
        ([-np.inf], [np.inf], [np.inf], ["finite", "inf"]),
    ],
)
def test_joint_integrator_errors(lower, upper, initial, words):
    with pytest.raises(ValueError) as error:
        fd.JointIntegrator(lower, upper, period=0.02, initial_position=initial)
    for word in words:
        assert word in str(error.value)


def test_set_positions(drive):
    block = fd.JointIntegrator([-1.0] * 2, [1.0] * 2, period=0.02, initial_position=[0.0, 0.0])
    driver = drive(block)
    driver.cycle(joint_step=[0.1, 0.1])
    block.SetPositions(driver.context, [0.5, -1.0])
    np.testing.assert_array_equal(driver["position"], [0.5, -1.0])
    np.testing.assert_array_equal(driver["velocity"], [0.0, 0.0])
    for wrong in ([0.5], [0.5, 1.1], [0.5, np.nan], [[0.5, 0.5]]):
        with pytest.raises(ValueError, match="joint position"):
            block.SetPositions(driver.context, wrong)
    np.testing.assert_array_equal(driver["position"], [0.5, -1.0])


def test_set_positions_refuses_the_context_of_another_system():
    """The root Context's first state group may be another block's of the same size."""
    builder = DiagramBuilder()
    blocks = [
        builder.AddSystem(fd.JointIntegrator([-1], [1], period=0.02, initial_position=[0]))
        for _ in range(2)
    ]
    source = builder.AddSystem(ConstantVectorSource([0.1]))
    for block in blocks:
        builder.Connect(source.get_output_port(), block.GetInputPort("joint_step"))
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    with pytest.raises(RuntimeError):
        blocks[1].SetPositions(root, [0.5])
    with pytest.raises(RuntimeError):
        blocks[1].SetPositions(blocks[0].GetMyMutableContextFromRoot(root), [0.5])
    assert not root.get_discrete_state(0).value().any()


@pytest.mark.parametrize("smoothing", [0.0, 0.5, 2 / 3])
def test_low_pass_filter_is_equation_31(drive, smoothing):
    driver = drive(fd.LowPassFilter(3, period=0.02, smoothing=smoothing, initial_value=0.7))
    rng = np.random.default_rng(6)
    y = np.full(3, 0.7)
    for u in rng.normal(size=(50, 3)):
        y = (1 - smoothing) * u + smoothing * y
        np.testing.assert_allclose(driver.cycle(u0=u)["y0"], y, atol=1e-14)


def test_low_pass_filter_defaults_to_the_paper(drive):
    """Equations 30, 31: one third of the new, two thirds of the old."""
    driver = drive(fd.LowPassFilter(1, period=0.02))
    assert driver.cycle(u0=[3.0])["y0"] == pytest.approx(1.0)
    assert driver.cycle(u0=[0.0])["y0"] == pytest.approx(2 / 3)


def test_low_pass_filter_is_drake_s_and_converts():
    block = fd.LowPassFilter(2, period=0.02)
    assert isinstance(block, LinearSystem)
    assert block.time_period() == 0.02
    for convert in (block.ToAutoDiffXd, block.ToSymbolic):
        converted = convert()
        assert converted.num_input_ports() == 1 and converted.get_output_port().size() == 2
    from pydrake.autodiffutils import AutoDiffXd, ExtractGradient

    autodiff = block.ToAutoDiffXd()
    context = autodiff.CreateDefaultContext()
    u = np.array([AutoDiffXd(1.0, [1.0, 0.0]), AutoDiffXd(2.0, [0.0, 1.0])])
    autodiff.get_input_port().FixValue(context, u)
    y = autodiff.get_output_port().Eval(context)
    np.testing.assert_allclose(ExtractGradient(y), np.eye(2) / 3)


def test_blocks_of_the_loop_in_a_diagram_of_one_s_own(plant, arm7):
    """TaskError, DifferentialIk and JointIntegrator, without supervisor and filters, wired by hand."""
    builder = DiagramBuilder()
    error = builder.AddNamedSystem("error", fd.TaskError(plant))
    ik = builder.AddNamedSystem("ik", fd.DifferentialIk(plant))
    q0 = np.full(7, 0.2)
    integrator = builder.AddNamedSystem(
        "integrator", fd.JointIntegrator(arm7.lower, arm7.upper, period=0.02, initial_position=q0)
    )
    target = builder.AddSystem(ConstantVectorSource([0.3, -0.5, 0.5]))
    builder.Connect(target.get_output_port(), error.GetInputPort("desired_position"))
    builder.Connect(error.GetOutputPort("task_error"), ik.GetInputPort("task_error"))
    builder.Connect(ik.GetOutputPort("joint_step"), integrator.GetInputPort("joint_step"))
    for block in (error, ik):
        builder.Connect(integrator.GetOutputPort("position"), block.GetInputPort("position"))
    sink = LogVectorOutput(integrator.GetOutputPort("position"), builder, 0.02)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(4.0)
    q = sink.FindLog(simulator.get_context()).data().T
    law, expected = fd.FuzzyMapping(), [q0]
    for _ in q[1:]:
        last = expected[-1]
        e = np.array([0.3, -0.5, 0.5]) - arm7.forward_kinematics(last)[:3, 3]
        expected.append(last + law(arm7.jacobian(last)[3:], e))
    np.testing.assert_allclose(q, expected, atol=1e-9)
    assert np.linalg.norm(e) < 1e-6


def test_supervisor_and_filter_in_a_diagram_of_one_s_own():
    """GainSupervisor, LowPassFilter and VariableGain beside somebody else's signal."""
    builder = DiagramBuilder()
    signal = builder.AddSystem(Sine(0.1, 3.0, 0.5, 2))
    supervisor = builder.AddSystem(fd.GainSupervisor(2, 2, period=0.02))
    smooth = builder.AddSystem(fd.LowPassFilter(1, period=0.02, initial_value=1.0))
    gain = builder.AddSystem(fd.VariableGain(2, limit=0.05))
    builder.Connect(signal.get_output_port(0), supervisor.GetInputPort("task_error"))
    builder.Connect(signal.get_output_port(0), gain.GetInputPort("task_error"))
    builder.Connect(supervisor.GetOutputPort("gain"), smooth.get_input_port())
    builder.Connect(smooth.get_output_port(), gain.GetInputPort("gain"))
    # The loop that needs no feedthrough from the joint step to the gain.
    builder.Connect(gain.GetOutputPort("amplified_error"), supervisor.GetInputPort("joint_step"))
    sink = LogVectorOutput(gain.GetOutputPort("amplified_error"), builder, 0.02)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(2.0)
    data = sink.FindLog(simulator.get_context()).data()
    assert np.linalg.norm(data, axis=0).max() <= 2.6 * 0.05
    assert np.abs(data).max() > 0.05
