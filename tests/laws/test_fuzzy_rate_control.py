"""Fuzzy resolved motion rate control (Kim & Lee 1993): equations 13-15, and what they imply."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator

import fikm_drake as fd
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.laws.fuzzy_rate_control import CHUNK
from fikm_drake.laws.rate_inference import INFERENCE

BOTH = pytest.mark.parametrize("variant", ["paper", "smooth"])
sizes = st.tuples(st.integers(1, 6), st.integers(1, 9))


@st.composite
def cases(draw):
    m, n = draw(sizes)
    elements = st.floats(-3.0, 3.0).filter(lambda x: x == 0.0 or abs(x) > 1e-3)
    J = draw(hnp.arrays(float, (m, n), elements=elements))
    return J, draw(hnp.arrays(float, m, elements=st.floats(-0.5, 0.5)))


def equations_13_to_15(J, dr, variant, gain, reach, D):
    """One sweep, joint by joint, as the algorithm of section 2 is printed."""
    infer = INFERENCE[variant][1]
    dtheta = []
    for k in range(J.shape[1]):
        dtheta.append(gain * infer(J[:, k].tolist(), dr.tolist(), 1.0 / reach[k], D))
        dr = dr - J[:, k] * dtheta[-1]
    return np.array(dtheta)


@BOTH
def test_one_sweep_is_the_papers_algorithm(variant):
    rng = np.random.default_rng(0)
    reach = np.array([1.4, 0.9, 0.4])
    law = fd.FuzzyRateControl(variant, reach=reach, gain=1.2)
    for _ in range(100):
        J = rng.uniform(-0.7, 0.7, (2, 3)) * reach
        dr = rng.uniform(-0.1, 0.1, 2)
        expected = equations_13_to_15(J, dr, variant, 1.2, reach, 0.1)
        np.testing.assert_allclose(law(J, dr), expected, rtol=1e-12, atol=1e-15)


def test_a_sweep_of_smooth_is_gauss_seidel_on_the_normal_equations():
    """Lower triangle of JᵀJ: (D + L) dθ = Jᵀ dr with D = |J_k|² for a gain of 1."""
    rng = np.random.default_rng(1)
    J, dr = rng.normal(size=(3, 5)), 0.02 * rng.normal(size=3)
    expected = np.linalg.solve(np.tril(J.T @ J), J.T @ dr)
    law = fd.FuzzyRateControl(floor=1e-6, gain=1.0)
    np.testing.assert_allclose(law(J, dr), expected, rtol=1e-10)


def test_many_sweeps_solve_the_linear_equations():
    rng = np.random.default_rng(2)
    J, dr = rng.normal(size=(3, 7)), 0.02 * rng.normal(size=3)
    left = [
        np.linalg.norm(dr - J @ fd.FuzzyRateControl(sweeps=sweeps)(J, dr)) for sweeps in (1, 3, 30)
    ]
    assert left[1] < 0.3 * left[0] and left[2] < 1e-6 * left[0]


@given(cases(), st.floats(0.01, 1.99), st.sampled_from([None, 0.1, 5.0]))
def test_smooth_never_makes_the_error_longer(case, gain, reach):
    """Whatever J is, longer than the reach too; and errors beyond D."""
    J, dr = case
    reach = None if reach is None else [reach] * J.shape[1]
    step = fd.FuzzyRateControl(gain=gain, reach=reach)(J, dr)
    assert np.linalg.norm(dr - J @ step) <= np.linalg.norm(dr) * (1 + 1e-12)


@given(cases(), st.sampled_from(["paper", "smooth"]), st.integers(1, 4))
def test_is_odd_and_does_not_depend_on_signs_of_joints(case, variant, sweeps):
    J, dr = case
    law = fd.FuzzyRateControl(variant, sweeps=sweeps)
    step = law(J, dr)
    np.testing.assert_allclose(law(J, -dr), -step, atol=1e-12)
    np.testing.assert_allclose(law(-J, dr), -step, atol=1e-12)


@BOTH
def test_bounded_step_for_a_far_target(variant):
    """A longer error than D counts as D: the step is that of an error of this size."""
    J = np.array([[0.3, -0.2, 0.1], [0.9, 0.5, 0.3]])
    law = fd.FuzzyRateControl(variant, error_range=0.05)
    near, far = np.array([0.05, 0.05]), np.array([50.0, 50.0])
    assert np.abs(law(J, far)).max() <= 3 * np.abs(law(J, near)).max()


def test_smooth_keeps_the_direction_of_a_long_error():
    J = np.array([[0.3, -0.2, 0.1], [0.9, 0.5, 0.3]])
    law, dr = fd.FuzzyRateControl(sweeps=3), np.array([0.3, -0.6])
    np.testing.assert_allclose(law(J, dr), law(J, dr * (0.1 / 0.6)), rtol=1e-12)


@BOTH
@pytest.mark.parametrize("reach", [None, np.linspace(2.0, 0.5, 7)])
@pytest.mark.parametrize("lead", [(), (1,), (2, 3), (0,), (CHUNK + 3,)])
def test_a_batch_equals_its_elements(variant, reach, lead):
    rng = np.random.default_rng(3)
    J, dr = rng.normal(size=(*lead, 3, 7)), 0.1 * rng.normal(size=(*lead, 3))
    law = fd.FuzzyRateControl(variant, reach=reach, sweeps=2)
    steps = law(J, dr)
    assert steps.shape == (*lead, 7)
    for index in list(np.ndindex(*lead))[-5:]:
        np.testing.assert_allclose(steps[index], law.step(J[index], dr[index]), atol=1e-14)


def test_shapes_broadcast_and_arguments_are_left_alone():
    rng = np.random.default_rng(4)
    J, dr = rng.normal(size=(3, 7)), rng.normal(size=(5, 3))
    J_before, dr_before = J.copy(), dr.copy()
    law = fd.FuzzyRateControl(sweeps=2)
    steps = law(J, dr)
    assert steps.shape == (5, 7)
    np.testing.assert_allclose(steps[4], law(J, dr[4]), atol=1e-15)
    np.testing.assert_array_equal(J, J_before)
    np.testing.assert_array_equal(dr, dr_before)


@BOTH
def test_nothing_to_do_gives_zeros(variant):
    law = fd.FuzzyRateControl(variant)
    for scale, dr in ((1.0, np.zeros(2)), (0.0, np.ones(2)), (1e-300, np.ones(2))):
        J = scale * np.ones((2, 3))
        assert np.abs(law(J, dr)).max() < 1e-6
        assert np.abs(law.step(J, dr)).max() < 1e-6


def test_a_tool_on_its_only_axis_does_not_spin():
    """A column of rounding errors is no lever."""
    assert abs(fd.FuzzyRateControl().step(np.array([[1e-17], [0.0]]), np.array([0.1, 0.0]))) < 1e-3


@BOTH
@pytest.mark.parametrize("reach", [None, [1.0, 1.0]])
def test_a_jacobian_that_is_not_finite_gives_no_number(variant, reach):
    """The blocks hold the arm where a law's step is not finite."""
    law, J = fd.FuzzyRateControl(variant, reach=reach), np.full((2, 2), np.nan)
    assert not np.isfinite(law.step(J, np.array([0.1, 0.2]))).any()
    assert not np.isfinite(law(J, [0.1, 0.2])).any()


