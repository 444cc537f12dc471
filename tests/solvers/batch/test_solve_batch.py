"""Batch inverse kinematics: success, limits, honest failures, determinism."""

import dataclasses
import warnings

import numpy as np
import pytest

from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.batch import search as module
from fikm_drake.solvers.batch.batch_solution import SolverStatus
from fikm_drake.solvers.solver import solve_batch


@pytest.fixture(autouse=True, params=["native", "numpy"])
def path(request, monkeypatch):
    """Both searches: every test below is of either."""
    loaded = request.getfixturevalue("native_kernel") if request.param == "native" else None
    monkeypatch.setattr(module, "kernel", lambda: loaded)
    return request.param


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("limits", [False, True])
@pytest.mark.parametrize("name", ["iiwa14", "panda"])
def test_1000_poses_from_home(name, limits, seed, home, reachable, check):
    arm = load_arm(name)
    X = reachable(arm, 1000, seed)
    solution = solve_batch(arm, X, task="pose", initial_position=home[name], limits=limits)
    check(arm, X, solution, limits=limits)
    assert solution.success.mean() >= 0.999
    assert np.median(solution.cycles) <= 12


@pytest.mark.parametrize("start", ["nearest", "default"])
@pytest.mark.parametrize("task", ["position", "pose"])
@pytest.mark.parametrize("name", ["planar2", "planar4", "arm7", "puma560", "iiwa14"])
def test_every_arm_and_task(name, task, start, reachable, check):
    arm = load_arm(name)
    X = reachable(arm, 300, 3)
    targets = X if task == "pose" else X[:, :3, 3]
    initial = arm.default_position if start == "default" else None
    solution = solve_batch(arm, targets, task=task, initial_position=initial)
    check(arm, targets, solution)
    assert solution.success.mean() >= 0.996


@pytest.mark.parametrize("limits", [False, True])
@pytest.mark.parametrize("task", ["position", "pose"])
def test_prismatic_joint(task, limits, scara, reachable, check):
    X = reachable(scara, 300, 4)
    targets = X if task == "pose" else X[:, :3, 3]
    solution = solve_batch(scara, targets, task=task, limits=limits)
    check(scara, targets, solution, limits=limits)
    assert solution.success.all()


def test_tight_tolerance(reachable, check):
    arm = load_arm("iiwa14")
    X = reachable(arm, 200, 5)
    solution = solve_batch(arm, X, task="pose", tolerance=(1e-9, 1e-8))
    check(arm, X, solution, tolerance=(1e-9, 1e-7))
    assert solution.success.all()


def test_start_that_is_the_solution_takes_no_cycle():
    arm = load_arm("iiwa14")
    q = np.random.default_rng(6).uniform(arm.lower, arm.upper, (20, 7))
    solution = solve_batch(arm, arm.forward_kinematics(q), task="pose", initial_position=q)
    np.testing.assert_array_equal(solution.q, q)
    np.testing.assert_array_equal(solution.cycles, 0)


def test_dead_point_of_a_stretched_arm_is_left():
    solution = solve_batch(load_arm("planar2"), [[1.0, 0.0, 0.0]], initial_position=[0.0, 0.0])
    assert solution.success.all()


@pytest.mark.parametrize(
    ("name", "target", "optimum"), [("planar4", [0, 2, 0], 0.5), ("arm7", [2, 0, 0], 1.0)]
)
def test_unreachable_position_ends_at_the_nearest_point(name, target, optimum, check):
    arm = load_arm(name)
    solution = solve_batch(arm, [target])
    check(arm, [target], solution)
    assert solution.status[0] == SolverStatus.UNREACHABLE
    assert solution.position_error[0] == pytest.approx(optimum, abs=1e-3)


def test_unreachable_pose_is_reported_and_others_are_solved(home, reachable, check):
    arm = load_arm("iiwa14")
    X = reachable(arm, 60, 7)
    X[::3, :3, 3] += [0.0, 0.0, 2.0]
    solution = solve_batch(arm, X, task="pose", initial_position=home["iiwa14"])
    check(arm, X, solution)
    assert (solution.status[::3] == SolverStatus.UNREACHABLE).all()
    assert np.delete(solution.success, np.s_[::3]).all()


def test_unreachable_without_a_proof_is_not_solved(check):
    arm = load_arm("iiwa14")  # its elbow does not bend far enough to touch its own shoulder
    targets = [[0.05, 0.0, 0.36]]
    solution = solve_batch(arm, targets, restarts=20)
    check(arm, targets, solution)
    assert solution.status[0] == SolverStatus.NOT_SOLVED
    assert solve_batch(arm, targets, limits=False).success[0]


@pytest.mark.parametrize("restarts", [0, 1, 5, 2000])
def test_restarts_are_bounded(restarts, check):
    arm = load_arm("iiwa14")
    targets = [[0.05, 0.0, 0.36], [0.5, 0.0, 0.5]]
    solution = solve_batch(arm, targets, restarts=restarts)
    check(arm, targets, solution)
    np.testing.assert_array_equal(solution.status, [3, 1])


def test_half_turn_of_the_tool(home, check):
    arm = load_arm("iiwa14")
    X = np.repeat(arm.forward_kinematics(home["iiwa14"])[None], 3, axis=0)
    for i in range(3):  # about each axis of the tool
        X[i, :3, :3] = X[i, :3, :3] @ (2.0 * np.outer(np.eye(3)[i], np.eye(3)[i]) - np.eye(3))
    solution = solve_batch(arm, X, task="pose", initial_position=home["iiwa14"], limits=False)
    check(arm, X, solution, limits=False)
    assert solution.success.all()


