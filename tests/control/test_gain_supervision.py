"""The supervisor against a naive reading of section 2.7, and of the calm that is past the paper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.calm_rule import LEAST_CALM

AT_REST = np.zeros(1)
"""The target's coordinates."""


def remember(law, memory, error, joint_step):
    """A cycle with one row of error and a target that rests."""
    law.remember(memory, np.array([error]), np.asarray(joint_step, dtype=float), AT_REST)


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
@pytest.mark.parametrize(("joints", "smooth"), [(1, 0.5), (7, 0.8), (7, 0.4), (70, 0.97)])
def test_long_random_sequences_against_the_naive_reading(name, joints, smooth):
    config = CONFIGS[name]
    law, naive = fd.GainSupervision(1, joints, config), NaiveSupervision(config)
    memory = law.initial_memory()
    rng = np.random.default_rng(joints)
    seen = set()
    for error, step in zip(*errors_and_steps(rng, 1500, joints, smooth)):
        assert law.gain(memory, error) == pytest.approx(naive.gain(error), rel=1e-12)
        oscillating = naive.changes() >= config.sign_changes
        assert oscillating or not law.oscillating(memory)  # what is tiny is at rest
        seen.add(oscillating)
        assert (law.calm(memory), law.damping(memory)) == (1.0, 0.0)
        remember(law, memory, error, step)
        naive.remember(error, step)
    if joints < 70:
        assert seen == {False, True}


def test_errors_of_very_different_size():
    """The average is a sum of what is remembered, not a difference of sums."""
    law, naive = fd.GainSupervision(1, 3), NaiveSupervision(fd.GainSupervisorConfig())
    memory = law.initial_memory()
    for error in [1e3] * 10 + [1e-14, 3e-14] * 10 + [1e6] * 12 + [1e-14] * 12:
        assert law.gain(memory, error) == pytest.approx(naive.gain(error), rel=1e-12)
        remember(law, memory, error, np.zeros(3))
        naive.remember(error, np.zeros(3))


errors = st.one_of(st.floats(0.0, 1e150), st.sampled_from([0.0, np.nan, np.inf, 1e-300, 5e-324]))


@given(st.lists(st.tuples(errors, st.floats(-1, 1), st.floats(-1, 1)), max_size=40))
def test_gains_stay_within_table_1_times_the_calm(cycles):
    law = fd.GainSupervision(1, 2)
    memory = law.initial_memory()
    for error, *steps in cycles:
        low, high = (0.03, 0.4) if law.oscillating(memory) else (0.8, 2.6)
        calm = law.calm(memory)
        assert LEAST_CALM <= calm <= 1.0
        assert low * calm * (1 - 1e-12) <= law.gain(memory, error) <= high * calm * (1 + 1e-12)
        remember(law, memory, error, np.array(steps))
    assert np.isfinite(memory).all()


def oscillate(signs, law=None):
    """The memory after these steps of one joint of three; the other two keep their direction."""
    law = law or fd.GainSupervision(1, 3, paper())
    memory = law.initial_memory()
    for sign in signs:
        remember(law, memory, 0.01, np.array([1e-3, 1e-3 * sign, -1e-3]))
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
        remember(law, memory, 0.01, np.full(3, 1e-3))
    assert law.oscillating(memory) is False


def test_a_calm_gain_is_never_lost():
    law = fd.GainSupervision(1, 3)
    memory = law.initial_memory()
    for k in range(200):
        remember(law, memory, 0.01, [0.0, 1e-3 * (-1) ** k, 0.0])
    assert law.calm(memory) == LEAST_CALM
    assert law.gain(memory, 0.01) == pytest.approx(0.4 * LEAST_CALM)


def test_for_the_gain_an_error_is_at_most_the_limit():
    law, free = fd.GainSupervision(1, 2, error_limit=0.2), fd.GainSupervision(1, 2)
    memory, other = law.initial_memory(), free.initial_memory()
    for k in range(30):
        error = 0.05 + 0.05 * (k % 7)
        assert law.gain(memory, error) == free.gain(other, min(error, 0.2))
        remember(law, memory, error, np.ones(2))
        remember(free, other, min(error, 0.2), np.ones(2))
    assert law.gain(memory, np.inf) == free.gain(other, np.inf) == 0.8


def test_joints_are_counted_one_by_one():
    """Three changes of each of three joints are not an oscillation."""
    law = fd.GainSupervision(1, 3)
    memory = law.initial_memory()
    for k in range(9):
        signs = [(-1) ** min(max(k - start, 0), 3) for start in (0, 2, 4)]
        remember(law, memory, 0.01, 1e-3 * np.array(signs, dtype=float))
        assert not law.oscillating(memory)
    remember(law, memory, 0.01, 1e-3 * np.array([-1.0, -1.0, 1.0]))
    assert law.oscillating(memory)


def test_steps_within_the_dead_band_have_no_sign():
    law, memory = oscillate([1e-10 * (-1) ** k for k in range(20)])
    assert not law.oscillating(memory)
    tiny = fd.GainSupervision(1, 3, fd.GainSupervisorConfig(dead_band=1e-14))
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
    rules = fd.GainSupervision(1, 3).rules
    lines = [line.split() for line in rules.table(2).splitlines()]
    assert lines[0][-2:] == ["OFF", "ON"]
    assert lines[1:] == [["S", "1.00", "0.10"], ["M", "2.60", "0.40"], ["B", "0.80", "0.03"]]
    assert "IF error is M AND sign changes is OFF THEN K is 2.6" in rules.rules()
    assert rules.size == 6
    np.testing.assert_array_equal(rules.first.knots, [0, 1, 2])
    np.testing.assert_array_equal(rules.second.knots, [3, 4])


def test_before_ten_errors_are_known_an_error_is_medium():
    law = fd.GainSupervision(1, 3)
    memory = law.initial_memory()
    for k in range(9):
        assert law.gain(memory, 10.0**-k) == pytest.approx(2.6)
        remember(law, memory, 10.0**-k, np.ones(3))
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
    for check in (config.validate, lambda: fd.GainSupervision(1, 3, config)):
        with pytest.raises(ValueError) as error:
            check()
        for word in words:
            assert word in str(error.value)
