"""Tables 1 and 2 of the paper as starts, and their calibration."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.solvers.labvolt import calibration
from fikm_drake.solvers.labvolt.calibration import APART, FIRST_PEAKS, calibrate
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts, default_starts
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.plane_targets import random_targets

TABLE_2 = {
    ("small", "small"): "ddu",
    ("small", "mid"): "ddm",
    ("small", "large"): "dmm",
    ("mid", "small"): "ddu",
    ("mid", "mid"): "ddu",
    ("mid", "large"): "mmm",
    ("large", "small"): "uud",
    ("large", "mid"): "mud",  # printed as `h, u, d`
    ("large", "large"): "umm",
}
"""Bearing and distance to θ_1, θ_2, θ_3."""


def peaks(system):
    return {
        variable.name: {label: m.peak for label, m in variable.memberships.items()}
        for variable in system.config.outputs
    }


def test_rules_are_those_of_table_2():
    rules = fd.load_mamdani("labvolt_posture").config.rules
    found = {
        (rule.when["bearing"], rule.when["distance"]): "".join(
            rule.then[f"theta_{i}"] for i in (1, 2, 3)
        )
        for rule in rules
    }
    assert found == TABLE_2


def test_table_1_has_holes_that_the_bearing_fills():
    points = random_targets(2000, seed=0).T
    guess, fired = default_starts().theta_3(points)
    faithful, _ = FuzzyStarts(fill_holes=False).theta_3(points)
    assert 0.05 < (~fired).mean() < 0.3
    np.testing.assert_allclose(guess[~fired], np.arctan2(*points[::-1, ~fired]), rtol=1e-12)
    np.testing.assert_allclose(np.rad2deg(faithful[~fired]), -90.0, rtol=1e-12)
    np.testing.assert_array_equal(guess[fired], faithful[fired])


def test_starts_are_inside_the_limits_wherever_the_target_is():
    points = np.random.default_rng(0).uniform(-2.0, 2.0, (2, 500))
    assert labvolt().contains(default_starts().posture(points), 0.0).all()


def test_fuzzy_start_does_for_999_targets_of_a_thousand():
    """Targets that the calibration has not seen."""
    targets = random_targets(2000, seed=11)
    assert fd.labvolt.solve(targets, method="hybrid_sqp").success.mean() >= 0.999


def test_initial_guess_for_drakes_own_inverse_kinematics():
    arm = fd.load_arm("labvolt5250")
    targets = [[0.3, 0.4, 0.5], [-0.3, -0.4, 0.5]]
    guess = fd.labvolt.initial_guess(targets)
    assert guess.shape == (2, 4)
    np.testing.assert_allclose(guess[:, 0], [np.arctan2(0.4, 0.3), np.arctan2(-0.4, -0.3)])
    np.testing.assert_allclose(guess[0, 1:], guess[1, 1:])
    assert ((guess >= arm.lower) & (guess <= arm.upper)).all()
    np.testing.assert_array_equal(fd.labvolt.initial_guess(targets[0]), guess[0])
    assert np.isfinite(fd.labvolt.initial_guess([np.nan, 0.0, 1.0])).all()
    with pytest.raises(ValueError, match="targets must have shape"):
        fd.labvolt.initial_guess([0.1])


def test_more_of_drakes_inverse_kinematics_succeed_from_the_fuzzy_start():
    from fikm_drake.experiments.reproduce.labvolt.peers import drake_inverse_kinematics

    arm, solve = fd.load_arm("labvolt5250"), drake_inverse_kinematics()
    plane = random_targets(80, seed=12)
    plane = plane[plane[:, 0] > 0.0]
    targets = np.column_stack([plane[:, 0] + 0.003, 0.0 * plane[:, 0], plane[:, 1] + 0.384])
    random = np.random.default_rng(13).uniform(labvolt().lower, labvolt().upper, (len(plane), 3))
    shares = []
    for starts in (fd.labvolt.initial_guess(targets), np.column_stack([0 * plane[:, 0], random])):
        q = np.array([solve(target, start) for target, start in zip(targets, starts)])
        error = np.linalg.norm(arm.forward_kinematics(q)[:, :3, 3] - targets, axis=1)
        shares.append((error < 1e-6).mean())
    assert shares[0] > 0.95 and shares[0] > shares[1]


@pytest.mark.parametrize("name", FIRST_PEAKS)
def test_same_seed_same_memberships_and_no_worse_than_at_first(name):
    first, again = (calibrate(name, targets=60, rounds=12, seed=3) for _ in range(2))
    assert peaks(first.system) == peaks(again.system)
    assert first.last <= first.first
    assert first.last == again.last
    other = calibrate(name, targets=60, rounds=12, seed=4)
    assert peaks(first.system) != peaks(other.system)


@pytest.mark.parametrize("name", FIRST_PEAKS)
def test_stored_peaks_are_in_order_and_apart(name):
    """Down, mid, up in this order, as in figure 4."""
    first = iter(FIRST_PEAKS[name])
    for variable in fd.load_mamdani(name).config.outputs:
        order = np.argsort([next(first) for _ in variable.memberships])
        stored = np.array([m.peak for m in variable.memberships.values()])[order]
        assert (np.diff(stored) >= APART - 1e-9).all()
        assert (stored >= variable.lower).all() and (stored <= variable.upper).all()


def test_calibration_counts_what_the_solver_misses():
    """The loss of a posture system is what `hybrid_sqp` fails on."""
    found = calibrate("labvolt_posture", targets=120, rounds=6, seed=5)
    starts = FuzzyStarts(posture=found.system)
    solution = fd.labvolt.solve(random_targets(120, seed=5), method="hybrid_sqp", fuzzy=starts)
    assert (~solution.success).sum() == found.last
    assert found.what == calibration.WHAT["labvolt_posture"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "starts"}, r"name must be one of \('labvolt_theta3', 'labvolt_posture'\)"),
        ({"targets": 0}, "targets must be an integer of at least 1, got 0"),
        ({"rounds": -1}, "rounds must be an integer of at least 1, got -1"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        calibrate(**{"name": "labvolt_posture", **arguments})
