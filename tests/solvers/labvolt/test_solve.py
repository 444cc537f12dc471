"""`labvolt.solve`: every method, every status, every kind of input."""

import dataclasses
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.fuzzy.mamdani import load_mamdani
from fikm_drake.solvers.labvolt import METHODS, FuzzyStarts, LabVoltStatus, random_targets, solve
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.program import LabVoltProgram

GEOMETRY = labvolt()
NUMBER = st.floats(allow_nan=True, allow_infinity=True)


def check(targets, solution, tolerance=1e-9):
    """What holds for any solution of targets in the plane."""
    count = len(targets)
    assert len(solution) == count
    assert solution.angles.shape == (count, 3) and np.isfinite(solution.angles).all()
    relative = fd.labvolt.to_relative(solution.angles)
    assert GEOMETRY.contains(relative.T, 1e-12).all()
    valid = solution.status != LabVoltStatus.INVALID_INPUT
    away = fd.labvolt.forward_kinematics(solution.angles[valid]) - targets[valid]
    np.testing.assert_allclose(np.hypot(*away.T), solution.error[valid], rtol=1e-9, atol=1e-12)
    assert np.isnan(solution.error[~valid]).all() and np.isnan(solution.nearest[~valid]).all()
    done = np.isin(solution.status, (LabVoltStatus.SOLVED, LabVoltStatus.FELL_BACK))
    np.testing.assert_array_equal(solution.success, done)
    assert (solution.error[done] <= tolerance).all()
    assert (solution.distance[done | (solution.status == LabVoltStatus.NOT_SOLVED)] == 0).all()
    far = solution.status == LabVoltStatus.UNREACHABLE
    np.testing.assert_allclose(solution.error[far], solution.distance[far], rtol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_reachable_targets(method):
    targets = random_targets(150, seed=0)
    solution = solve(targets, method=method)
    check(targets, solution)
    assert solution.success.mean() > 0.99


@pytest.mark.parametrize("method", ["exact", "cascade"])
def test_our_methods_solve_all(method):
    targets = random_targets(1000, seed=1)
    solution = solve(targets, method=method)
    check(targets, solution)
    assert solution.success.all() and solution.error.max() < 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_each_status_beside_the_others(method):
    targets = np.array([[0.4, 0.1], [0.9, 0.0], [np.nan, 0.1], [0.3, np.inf], [1e200, 0], [0, 0]])
    solution = solve(targets, method=method)
    check(targets, solution)
    assert solution.status.tolist() == [1, 4, 0, 0, 0, 4]
    assert solution.nearest[1] == pytest.approx([0.7543, 0.0])
    assert solution.distance[1] == pytest.approx(0.9 - 0.7543)
    assert (solution.tries[1:] == 0).all()


@settings(max_examples=200)
@given(st.lists(st.tuples(NUMBER, NUMBER), max_size=4))
def test_any_numbers_in_the_plane(targets):
    array = np.array(targets, dtype=float).reshape(-1, 2)
    with np.errstate(over="ignore"):
        check(array, solve(array))


@given(st.tuples(NUMBER, NUMBER, NUMBER))
def test_any_numbers_in_space(target):
    solution = solve(target)
    assert np.isfinite(solution.joints).all()
    assert solution.success[0] == (solution.status[0] == LabVoltStatus.SOLVED)


@pytest.mark.parametrize("bad", [[np.nan, 0.0], [1e9, 0.0], [np.inf, 1.0, 1.0], [0.9, 0.9]])
def test_bad_targets_never_reach_the_program(bad, monkeypatch):
    monkeypatch.setattr(LabVoltProgram, "reach", lambda *_: pytest.fail("it was asked"))
    for method in METHODS:
        assert not solve(bad, method=method).success[0]


def test_shapes():
    assert len(solve([0.4, 0.1])) == len(solve([0.4, 0.1, 0.5])) == 1
    assert solve([[0.4, 0.1]] * 3).nearest.shape == (3, 2)
    assert solve([[0.4, 0.1, 0.5]] * 3).nearest.shape == (3, 3)
    for empty in ([], np.empty((0, 2)), np.empty((0, 3))):
        for method in METHODS:
            assert solve(empty, method=method).angles.shape == (0, 3)


@pytest.mark.parametrize(
    "targets",
    [
        0.4,
        None,
        [0.4],
        [0.1, 0.2, 0.3, 0.4],
        np.zeros((2, 4)),
        np.zeros((2, 2, 2)),
        np.empty((0, 5)),
        [[0.1, 0.2], [0.1, 0.2, 0.3]],
        "here",
        [{}],
    ],
)
def test_wrong_shapes_and_what_is_no_number(targets):
    with pytest.raises(ValueError, match="targets must"):
        solve(targets)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "sqpp"}, r"method must be one of \('exact', .*'cascade'\), got 'sqpp'"),
        ({"tolerance": 0.0}, "tolerance must be positive and finite"),
        ({"tolerance": np.nan}, "tolerance must be positive and finite"),
        ({"solver": "ipopt"}, r"solver must be one of \('slsqp', 'snopt'\)"),
        ({"approach": 0.0, "method": "cascade"}, "approach needs the method 'exact'"),
        ({"approach": np.nan}, "approach must be one finite angle"),
        ({"approach": [0.0, 0.1, 0.2]}, "approach must be one finite angle"),
        ({"method": "sqp", "posture": "high"}, "posture must be 'middle' or angles, got 'high'"),
        ({"method": "sqp", "posture": [0.0, 1.0]}, r"posture must be \(3,\) or \(1, 3\)"),
        ({"method": "sqp", "posture": [0.0, np.nan, 0.0]}, "posture must be"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(ValueError, match=message):
        solve([0.4, 0.1], **options)


def test_fuzzy_systems_must_have_the_right_variables():
    with pytest.raises(ValueError, match=r"posture must have inputs \['distance', 'bearing'\]"):
        FuzzyStarts(posture=load_mamdani("labvolt_theta3"))


def test_targets_all_round_the_base():
    """yaw = atan2(y, x), not of |x|; the plane's frame is at the shoulder."""
    yaw = np.linspace(-3.1, 3.1, 40)
    targets = np.column_stack([0.5 * np.cos(yaw), 0.5 * np.sin(yaw), np.full(40, 0.5)])
    solution = solve(targets)
    np.testing.assert_allclose(solution.yaw, yaw, rtol=0, atol=1e-12)
    arm = fd.load_arm("labvolt5250")
    tools = arm.forward_kinematics(solution.joints)[:, :3, 3]
    np.testing.assert_allclose(tools, targets, rtol=0, atol=1e-12)
    np.testing.assert_allclose(solution.nearest, targets, rtol=0, atol=1e-12)


def test_nearest_point_in_space_is_where_the_tool_is():
    target = np.array([-0.6, 0.6, 0.9])
    solution = solve(target)
    assert solution.status[0] == LabVoltStatus.UNREACHABLE
    tool = fd.load_arm("labvolt5250").forward_kinematics(solution.joints[0])[:3, 3]
    np.testing.assert_allclose(tool, solution.nearest[0], rtol=0, atol=1e-12)
    assert np.linalg.norm(tool - target) == pytest.approx(solution.distance[0], abs=1e-12)


def test_algorithm_1_tries_are_counted_as_in_a_plain_loop():
    """θ_3 = −90°, then a degree more, a degree less, …, with a plain two-link solution."""

    def tries(x, y):
        a1, a2, a3 = GEOMETRY.lengths
        for k in range(361):
            theta_3 = np.deg2rad(-90.0 + (k + 1) // 2 * (1 if k % 2 else -1))
            wx, wy = x - a3 * np.cos(theta_3), y - a3 * np.sin(theta_3)
            cosine = (wx**2 + wy**2 - a1**2 - a2**2) / (2 * a1 * a2)
            if abs(cosine) > 1.0:
                continue
            for bend in (np.arccos(cosine), -np.arccos(cosine)):
                theta_1 = np.arctan2(wy, wx) - np.arctan2(a2 * np.sin(bend), a1 + a2 * np.cos(bend))
                q = np.array([theta_1, bend, theta_3 - theta_1 - bend])
                q = (q + np.pi) % (2 * np.pi) - np.pi
                if GEOMETRY.contains(q, 0.0):
                    return k + 1
        return 361

    targets = random_targets(60, seed=2)
    solution = solve(targets, method="analytic")
    assert solution.tries.tolist() == [tries(x, y) for x, y in targets]


def test_fuzzy_rules_need_ten_times_fewer_guesses_of_theta_3():
    targets = random_targets(2000, seed=3)
    plain = solve(targets, method="analytic").tries.mean()
    filled = solve(targets, method="hybrid_analytic").tries.mean()
    faithful = FuzzyStarts(fill_holes=False)
    holes = solve(targets, method="hybrid_analytic", fuzzy=faithful).tries.mean()
    assert 110 < plain < 140 and filled < plain / 10 and filled < holes < plain


def test_a_tighter_tolerance_than_can_be_is_not_solved():
    solution = solve(random_targets(20, seed=4), method="sqp", tolerance=1e-25)
    assert (solution.status == LabVoltStatus.NOT_SOLVED).any()


@pytest.mark.parametrize("method", METHODS)
def test_out_of_reach_by_less_than_the_tolerance_is_reached(method):
    for tolerance, status in ((1e-3, LabVoltStatus.SOLVED), (1e-5, LabVoltStatus.UNREACHABLE)):
        solution = solve([0.7543 + 1e-4, 0.0], method=method, tolerance=tolerance)
        assert solution.status[0] == status
        assert solution.distance[0] == pytest.approx(1e-4)
        assert solution.error[0] == pytest.approx(1e-4, rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_posture_near_the_last_one(method):
    """A wish moves the solution towards it and keeps it exact."""
    targets = random_targets(15, seed=5)
    wish = fd.labvolt.to_absolute(GEOMETRY.middle + [0.3, -0.6, 0.4])
    plain, wished = (solve(targets, method=method, posture=p) for p in (None, wish))
    check(targets, wished)

    def from_wish(solution):
        off = fd.labvolt.to_relative(solution.angles) - fd.labvolt.to_relative(wish)
        return (off**2).sum(axis=1)

    assert (from_wish(wished) <= from_wish(plain) + 1e-9).all()
    assert from_wish(wished).mean() < 0.9 * from_wish(plain).mean()


def test_posture_a_target_and_middle():
    targets = random_targets(10, seed=6)
    last = solve(targets).angles
    np.testing.assert_allclose(
        solve(targets, method="cascade", posture=last).angles, last, rtol=0, atol=1e-6
    )
    middle = fd.labvolt.to_absolute(GEOMETRY.middle)
    np.testing.assert_array_equal(
        solve(targets, method="sqp", posture="middle").angles,
        solve(targets, method="sqp", posture=middle).angles,
    )


@pytest.mark.parametrize("method", METHODS)
def test_targets_do_not_influence_each_other(method):
    targets = random_targets(12, seed=7)
    together = solve(targets, method=method).angles
    alone = [solve(target, method=method).angles[0] for target in targets]
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-9)


def test_targets_are_left_alone():
    targets = random_targets(5, seed=8)
    before = targets.copy()
    solve(targets).nearest[:] = 0.0
    np.testing.assert_array_equal(targets, before)


def test_threads_have_programs_of_their_own():
    targets = random_targets(60, seed=9)
    expected = solve(targets, method="sqp").angles
    found = [None] * 4

    def run(k):
        found[k] = solve(targets, method="sqp").angles

    threads = [threading.Thread(target=run, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for angles in found:
        np.testing.assert_array_equal(angles, expected)


def test_solution_tells_its_counts():
    solution = solve([[0.4, 0.1], [9.0, 0.0], [np.nan, 0.0]])
    assert repr(solution) == "<LabVoltSolution: 1 invalid_input, 1 solved, 1 unreachable>"
    assert repr(solve([])) == "<LabVoltSolution: no targets>"
    with pytest.raises(dataclasses.FrozenInstanceError):
        solution.angles = None
