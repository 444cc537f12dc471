"""The calm: what shakes for no reason is calmed, what has a reason or moves on is not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.calm_rule import AWAKE, DAMPED_FIRST, LEAST_CALM
from fikm_drake.control.motion_windows import MotionWindows

FAR = np.array([0.5, 0.0])
"""An error out of the tolerance [m]."""
REST = np.zeros(2)
"""A target that rests."""


class Loop:
    """A supervision of three joints and two rows with its memory, fed cycle by cycle."""

    def __init__(self, *, damped=True, **config):
        config = fd.GainSupervisorConfig(**config)
        self.law = fd.GainSupervision(2, 3, config, tolerance=1e-3, damped=damped)
        self.memory = self.law.initial_memory()

    def cycles(self, steps, errors=None, targets=None, deviations=None):
        """Feed cycles; returns the calm after each."""
        calms = []
        for k, step in enumerate(steps):
            self.law.remember(
                self.memory,
                FAR if errors is None else errors[k],
                np.asarray(step, dtype=float),
                REST if targets is None else targets[k],
                None if deviations is None else deviations[k],
            )
            calms.append(self.law.calm(self.memory))
        return np.array(calms)


def shaking(cycles, half=1, size=1e-2, joint=1):
    """Steps of one joint of three to and fro, `half` cycles each way."""
    steps = np.zeros((cycles, 3))
    steps[:, joint] = size * np.where(np.arange(cycles) // half % 2, -1.0, 1.0)
    return steps


@pytest.mark.parametrize(("half", "calmed"), [(1, True), (2, True), (7, True), (13, False)])
def test_a_joint_that_shakes_before_a_far_target_is_calmed_and_named(half, calmed):
    """At least six turns in 64 cycles; slower than that it is a motion."""
    loop = Loop()
    calms = loop.cycles(shaking(200, half))
    assert bool(calms[-1] < 0.1) is calmed
    assert loop.law.oscillating_joint(loop.memory) == (1 if calmed else -1)


def test_damping_comes_before_the_gain():
    """All of the damping at a calm of `DAMPED_FIRST`; a law without damping has the gain at once."""
    damped, plain = Loop(), Loop(damped=False)
    for step in shaking(60):
        damped.cycles([step])
        plain.cycles([step])
        calm = damped.law.calm(damped.memory)
        table_1 = damped.law.rules.evaluate(0.0, damped.memory[2])
        factor = damped.law.gain(damped.memory, 0.0) / table_1
        assert factor == pytest.approx(min(1.0, calm / DAMPED_FIRST))
        assert plain.law.gain(plain.memory, 0.0) <= plain.law.calm(plain.memory) * 1.000001
        damping = damped.law.damping(damped.memory)
        assert damping == pytest.approx(0.3 * min(1.0, (1.0 - calm) / (1.0 - DAMPED_FIRST)))
    assert damped.law.calm(damped.memory) < DAMPED_FIRST


@pytest.mark.parametrize("size", [5e-7, 3e-4])
def test_a_joint_that_hardly_moves_beside_the_others_calms_nothing(size):
    """±5e-7 rad beside 1e-2 rad a cycle: once it stopped the whole arm."""
    steps = shaking(300, size=size)
    steps[:, 0] = 1e-2
    assert (Loop().cycles(steps) == 1.0).all()


def test_a_motion_that_leads_somewhere_calms_nothing():
    """Two joints shake a little on the way; the net motion is most of the path."""
    steps = shaking(300, size=4e-3)
    steps[:, 0] = steps[:, 2] = 1e-2
    assert (Loop().cycles(steps) == 1.0).all()


@pytest.mark.parametrize("size", [1e-3, 1e-4, 0.0])
def test_within_the_tolerance_nothing_is_calmed(size):
    """At rest and in noise; then the target starts and finds the whole gain."""
    loop = Loop()
    assert (loop.cycles(shaking(200), errors=[np.array([size, 0.0])] * 200) == 1.0).all()
    moves = np.tile([1e-2, 1e-2, 0.0], (20, 1))
    calms = loop.cycles(moves, errors=np.linspace(1e-3, 1e-2, 20)[:, None] * [1.0, 0.0])
    assert (calms == 1.0).all()


def test_within_the_tolerance_the_gain_recovers():
    loop = Loop()
    low = loop.cycles(shaking(60))[-1]
    calms = loop.cycles(np.zeros((100, 3)), errors=[np.array([5e-4, 0.0])] * 100)
    assert low < 0.1 and calms[-1] == 1.0
    assert (np.diff(calms) >= 0.0).all()


@pytest.mark.parametrize("noise", [1e-3, 1e-2])
def test_what_the_targets_own_jitter_explains_is_no_oscillation(noise):
    """The error shakes with the target, and the joints after it."""
    rng = np.random.default_rng(0)
    targets = noise * rng.normal(size=(400, 2))
    steps = np.column_stack([0.3 * targets, np.zeros(400)])
    loop = Loop()
    assert (loop.cycles(steps, errors=FAR + 0.7 * targets, targets=targets) == 1.0).all()
    # The same joints and errors before a target that rests.
    assert Loop().cycles(steps, errors=FAR + 0.7 * targets).min() < 0.5


@given(st.integers(0, 10**6))
def test_rounding_of_a_target_that_goes_straight_on_is_no_jitter(seed):
    """Path less net motion is of the last bits; before an error that stays it decided by chance."""
    way = np.random.default_rng(seed).normal(size=2)
    targets = 1e-4 * np.arange(60)[:, None] * way
    calms = Loop().cycles(shaking(60), targets=targets)
    np.testing.assert_array_equal(calms, Loop().cycles(shaking(60)))


def test_what_noise_of_the_measured_joints_explains_is_no_oscillation():
    rng = np.random.default_rng(1)
    noise = 1e-3 * rng.normal(size=(400, 3))
    assert (Loop().cycles(0.3 * noise, deviations=noise) == 1.0).all()
    assert Loop().cycles(0.3 * noise).min() < 0.5
    # A robot that is a cycle late strays by the last step, which explains nothing.
    steps = shaking(100)
    assert Loop().cycles(steps, deviations=-steps).min() < 0.1


def test_noise_of_the_measured_joints_is_judged_over_the_slow_window():
    """In ten cycles noise is little or much by chance; one still period in it calms nothing."""
    rng = np.random.default_rng(1)
    noise = 1e-3 * rng.normal(size=(400, 3))
    noise[200:208] = noise[200]
    assert (Loop().cycles(shaking(400, size=4e-4), deviations=noise) == 1.0).all()


def test_a_target_that_jumps_wakes_at_once():
    loop = Loop()
    loop.cycles(shaking(200))
    calms = loop.cycles([[1e-6, 0, 0]] * 2, targets=[REST, np.array([0.1, 0.0])])
    assert calms[0] < 1e-3 and AWAKE <= calms[1] < 0.5


def test_an_error_that_falls_wakes_and_a_flat_one_calms_further():
    loop = Loop()
    loop.cycles(shaking(60))
    creeping = loop.cycles(np.full((400, 3), 1e-7))  # toward its best point
    assert creeping[-1] == LEAST_CALM
    falls = 0.5 * 0.98 ** np.arange(30)
    calms = loop.cycles(np.full((30, 3), 1e-3), errors=falls[:, None] * [1.0, 0.0])
    assert calms[-1] == 1.0


@pytest.mark.parametrize(
    ("fall", "way", "calmer"),
    [(0.0, 0.0, True), (-1e-4, 0.0, True), (4e-3, 0.0, False), (0.0, 2e-3, False)],
)
def test_a_calmed_arm_that_creeps_becomes_calmer_unless_it_gets_somewhere(fall, way, calmer):
    """It would creep on to the next singular posture and shake there; 1 mm a cycle is no rest."""
    loop = Loop()
    low = loop.cycles(shaking(10))[-1]
    assert DAMPED_FIRST < low < 1.0
    k = np.arange(200)[:, None]
    errors = 0.5 * (1.0 - fall) ** k * [1.0, 0.0]
    calms = loop.cycles(np.tile([1e-3, 0, 0], (200, 1)), errors, targets=way * k * [0.0, 1.0])
    assert bool(calms[-1] < 1e-3) is calmer
    assert calmer or calms[-1] >= calms[15] > 0.1


@pytest.mark.parametrize("half", [3, 4, 5])
def test_half_a_swing_wakes_nothing(half):
    """The error falls in each half of a swing and rises in the other, before a target that rests."""
    swing = shaking(300, half)
    loop = Loop()
    calms = loop.cycles(swing, errors=FAR - 0.5 * np.cumsum(swing, axis=0)[:, 1:])
    first = np.flatnonzero(calms < DAMPED_FIRST)[0]
    assert first < 100
    assert (np.diff(calms[first:]) <= 0.0).all() and calms[-1] < 1e-3


def test_before_a_moving_target_far_away_the_gain_comes_back_and_the_damping_stays():
    """The error changes with the target: 0.5 m away, 5 mm a cycle along."""
    loop = Loop()
    loop.cycles(shaking(100))
    k = np.arange(200)
    targets = np.column_stack([np.zeros(200), 5e-3 * k])
    errors = np.column_stack([0.5 + 0.02 * np.sin(k / 8), 0.01 * np.ones(200)])
    loop.cycles(np.tile([3e-3, 0, 0], (200, 1)), errors=errors, targets=targets)
    assert loop.law.calm(loop.memory) == pytest.approx(DAMPED_FIRST)
    assert loop.law.damping(loop.memory) == pytest.approx(0.3)


def test_behind_a_moving_target_that_is_near_all_comes_back():
    loop = Loop()
    loop.cycles(shaking(100))
    targets = np.column_stack([np.zeros(60), 5e-3 * np.arange(60)])
    errors = np.column_stack([np.zeros(60), 0.02 + 1e-3 * np.arange(60)])
    calms = loop.cycles(np.tile([3e-3, 0, 0], (60, 1)), errors=errors, targets=targets)
    assert calms[-1] == 1.0


def test_what_does_not_move_is_not_oscillating():
    """4e-6 rad to and fro off a planar arm's plane: calm, at rest, and so it is reported."""
    loop = Loop()
    loop.cycles(shaking(100, size=4e-6))
    assert not loop.law.oscillating(loop.memory) and loop.law.calmed(loop.memory)
    loop = Loop(calming=1.0)
    loop.cycles(shaking(100, size=1e-2))
    assert loop.law.oscillating(loop.memory) and not loop.law.calmed(loop.memory)