def test_a_joint_with_a_short_lever_is_not_whirled_about():
    """A column a thousand times shorter than the others: the floor bounds what it turns."""
    J = np.array([[1.0, 0.0], [0.0, 1e-3]])
    step = fd.FuzzyRateControl(gain=1.0, floor=0.25)(J, [0.0, 0.05])
    assert np.abs(step).max() == pytest.approx(0.05 * 1e-3 / 0.25**2)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"variant": "rough"}, "'smooth'"),
        ({"gain": 0.0}, "gain"),
        ({"gain": 2.0}, r"\(0, 2\)"),
        ({"gain": float("nan")}, "gain"),
        ({"sweeps": 0}, "sweeps"),
        ({"sweeps": 1.5}, "sweeps"),
        ({"floor": 0.0}, "floor"),
        ({"floor": 1.1}, "floor"),
        ({"error_range": 0.0}, "error_range"),
        ({"error_range": float("inf")}, "error_range"),
        ({"reach": 1.4}, "one number a joint"),
        ({"reach": [1.0, -0.1]}, "not negative"),
        ({"reach": [1.0, float("inf")]}, "prismatic"),
    ],
)
def test_bad_arguments_are_named(arguments, word):
    with pytest.raises(ValueError, match=word):
        fd.FuzzyRateControl(**arguments)


