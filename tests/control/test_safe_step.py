"""A law's step made safe: its length, its failures, its damping."""

from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.joint_limits import JointLimits, StepBox
from fikm_drake.control.limit_weights import LimitWeights
from fikm_drake.control.posture import posture_step
from fikm_drake.control.safe_step import DEAD, SafeStep, aside
from fikm_drake.kinematics.native.kernel import numpy_only

Q = np.zeros(7)


class Asks:
    """A law that gives what it was made with, and keeps what it is asked."""

    def __init__(self, answer):
        self.answer, self.asked = np.array(answer, dtype=float), []

    def step(self, *asked):
        self.asked.append(asked)
        return self.answer


def matrices(seed):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(3, 7)), rng.normal(size=3)


@given(st.integers(0, 10**6), st.floats(1e-3, 10.0))
def test_a_step_that_is_too_long_is_shortened_in_its_direction(seed, longest):
    J, error = matrices(seed)
    law = fd.FuzzyMapping(iterations=3)
    free, step = law.step(J, error), SafeStep(law, longest=longest)(Q, J, error)
    length = np.linalg.norm(free)
    np.testing.assert_allclose(step, free * min(1.0, longest / length), rtol=1e-12)
    assert np.linalg.norm(step) <= longest * (1 + 1e-12)


def test_by_default_it_is_the_law():
    J, error = matrices(0)
    law = fd.FuzzyMapping()
    np.testing.assert_array_equal(SafeStep(law)(Q, J, 1e6 * error), law.step(J, 1e6 * error))


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("longest", [0.5, np.inf])
def test_what_is_not_finite_is_no_step(bad, longest):
    J, error = matrices(1)
    answer = np.ones(7)
    answer[3] = bad
    law = SafeStep(Asks(answer), longest=longest, posture=np.ones(7), posture_gain=0.1)
    np.testing.assert_array_equal(law(Q, J, error), np.zeros(7))


def test_damping_is_handed_on_and_only_then():
    J, error = matrices(2)
    law = Asks(np.ones(7))
    SafeStep(law)(Q, J, error)
    SafeStep(law)(Q, J, error, 0.3)
    assert [len(asked) for asked in law.asked] == [2, 3] and law.asked[1][2] == 0.3
    mapping = fd.FuzzyMapping(iterations=3, damping=0.1)
    damped = SafeStep(mapping)(Q, J, error, 0.4)
    np.testing.assert_allclose(damped, mapping(J, error, 0.4), atol=1e-14)
    assert np.linalg.norm(damped) < np.linalg.norm(SafeStep(mapping)(Q, J, error))


def test_dampings_add_up_as_squares():
    """Of the law and of the supervisor: both are of the scaled Jacobian."""
    J, error = matrices(3)
    both = fd.FuzzyMapping(iterations=3, damping=0.3)(J, error, 0.4)
    np.testing.assert_allclose(both, fd.FuzzyMapping(iterations=3, damping=0.5)(J, error))
    assert fd.FuzzyMapping(iterations=2).takes_damping
    assert fd.FuzzyMapping().takes_damping and not fd.FuzzyMapping("direct").takes_damping


def test_a_posture_is_added_before_the_length_counts():
    J, error = matrices(4)
    law = fd.FuzzyMapping()
    free = SafeStep(law, posture=np.full(7, 0.4), posture_gain=0.5)
    expected = law.step(J, error) + posture_step(J, np.full(7, 0.2))
    np.testing.assert_allclose(free(Q, J, error), expected, atol=1e-12)
    short = SafeStep(law, longest=0.01, posture=np.full(7, 0.4), posture_gain=0.5)
    assert np.linalg.norm(short(Q, J, error)) == pytest.approx(0.01)