def test_invalid_targets_keep_the_initial_position(home, check, reachable):
    arm = load_arm("iiwa14")
    X = np.repeat(reachable(arm, 1, 8), 9, axis=0)
    X[1, 0, 3] = np.nan
    X[2, 1, 1] = np.inf
    X[3, :3, :3] *= 1.01
    X[4, :3, 0] *= -1.0  # a mirror
    X[5, 3, 3] = 2.0
    X[6] = 0.0
    X[7, 2, 3] = 1e200
    solution = solve_batch(arm, X, task="pose", initial_position=home["iiwa14"])
    check(arm, X, solution)
    np.testing.assert_array_equal(solution.status, [1, 0, 0, 0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(solution.q[1:8], np.tile(home["iiwa14"], (7, 1)))
    alone = solve_batch(arm, X[:1], task="pose", initial_position=home["iiwa14"])
    np.testing.assert_allclose(solution.q[0], alone.q[0], rtol=0, atol=1e-9)


def test_invalid_position_without_initial_position_gets_the_middle(check):
    arm = load_arm("panda")
    targets = [[0.4, 0.0, np.nan], [0.4, 0.0, 0.4], [1e99, 0.0, 0.0]]
    solution = solve_batch(arm, targets)
    check(arm, targets, solution)
    np.testing.assert_allclose(solution.q[0], (arm.lower + arm.upper) / 2)
    np.testing.assert_array_equal(solution.status, [0, 1, 2])


@pytest.mark.parametrize(("task", "empty"), [("position", []), ("pose", np.empty((0, 4, 4)))])
def test_no_targets(task, empty):
    solution = solve_batch(load_arm("iiwa14"), empty, task=task)
    assert len(solution) == 0 and solution.q.shape == (0, 7) and solution.success.shape == (0,)


def test_same_seed_same_answer_whatever_the_chunks(monkeypatch, home, reachable):
    arm = load_arm("panda")
    X = reachable(arm, 150, 9)

    def solve(seed=0):
        return solve_batch(arm, X, task="pose", initial_position=home["panda"], seed=seed)

    first, again, other = solve(), solve(), solve(seed=1)
    for field in dataclasses.fields(first):
        np.testing.assert_array_equal(getattr(first, field.name), getattr(again, field.name))
    assert not np.array_equal(first.q, other.q)
    for size in (1, 7, 64):
        monkeypatch.setattr(module, "CHUNK", size)
        chunked = solve()
        np.testing.assert_array_equal(chunked.cycles, first.cycles)
        np.testing.assert_allclose(chunked.q, first.q, rtol=0, atol=1e-6)


def test_order_of_the_targets_does_not_matter(reachable):
    arm = load_arm("iiwa14")
    X = reachable(arm, 100, 10)
    order = np.random.default_rng(0).permutation(100)
    straight, shuffled = (solve_batch(arm, Y, task="pose") for Y in (X, X[order]))
    np.testing.assert_allclose(shuffled.q, straight.q[order], rtol=0, atol=1e-6)


def test_input_arrays_are_left_alone(home, reachable):
    arm = load_arm("iiwa14")
    X, q = reachable(arm, 20, 11), home["iiwa14"].copy()
    before = X.copy()
    solve_batch(arm, X, task="pose", initial_position=q).q[:] = 0.0
    np.testing.assert_array_equal(X, before)
    np.testing.assert_array_equal(q, home["iiwa14"])


def test_solution_tells_its_counts():
    solution = solve_batch(load_arm("iiwa14"), [[0.4, 0, 0.5], [9, 0, 0], [np.nan, 0, 0]])
    assert repr(solution) == "<BatchSolution: 1 invalid_input, 1 solved, 1 unreachable>"
    with pytest.raises(dataclasses.FrozenInstanceError):
        solution.q = None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"task": "posture"}, r"task must be one of \('position', 'pose'\), got 'posture'"),
        ({"task": "pose"}, r"must have shape \(N, 4, 4\), got \(2, 3\)"),
        ({"targets": [0.1, 0.2, 0.3]}, r"must have shape \(N, 3\), got \(3,\)"),
        ({"tolerance": 0.0}, "tolerance must be a positive position"),
        ({"tolerance": (1e-3, np.nan)}, "tolerance must be a positive position"),
        ({"tolerance": (1e-3, 1e-3, 1e-3)}, "tolerance must be a positive position"),
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"max_cycles": 0}, "max_cycles must be an integer of at least 1, got 0"),
        ({"max_cycles": 1.5}, "max_cycles must be an integer of at least 1, got 1.5"),
        ({"seed": -1}, "seed must be an integer of at least 0, got -1"),
        ({"initial_position": [0.0] * 6}, r"must have shape \(7,\) or \(2, 7\), got \(6,\)"),
        ({"initial_position": [np.nan] * 7}, r"initial_position\[0\] must be finite and in"),
        (
            {"initial_position": [0, 3, 0, 0, 0, 0, 0]},
            r"initial_position\[1\] must be finite and in \[-2.*, 2.*\], got 3.0",
        ),
    ],
)
def test_bad_arguments(options, message):
    targets = options.get("targets", [[0.4, 0.0, 0.5]] * 2)
    options = {key: value for key, value in options.items() if key != "targets"}
    with pytest.raises(ValueError, match=message):
        solve_batch(load_arm("iiwa14"), targets, **options)


def test_ignored_limits_allow_a_start_outside():
    solution = solve_batch(
        load_arm("iiwa14"), [[0.4, 0.0, 0.5]], initial_position=[0, 3, 0, 0, 0, 0, 0], limits=False
    )
    assert solution.success.all()
