"""The supervisor against a naive reading of section 2.7, and of the calm that is past the paper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.gain_supervision import AWAKE, CALM, LEAST_CALM


class NaiveSupervision:
    """Section 2.7 with whole histories: means by numpy, sign changes counted over the window."""

    def __init__(self, config):
        self.config = config
        self.errors = []  # finite and not zero
        self.signs = []  # of each joint, of its last motion

    def changes(self, window=None):
        window = np.array(self.signs[-(window or self.config.window) :])
        if len(window) < 2:
            return 0
        return int((window[1:] * window[:-1] < 0).sum(axis=0).max())

    def gain(self, error):
        config = self.config
        if error == 0.0:
            relative = 0.0
        elif not np.isfinite(error):
            relative = np.inf
        else:
            errors = [*self.errors, error][-config.window :]
            full = len(errors) == config.window
            relative = error / np.mean(errors) if full else config.error_breakpoints[1]
        off = np.interp(relative, config.error_breakpoints, config.gains)
        on = np.interp(relative, config.error_breakpoints, config.oscillating_gains)
        return on if self.changes() >= config.sign_changes else off

    def remember(self, error, joint_step):
        if np.isfinite(error) and error != 0.0:
            self.errors.append(error)
        last = self.signs[-1] if self.signs else np.zeros(len(joint_step))
        moves = np.isfinite(joint_step) & (np.abs(joint_step) > self.config.dead_band)
        self.signs.append(np.where(moves, np.sign(joint_step), last))


class NaiveCalm(NaiveSupervision):
    """The same with the calm: three rules on whole histories."""

    def __init__(self, config, error_limit):
        super().__init__(config)
        self.error_limit = error_limit
        self.calm = 1.0
        self.path, self.motions = [0.0], [0.0]  # error and length of the joint step of good cycles
        self.mean = None

    def gain(self, error):
        return self.calm * super().gain(min(error, self.error_limit) if error < np.inf else error)

    def remember(self, error, joint_step):
        config, finite = self.config, np.isfinite(error)
        super().remember(min(error, self.error_limit) if finite else error, joint_step)
        if finite and error > 0.0:
            first = self.mean is None
            self.mean = error if first else self.mean + (error - self.mean) / config.slow_window
        self.error = error
        falls = self.path[-1] - error > 0.01 * self.calm * self.path[-1]
        moved = abs(error - self.path[-1]) > 10.0 * self.motions[-1]
        if finite and moved and self.calm < 1.0:
            self.calm = max(self.calm, 0.25)
            self.signs = self.signs[-1:]
        elif finite and any(self.rules()):
            self.calm = max(LEAST_CALM, self.calm * self.config.calming)
        elif finite and falls:
            self.calm = min(1.0, self.calm * self.config.recovery)
        if finite:
            self.path.append(error)
            self.motions.append(np.nan_to_num(np.linalg.norm(joint_step), nan=0.0, posinf=0.0))

    def rules(self):
        """Whether a joint oscillates in the window; whether in the slow one while the error stays."""
        config, last = self.config, self.errors[-self.config.window :]
        stays = len(last) == config.window and min(last) > 0.5 * max(last)
        stays = stays and self.error > 0.85 * self.mean
        fast = self.changes() >= config.sign_changes
        return fast, stays and self.changes(config.slow_window) >= config.slow_sign_changes


def errors_and_steps(rng, cycles, joints, smooth):
    """A long sequence with zeros, NaN and inf in it; `smooth`: how rarely a sign changes."""
    errors = 10.0 ** rng.uniform(-6, 0, cycles)
    kind = rng.random(cycles)
    errors[kind < 0.05] = 0.0
    errors[(kind > 0.05) & (kind < 0.07)] = np.nan
    errors[(kind > 0.07) & (kind < 0.09)] = np.inf
    signs = np.cumprod(np.where(rng.random((cycles, joints)) < smooth, 1, -1), axis=0)
    steps = signs * 10.0 ** rng.uniform(-14, -1, (cycles, joints))
    kind = rng.random((cycles, joints))
    steps[kind < 0.05] = 0.0
    steps[(kind > 0.05) & (kind < 0.06)] = np.nan
    steps[(kind > 0.06) & (kind < 0.07)] = -np.inf
    return errors, steps


def paper(**constants):
    """Section 2.7 without the calm."""
    return fd.GainSupervisorConfig(calming=1.0, **constants)


CONFIGS = {
    "paper": paper(),
    "early": paper(error_breakpoints=[0.1, 0.5, 1.0], sign_changes=3, window=7),
    "long": paper(window=40, sign_changes=11, dead_band=1e-6),
    "short": paper(window=2, sign_changes=1),
}


@pytest.mark.parametrize("name", CONFIGS)
@pytest.mark.parametrize(("joints", "smooth"), [(1, 0.5), (7, 0.8), (7, 0.4), (52, 0.97)])
def test_long_random_sequences_against_the_naive_reading(name, joints, smooth):
    config = CONFIGS[name]
    law, naive = fd.GainSupervision(config), NaiveSupervision(config)
    memory = law.initial_memory()
    rng = np.random.default_rng(joints)
    seen = set()
    for error, step in zip(*errors_and_steps(rng, 1500, joints, smooth)):
        assert law.gain(memory, error) == pytest.approx(naive.gain(error), rel=1e-12)
        oscillating = naive.changes() >= config.sign_changes
        assert law.oscillating(memory) == oscillating
        seen.add(oscillating)
        assert (law.calm(memory), law.damping(memory)) == (1.0, 0.0)
        law.remember(memory, error, step)
        naive.remember(error, step)
    if joints < 52:
        assert seen == {False, True}


CALMS = {
    "default": fd.GainSupervisorConfig(),
    "gentle": fd.GainSupervisorConfig(calming=0.99, recovery=1.01, calm_damping=0.1),
    "slow": fd.GainSupervisorConfig(sign_changes=5, slow_window=30, slow_sign_changes=6),
    "shorter": fd.GainSupervisorConfig(window=12, slow_window=12, slow_sign_changes=3),
}


@pytest.mark.parametrize("name", CALMS)
@pytest.mark.parametrize(("joints", "smooth", "limit"), [(1, 0.8, np.inf), (7, 0.9, 0.01)])
def test_the_calm_against_the_naive_reading(name, joints, smooth, limit):
    config = CALMS[name]
    law, naive = fd.GainSupervision(config, error_limit=limit), NaiveCalm(config, limit)
    memory = law.initial_memory()
    rng = np.random.default_rng(joints)
    errors, steps = errors_and_steps(rng, 3000, joints, smooth)
    # By turns an arm that shakes and gets nowhere, and all that can be.
    rests = np.arange(3000) // 500 % 2 == 0
    errors[rests] = 0.03 * 10 ** (0.003 * rng.normal(size=1500))
    moves = np.isfinite(steps) & (steps != 0) & rests[:, None]
    steps = np.where(moves, np.sign(steps) * np.maximum(np.abs(steps), 1e-3), steps)
    least, most, seen = 1.0, 0.0, set()
    for error, step in zip(errors, steps):
        assert law.gain(memory, error) == pytest.approx(naive.gain(error), rel=1e-12)
        law.remember(memory, error, step)
        naive.remember(error, step)
        calm = law.calm(memory)
        assert calm == pytest.approx(naive.calm, rel=1e-12)
        assert law.damping(memory) == pytest.approx(config.calm_damping * (1 - calm), abs=1e-15)
        seen.add(naive.rules())
        if calm > least:
            most = max(most, calm)
        least = min(least, calm)
    assert {(False, False), (False, True), (True, False)} <= seen
    assert LEAST_CALM <= least < 0.8 and most > 1.2 * least  # it went down and came back


def test_errors_of_very_different_size():
    """The average is a sum of what is remembered, not a difference of sums."""
    law, naive = fd.GainSupervision(), NaiveSupervision(fd.GainSupervisorConfig())
    memory = law.initial_memory()
    for error in [1e3] * 10 + [1e-14, 3e-14] * 10 + [1e6] * 12 + [1e-14] * 12:
        assert law.gain(memory, error) == pytest.approx(naive.gain(error), rel=1e-12)
        law.remember(memory, error, np.zeros(3))
        naive.remember(error, np.zeros(3))


errors = st.one_of(st.floats(0.0, 1e150), st.sampled_from([0.0, np.nan, np.inf, 1e-300, 5e-324]))


@given(st.lists(st.tuples(errors, st.floats(-1, 1), st.floats(-1, 1)), max_size=40))
def test_gains_stay_within_table_1_times_the_calm(cycles):
    law = fd.GainSupervision()
    memory = law.initial_memory()
    for error, *steps in cycles:
        low, high = (0.03, 0.4) if law.oscillating(memory) else (0.8, 2.6)
        calm = law.calm(memory)
        assert LEAST_CALM <= calm <= 1.0
        assert low * calm * (1 - 1e-12) <= law.gain(memory, error) <= high * calm * (1 + 1e-12)
        law.remember(memory, error, np.array(steps))
    assert np.isfinite(memory).all()


def oscillate(signs, law=None):
    """The memory after these steps of one joint of three; the other two keep their direction."""
    law = law or fd.GainSupervision(paper())
    memory = law.initial_memory()
    for sign in signs:
        law.remember(memory, 0.01, np.array([1e-3, 1e-3 * sign, -1e-3]))
    return law, memory


@pytest.mark.parametrize(
    ("signs", "expected"),
    [
        ("+-+-", False),  # 3 changes
        ("+-+-+", True),  # 4
        ("++--++--++", True),  # 4 in ten
        ("++--++---+", True),
        ("++--++----", False),
        ("+++---+++-", False),  # 3: the paper's detector sleeps at period 6
        ("+-+-++++++", True),
        ("+-+-+++++++", False),  # the first of four is eleven steps old
        ("+-+-+++++-", True),  # 4, the first of them 8 steps old
        ("+-+-+++++++-", False),  # by then two of them are older than ten steps
        ("+0-0+0-0+", True),  # a pause between is no excuse
        ("+0+0+0+0+", False),
        ("----------", False),
    ],
)
def test_oscillation_is_four_changes_in_ten_steps(signs, expected):
    law, memory = oscillate({"+": 1, "-": -1, "0": 0}[s] for s in signs)
    assert law.oscillating(memory) is expected
    for _ in range(10):
        law.remember(memory, 0.01, np.full(3, 1e-3))
    assert law.oscillating(memory) is False


CYCLES = [0.01, np.full(3, 1e-3)]
"""A cycle in which nothing oscillates and nothing is gained."""


def calmed():
    """A law and its memory after an oscillation of the second joint, which now rests."""
    law = fd.GainSupervision(fd.GainSupervisorConfig(slow_sign_changes=63))
    law, memory = oscillate([(-1) ** k for k in range(14)], law)
    assert law.calm(memory) == pytest.approx(0.8**10)  # the fourth change is of the fifth step
    for _ in range(9):  # until the changes are out of the window
        law.remember(memory, *CYCLES)
    assert law.calm(memory) == pytest.approx(0.8**16)
    return law, memory, law.calm(memory)


def test_an_oscillation_calms_and_what_follows_decides():
    """Down by 0.8 a cycle while it lasts; it rests while the error stays, and wakes as it falls."""
    law, memory, rest = calmed()
    for _ in range(100):
        law.remember(memory, *CYCLES)
    assert law.calm(memory) == rest
    error = 0.01
    for k in range(1, 4):
        error *= 1 - 0.02 * rest  # twice what counts as progress
        law.remember(memory, error, CYCLES[1])
        assert law.calm(memory) == pytest.approx(rest * 1.2**k)
    law.remember(memory, error * (1 - 0.005 * rest), CYCLES[1])  # half of it: none
    assert law.calm(memory) == pytest.approx(rest * 1.2**3)
    for _ in range(40):
        error *= 0.95
        law.remember(memory, error, CYCLES[1])
    assert law.calm(memory) == 1.0


@pytest.mark.parametrize("change", [0.5, -0.5, 0.02, -0.02])
def test_a_target_that_moves_wakes_the_arm(change):
    """An error that changes by more than ten times the joint motion did not change by it."""
    law, memory, rest = calmed()
    law.remember(memory, 1.0, CYCLES[1])  # 0.99 m by 0.0017 rad
    assert rest < AWAKE == law.calm(memory)
    law.remember(memory, 1.0 + change, CYCLES[1])
    assert law.calm(memory) == AWAKE
    law.remember(memory, 1.0 + change + 0.01, CYCLES[1])  # less than 10 · 0.0017: by the joints
    assert law.calm(memory) == AWAKE
    for k in range(4):  # and what was seen before the target moved is forgotten
        law.remember(memory, 1.0 + change, np.array([1e-3, (-1.0) ** k * 1e-3, 1e-3]))
        assert not law.oscillating(memory)


@pytest.mark.parametrize("calm", [0.3, 0.9])
def test_a_target_that_moves_never_calms(calm):
    law = fd.GainSupervision()
    memory = law.initial_memory()
    memory[CALM] = calm
    law.remember(memory, 1.0, CYCLES[1])
    assert law.calm(memory) == calm


def test_a_calm_gain_is_never_lost():
    law, memory = oscillate([(-1) ** k for k in range(200)], fd.GainSupervision())
    assert law.calm(memory) == LEAST_CALM
    assert law.gain(memory, 0.01) == pytest.approx(0.4 * LEAST_CALM)


@pytest.mark.parametrize(
    ("half", "calmed"), [(5, True), (9, True), (12, True), (13, False), (20, False)]
)
def test_a_slow_oscillation_calms_too(half, calmed):
    """Six changes in 64 steps: a half period of at most twelve, five of which are within 63 cycles."""
    law = fd.GainSupervision()
    law, memory = oscillate([(-1) ** (k // half) for k in range(300)], law)
    assert not law.oscillating(memory)
    assert (law.calm(memory) < 1.0) is calmed


def test_a_slow_oscillation_about_a_target_that_shakes_does_not_calm():
    """The error then goes through zero, or nearly; what counts is that it is no lasting one."""
    law = fd.GainSupervision()
    memory = law.initial_memory()
    for k in range(300):
        error = 0.01 * (1.1 + np.sin(2 * np.pi * k / 14))
        law.remember(memory, error, 1e-3 * np.full(3, (-1.0) ** (k // 7)))
    assert law.calm(memory) == 1.0


def test_what_is_not_finite_neither_calms_nor_wakes():
    law, memory, rest = calmed()
    for error in (np.nan, np.inf, np.nan):
        law.remember(memory, error, np.full(3, np.nan))
        assert law.calm(memory) == rest
    law.remember(memory, *CYCLES)
    assert law.calm(memory) == rest and np.isfinite(memory).all()


def test_for_the_gain_an_error_is_at_most_the_limit():
    law, free = fd.GainSupervision(error_limit=0.2), fd.GainSupervision()
    memory, other = law.initial_memory(), free.initial_memory()
    for k in range(30):
        error = 0.05 + 0.05 * (k % 7)
        assert law.gain(memory, error) == free.gain(other, min(error, 0.2))
        law.remember(memory, error, np.ones(2))
        free.remember(other, min(error, 0.2), np.ones(2))
    assert law.gain(memory, np.inf) == free.gain(other, np.inf) == 0.8


def test_joints_are_counted_one_by_one():
    """Three changes of each of three joints are not an oscillation."""
    law = fd.GainSupervision()
    memory = law.initial_memory()
    for k in range(9):
        signs = [(-1) ** min(max(k - start, 0), 3) for start in (0, 2, 4)]
        law.remember(memory, 0.01, 1e-3 * np.array(signs, dtype=float))
        assert not law.oscillating(memory)
    law.remember(memory, 0.01, 1e-3 * np.array([-1.0, -1.0, 1.0]))
    assert law.oscillating(memory)


def test_steps_within_the_dead_band_have_no_sign():
    law, memory = oscillate([1e-10 * (-1) ** k for k in range(20)])
    assert not law.oscillating(memory)
    tiny = fd.GainSupervision(fd.GainSupervisorConfig(dead_band=1e-14))
    law, memory = oscillate([1e-10 * (-1) ** k for k in range(20)], tiny)
    assert law.oscillating(memory)


@pytest.mark.parametrize(
    ("relative", "off", "on"),
    [(0.0, 1.0, 0.1), (1.0, 2.6, 0.4), (2.0, 0.8, 0.03), (9.0, 0.8, 0.03)],
)
def test_table_1(relative, off, on):
    """The gains at the peaks of S, M and B, before the calm."""
    for gain, signs in ((off, [1] * 10), (on, [(-1) ** k for k in range(10)])):
        law, memory = oscillate(signs)
        # x over the mean of nine errors of 0.01 and x itself is `relative`.
        error = 0.09 * relative / (10 - relative)
        assert law.gain(memory, error) == pytest.approx(gain, rel=1e-12)


def test_table_1_can_be_printed():
    rules = fd.GainSupervision().rules
    lines = [line.split() for line in rules.table(2).splitlines()]
    assert lines[0][-2:] == ["OFF", "ON"]
    assert lines[1:] == [["S", "1.00", "0.10"], ["M", "2.60", "0.40"], ["B", "0.80", "0.03"]]
    assert "IF error is M AND sign changes is OFF THEN K is 2.6" in rules.rules()
    assert rules.size == 6
    np.testing.assert_array_equal(rules.first.knots, [0, 1, 2])
    np.testing.assert_array_equal(rules.second.knots, [3, 4])


def test_before_ten_errors_are_known_an_error_is_medium():
    law = fd.GainSupervision()
    memory = law.initial_memory()
    for k in range(9):
        assert law.gain(memory, 10.0**-k) == pytest.approx(2.6)
        law.remember(memory, 10.0**-k, np.ones(2))
    assert law.gain(memory, 10.0) == pytest.approx(0.8)


def test_asking_changes_nothing():
    law, memory = oscillate([1, -1, 1])
    before = memory.copy()
    law.gain(memory, 0.3)
    law.oscillating(memory), law.calm(memory), law.damping(memory)
    np.testing.assert_array_equal(memory, before)


def test_two_memories_of_one_law_are_independent():
    law, calm = oscillate([1] * 10)
    _, rough = oscillate([(-1) ** k for k in range(10)], law)
    assert not law.oscillating(calm) and law.oscillating(rough)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"window": 1}, ["window", "1", "2"]),
        ({"window": 10.5}, ["window", "10.5", "integer"]),
        ({"sign_changes": 0}, ["sign_changes", "0", "9"]),
        ({"sign_changes": 10}, ["sign_changes", "10", "9"]),
        ({"error_breakpoints": [0.0, 1.0]}, ["error_breakpoints", "three", "[0.0, 1.0]"]),
        ({"error_breakpoints": [0.0, 2.0, 1.0]}, ["error_breakpoints", "increase", "2.0, 1.0"]),
        ({"error_breakpoints": [0.0, np.nan, 1.0]}, ["error_breakpoints", "nan"]),
        ({"error_breakpoints": [0.0, 1.0, np.inf]}, ["error_breakpoints", "finite", "inf"]),
        ({"gains": [1.0]}, ["gains", "three", "[1.0]"]),
        ({"gains": [1.0, -2.6, 0.8]}, ["gains", "-2.6", "negative"]),
        ({"gains": [1.0, np.inf, 0.8]}, ["gains", "inf", "finite"]),
        ({"oscillating_gains": [0.1, 0.4, np.nan]}, ["oscillating_gains", "nan"]),
        ({"dead_band": -1.0}, ["dead_band", "-1.0", "negative"]),
        ({"dead_band": np.inf}, ["dead_band", "inf", "finite"]),
        ({"initial_gain": np.nan}, ["initial_gain", "nan", "finite"]),
        ({"calming": 0.0}, ["calming", "0.0", "(0, 1]"]),
        ({"calming": 1.1}, ["calming", "1.1", "(0, 1]"]),
        ({"calming": np.nan}, ["calming", "nan"]),
        ({"recovery": 1.0}, ["recovery", "1.0", "above 1"]),
        ({"recovery": np.inf}, ["recovery", "inf", "finite"]),
        ({"recovery": np.nan}, ["recovery", "nan"]),
        ({"calm_damping": -0.1}, ["calm_damping", "-0.1", "negative"]),
        ({"calm_damping": np.nan}, ["calm_damping", "nan", "finite"]),
        ({"slow_window": 9}, ["slow_window", "9", "10"]),
        ({"slow_window": 64.0}, ["slow_window", "64.0", "integer"]),
        ({"slow_sign_changes": 0}, ["slow_sign_changes", "0", "63"]),
        ({"slow_sign_changes": 64}, ["slow_sign_changes", "64", "63"]),
        ({"slow_window": 20, "slow_sign_changes": 20}, ["slow_sign_changes", "20", "19"]),
    ],
)
def test_errors_name_the_bad_value_and_the_valid_ones(arguments, words):
    config = fd.GainSupervisorConfig(**arguments)
    for check in (config.validate, lambda: fd.GainSupervision(config)):
        with pytest.raises(ValueError) as error:
            check()
        for word in words:
            assert word in str(error.value)