def test_limits_weigh_the_columns_that_the_law_sees():
    """Weights of the second pass, by the step of the first; the law's own answer is weighted too."""
    J, error = matrices(5)
    law = Asks([1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    q = np.array([0.95, 0.95, 0.0, 0.0, 0.0, 0.0, 1.0])
    safe = SafeStep(law, limits=LimitWeights(-np.ones(7), np.ones(7), 0.1))
    weights = np.array([0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    np.testing.assert_allclose(safe(q, J, error), weights * law.answer, atol=1e-12)
    np.testing.assert_array_equal(law.asked[0][0], J)
    np.testing.assert_allclose(law.asked[-1][0], J * weights, atol=1e-12)


def stretched(law=None, singularity_nudge=0.01, **options):
    """planar2, stretched along x: the rows x and y of its Jacobian, and the step."""
    J = fd.load_arm("planar2").jacobian(np.zeros(2))[3:5]
    return J, SafeStep(law or fd.FuzzyMapping(), singularity_nudge=singularity_nudge, **options)


@pytest.mark.parametrize("size", [1e-6, 0.05, 0.5])
def test_at_a_dead_point_the_joints_step_aside_in_proportion_to_the_error(size):
    J, safe = stretched()
    error = np.array([-size, 0.0])
    np.testing.assert_array_equal(fd.FuzzyMapping().step(J, error), 0.0)  # the law sees no way
    step = safe(np.zeros(2), J, error)
    np.testing.assert_allclose(step, 0.01 * size * np.array([1.0, -1.0]), rtol=1e-12)
    np.testing.assert_array_equal(step, safe(np.zeros(2), J, error))  # the same each time
    _, stays = stretched(singularity_nudge=0.0)
    np.testing.assert_array_equal(stays(np.zeros(2), J, error), 0.0)


def test_a_law_that_sees_a_way_takes_no_step_aside():
    J, safe = stretched()
    error = np.array([-0.1, 0.01])
    np.testing.assert_array_equal(safe(np.zeros(2), J, error), fd.FuzzyMapping().step(J, error))


def test_where_there_is_no_error_there_is_no_step():
    J, safe = stretched()
    np.testing.assert_array_equal(safe(np.zeros(2), J, np.zeros(2)), 0.0)


def test_a_dead_point_is_where_the_law_s_step_is_short_for_its_error():
    for share, dead in ((0.99, True), (1.01, False)):
        law = Asks([share * DEAD * 0.1, 0.0])
        J, safe = stretched(law)
        step = safe(np.zeros(2), J, np.array([-0.1, 0.0]))
        np.testing.assert_allclose(step - law.answer, dead * 0.001 * np.array([1, -1]), atol=1e-15)


@pytest.mark.parametrize("size", [1, 2, 7])
def test_neighbours_step_aside_against_each_other(size):
    np.testing.assert_array_equal(np.abs(aside(size)), 1.0)
    np.testing.assert_array_equal(aside(size)[1:], -aside(size)[:-1])
    with pytest.raises(ValueError, match="read-only"):
        aside(size)[0] = 2.0


def limited(safe, J, error, **limits):
    """The step inside limits from rest, whether they took a part away, and the bounds."""
    bounds = JointLimits(np.full(7, -3.0), np.full(7, 3.0), period=0.01, **limits)
    low, high = bounds.steady_bounds(Q)
    return *safe.inside(Q, J, error, StepBox(bounds, Q)), low, high


def test_inside_wide_limits_it_is_the_step_itself():
    J, error = matrices(6)
    safe = SafeStep(fd.FuzzyMapping(), longest=0.5, posture=np.ones(7), posture_gain=0.1)
    step, less, *_ = limited(safe, J, error)
    np.testing.assert_array_equal(step, safe(Q, J, error))
    assert not less


@pytest.mark.parametrize("size", [np.nan, np.inf, 3e100])
def test_inside_limits_an_error_that_is_not_finite_asks_for_nothing(size):
    J, _ = matrices(3)
    box = StepBox(JointLimits(-np.ones(7), np.ones(7), period=0.01), Q)
    step, limited = SafeStep(fd.FuzzyMapping()).inside(Q, J, np.array([0.0, size, 0.0]), box)
    assert not step.any() and not limited


@pytest.mark.parametrize("law", [fd.FuzzyMapping(), fd.FuzzyMapping(iterations=3)])
@pytest.mark.parametrize("posture", [None, np.full(7, 0.3)])
def test_one_slow_joint_does_not_hold_back_the_others(law, posture):
    """At a hundredth of the speed it needs; the tool still makes most of the law's motion."""
    speed = np.full(7, 200.0)
    speed[2] = 0.05
    safe = SafeStep(law, longest=0.5, posture=posture, posture_gain=0.1)
    for seed in range(20):
        J, error = matrices(seed)
        free = safe(Q, J, error)
        step, less, low, high = limited(safe, J, error, velocity_limits=speed)
        assert (low <= step).all() and (step <= high).all()
        assert less == (abs(free[2]) > high[2])
        asked = J @ free
        assert np.linalg.norm(J @ step - asked) < 0.5 * np.linalg.norm(asked)


def test_what_can_be_braked_within_its_own_length_counts_as_a_whole():
    J, error = matrices(7)
    safe = SafeStep(fd.FuzzyMapping())
    free = safe(Q, J, error)
    step, less, low, high = limited(safe, J, error, acceleration_limits=300.0)
    assert less and (low <= step).all() and (step <= high).all()
    assert np.abs(step).max() <= np.sqrt(2 * 0.03 * np.abs(free).max())


@pytest.mark.parametrize("accelerations", [np.inf, 5.0])
@pytest.mark.parametrize("native", [False, True])
def test_a_joint_that_does_not_move_the_tool_stays_where_all_others_are_at_their_speed(
    accelerations, native
):
    """Once they are fixed, what is left of the Jacobian is rounding: it must not turn the flange."""
    arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("panda")))
    q = np.array([0.3, -0.6, 0.2, -1.9, 0.4, 1.3, 0.5])
    with nullcontext() if native else numpy_only():
        config = fd.FuzzyIkConfig(
            law=fd.FuzzyMapping.iterated(),
            velocity_limits=[0.01],
            acceleration_limits=[accelerations],
            error_smoothing=0.0,
        )
        cycle = fd.ControlCycle(fd.PositionTask(arm), config)
        state = cycle.start(q)
        for target in np.random.default_rng(0).normal(size=(20, 3)):
            step = cycle.tick(state, target, q).joint_step
            assert np.abs(step[:6]).max() > 1e-5 and step[6] == 0.0
