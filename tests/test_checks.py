"""The checks of numbers that all constructors share, and that they reach the public entries."""

from math import inf, nan

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.checks import (
    check_below_one,
    check_counts,
    check_finite,
    check_finites,
    check_not_negative,
    check_number,
    check_positive,
    check_positive_finite,
)


def tilted_plane(**options):
    return fd.TiltedPlaneInverse(fd.load_arm("tojo4dof"), fd.load_workplane("tojo4dof"), **options)


NO_NUMBERS = ["1.5", "", None, [], [1.0], np.ones(2), {}, object(), b"1", 1j, nan]
CHECKS = {
    "finite": (check_finite, [-2, 0.0, 1e300], [inf, -inf]),
    "positive": (check_positive, [1, 1e-300, inf], [0, -1.0, -inf]),
    "positive_finite": (lambda name, x: check_positive_finite(name, x, "m"), [2.5], [0, -1, inf]),
    "not_negative": (check_not_negative, [0, 3.0], [-1e-9, inf]),
    "below_one": (check_below_one, [0, 0.999], [1, -0.1, inf]),
}


@pytest.mark.parametrize("check", CHECKS)
def test_numbers_of_any_type_come_back_as_floats(check):
    function, good, _ = CHECKS[check]
    for value in good:
        found = function("name", value)
        assert type(found) is float and found == value
    for kind in (np.float32, np.float64, np.array):
        assert function("name", kind(0.5)) == 0.5


@pytest.mark.parametrize("check", CHECKS)
def test_bad_values_are_named(check):
    function, _, bad = CHECKS[check]
    for value in [*bad, *NO_NUMBERS]:
        with pytest.raises(ValueError) as error:
            function("the name", value)
        assert str(error.value).startswith("the name must be ")
        assert str(error.value).endswith(f"got {value!r}")


def test_a_unit_is_named():
    with pytest.raises(ValueError, match=r"period must be positive and finite \[s\], got 'x'"):
        check_positive_finite("period", "x", "s")


def test_any_other_range_says_what_it_is():
    assert check_number("share", 1, "in (0, 1]", lambda x: 0.0 < x <= 1.0) == 1.0
    with pytest.raises(ValueError, match=r"share must be in \(0, 1\], got 2"):
        check_number("share", 2, "in (0, 1]", lambda x: 0.0 < x <= 1.0)


def test_counts_are_integers_of_any_type():
    check_counts(rounds=1, targets=np.int64(3))
    check_counts(0, seed=0)
    for value in (0, -1, 1.5, 2.0, nan, True, "2", None, [1]):
        with pytest.raises(ValueError) as error:
            check_counts(rounds=value)
        assert str(error.value) == f"rounds must be an integer of at least 1, got {value!r}"


def test_so_many_finite_numbers():
    assert check_finites("origin", np.array([1, 2]), 2, "m") == [1.0, 2.0]
    for bad in ([1.0], [1.0, nan], "12", None, 3.0, [1.0, [2.0]], [[1.0, 2.0]]):
        with pytest.raises(ValueError) as error:
            check_finites("origin", bad, 2, "m")
        assert str(error.value) == f"origin must be 2 finite numbers [m], got {bad!r}"


@pytest.mark.parametrize("bad", ["fast", None, [1.0]])
@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("period", lambda x: fd.LastFinite(3, period=x)),
        ("tolerance", lambda x: fd.StatusMonitor(3, tolerance=x)),
        ("initial_value", lambda x: fd.LowPassFilter(3, period=0.02, initial_value=x)),
        ("error_limit", lambda x: fd.GainSupervision(3, 7, error_limit=x)),
        ("num_joints", lambda x: fd.CommandSupervision(x)),
        ("damping", lambda x: fd.DampedLeastSquares(x)),
        ("cutoff", lambda x: fd.PseudoInverse(x)),
        ("row_floor", lambda x: fd.FuzzyMapping(row_floor=x)),
        ("sweeps", lambda x: fd.FuzzyRateControl(sweeps=x)),
        ("tolerance", lambda x: fd.labvolt.solve([0.4, 0.1], tolerance=x)),
        ("resolution", lambda x: fd.IntegerFuzzyIk(resolution=x)),
        ("control_rate", lambda x: fd.FuzzyIkConfig(control_rate=x).validate()),
        ("posture_rate", lambda x: fd.FuzzyIkConfig(posture_rate=x).validate()),
        ("calming", lambda x: fd.GainSupervisorConfig(calming=x).validate()),
        ("sign_changes", lambda x: fd.GainSupervisorConfig(sign_changes=x).validate()),
        ("recovery", lambda x: fd.CommandSupervisorConfig(recovery=x).validate()),
        ("count", lambda x: fd.labvolt.random_targets(x)),
        ("joint 1: a", lambda x: fd.DhArm(fd.DhTable("arm", joints=[fd.DhJoint(a=x)]))),
        ("heading", lambda x: tilted_plane(heading=(0.0, x))),
        ("origin", lambda x: fd.Workplane(origin=[0.0, 0.0, x]).validate()),
        ("yaw", lambda x: fd.Workplane(yaw=x).validate()),
        ("hold", lambda x: fd.TrackingScenario(arm="arm7", waypoints=[[0.5, 0.1]], hold=x)),
    ],
)
def test_public_entries_name_what_is_no_number(name, make, bad):
    with pytest.raises(ValueError) as error:
        make(bad)
    assert name in str(error.value) and repr(bad) in str(error.value)


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int64, np.array])
def test_numpy_numbers_make_an_arm(kind):
    arm = fd.DhArm(fd.DhTable("arm", joints=[fd.DhJoint(a=kind(1), lower=kind(-2), upper=kind(2))]))
    assert arm.forward_kinematics([0.0])[0, 3] == 1.0 and arm.lower == -2.0


def test_numpy_integers_are_integers():
    fd.GainSupervisorConfig(window=np.int64(12), sign_changes=np.int32(5)).validate()
    fd.CommandSupervisorConfig(window=np.int64(12)).validate()
    assert fd.FuzzyMapping(iterations=np.int64(2)).iterations == 2
    assert fd.FuzzyRateControl(sweeps=np.int64(2)).sweeps == 2