def test_bad_shapes_are_named():
    law = fd.FuzzyRateControl(reach=[1.4, 0.9, 0.4])
    with pytest.raises(ValueError, match="m, n"):
        law(np.ones((2, 3)), np.ones(3))
    with pytest.raises(ValueError, match="3 columns"):
        law(np.ones((2, 7)), np.ones(2))
    with pytest.raises(ValueError):
        law.step(np.ones((2, 7)), np.ones(2))


def test_universes_of_an_arm():
    law = fd.FuzzyRateControl.for_arm(fd.load_arm("kim_lee3r"), "paper", task="xy", gain=1.1)
    np.testing.assert_allclose(law.reach, [1.4, 0.9, 0.4])
    assert (law.variant, law.gain) == ("paper", 1.1)
    slide = fd.DhArm(
        fd.DhTable("a", joints=[fd.DhJoint(), fd.DhJoint(type="prismatic", alpha=1.0)])
    )
    with pytest.raises(ValueError, match="prismatic joint needs limits"):
        fd.FuzzyRateControl.for_arm(slide)


def test_rules_are_there_to_be_read():
    law = fd.FuzzyRateControl()
    assert law.rules.first.labels == ("N", "Z", "P") and law.rules.second.labels == ("N", "P")
    assert len(law.rule_texts) == 5


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("name", ["arm7", "panda", "iiwa14"])
def test_seven_joints_in_the_main_controller_by_one_argument(name, fused):
    arm = fd.load_arm(name)
    start = np.clip([0.1, -0.5, 0.2, -1.6, 0.1, 1.2, 0.3], arm.lower, arm.upper)
    tool = arm.forward_kinematics(start)[:3, 3]
    scenario = fd.TrackingScenario(
        arm=arm,
        waypoints=[tool.tolist(), (tool + [0.05, 0.15, -0.1]).tolist()],
        duration=2.0,
        hold=1.0,
        initial_position=start.tolist(),
        config=fd.FuzzyIkConfig(fused=fused).resolved_rate(),
    )
    for law in (fd.FuzzyRateControl.for_arm(arm), fd.FuzzyRateControl(sweeps=3)):
        metrics = fd.simulate(scenario, law=law).metrics()
        assert metrics.e_ss < 1e-5
        assert metrics.e_max < 0.005


def test_follows_a_pose_in_the_main_controller():
    """Six rows; a turn counts with the characteristic length."""
    arm = fd.load_arm("iiwa14")
    law = fd.FuzzyRateControl(sweeps=6)
    config = fd.FuzzyIkConfig(task="pose", control_rate=100.0).resolved_rate()
    controller = fd.MakeFuzzyIkController(MakeDhArmPlant(arm), config=config, law=law)
    simulator = Simulator(controller)
    context = simulator.get_mutable_context()
    controller.SetPositions(context, [0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
    T = arm.forward_kinematics([0.3, 0.8, 0.2, -1.2, 0.3, 0.7, 0.4])
    target = RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])
    controller.GetInputPort("desired_pose").FixValue(context, Value(target))
    simulator.AdvanceTo(2.0)
    error = controller.GetOutputPort("task_error").Eval(context)
    assert np.linalg.norm(error) < 1e-3


def test_resolved_rate_config_applies_the_laws_step_as_it_is():
    arm = fd.load_arm("kim_lee3r")
    config = fd.FuzzyIkConfig(task="xy").resolved_rate()
    law = fd.FuzzyRateControl(sweeps=2)
    controller = fd.MakeFuzzyIkController(MakeDhArmPlant(arm), config=config, law=law)
    context = controller.CreateDefaultContext()
    q = np.array([0.3, 0.9, -0.5])
    controller.SetPositions(context, q)
    target = arm.forward_kinematics(q)[:2, 3] + [0.03, -0.02]
    controller.GetInputPort("desired_position").FixValue(context, target)
    step = controller.GetOutputPort("joint_step").Eval(context)
    np.testing.assert_allclose(step, law(arm.jacobian(q)[3:5], [0.03, -0.02]), rtol=1e-9)
    assert fd.FuzzyIkConfig(control_rate=200.0).resolved_rate().control_rate == 200.0