@given(
    st.lists(st.tuples(*[st.floats()] * 7), max_size=30),
    st.booleans(),
)
def test_no_input_leaves_a_memory_that_is_not_finite(cycles, damped):
    loop = Loop(damped=damped)
    for a, b, *step, x, y in cycles:
        with np.errstate(all="ignore"):
            loop.cycles([step], [np.array([a, b])], [np.array([x, y])], [np.array(step)])
        assert np.isfinite(loop.memory).all()
        assert LEAST_CALM <= loop.law.calm(loop.memory) <= 1.0


@pytest.mark.parametrize("joints", [1, 53, 200])
def test_any_number_of_joints(joints):
    law = fd.GainSupervision(3, joints, tolerance=1e-3)
    memory = law.initial_memory()
    for k in range(40):
        step = np.zeros(joints)
        step[-1] = 1e-2 * (-1) ** k
        law.remember(memory, np.array([0.1, 0.0, 0.0]), step, np.zeros(3))
    assert law.oscillating_joint(memory) == joints - 1 and law.calm(memory) < 0.1


def test_windows_are_the_sums_of_their_cycles():
    """Against sums over whole histories: exactly in the fast window, a block at a time in the slow one."""
    windows = MotionWindows(2, 3, 4, window=10, slow_window=64)
    memory = np.zeros(np.dtype(windows.fields).itemsize // 8)
    windows.start(memory)
    rng = np.random.default_rng(2)
    steps, errors = 1e-2 * rng.normal(size=(150, 3)), rng.normal(size=(150, 2))
    targets, sizes = rng.normal(size=(150, 4)), rng.random(150)
    turned = [np.flatnonzero(rng.random(3) < 0.3).tolist() for _ in range(150)]
    for k in range(150):
        size = np.linalg.norm(steps[k])
        windows.add(memory, sizes[k], errors[k], targets[k], steps[k], size, turned[k])
        fast, slow = windows.motions(memory)
        assert windows.most_changes(memory) == slow.changes >= fast.changes
        assert windows.path_step(memory) == pytest.approx(fast.path_step, rel=1e-12)
        blocks = k // 7 - 8  # the first that is still known
        for motion, first in ((fast, k - 8), (slow, 7 * blocks)):
            since = slice(max(0, first), k + 1)
            path = np.linalg.norm(steps[since], axis=1).sum()
            assert motion.path_step == pytest.approx(path, rel=1e-12)
            assert motion.net_step == pytest.approx(np.linalg.norm(steps[since].sum(axis=0)))
            before = max(0, since.start - 1)
            gone = np.linalg.norm(targets[k] - targets[before])
            assert motion.net_target == pytest.approx(gone, abs=1e-12)
            moved = np.linalg.norm(np.diff(errors[before : k + 1], axis=0), axis=1).sum()
            assert motion.path_error == pytest.approx(moved, abs=1e-12)
            assert motion.fall == pytest.approx(sizes[before] - sizes[k], abs=1e-12)
            assert motion.mean_error == pytest.approx(sizes[since].mean(), rel=1e-12)
