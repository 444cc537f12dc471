"""One target or many by a solver that is made once; the kernel and numpy give the same answers."""

import dataclasses
import threading

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd
from fikm_drake.solvers.batch import search
from fikm_drake.solvers.batch.posture_pool import PosturePool


@pytest.fixture(params=["native", "numpy"])
def path(request, monkeypatch):
    loaded = request.getfixturevalue("native_kernel") if request.param == "native" else None
    monkeypatch.setattr(search, "kernel", lambda: loaded)
    return request.param


@pytest.mark.parametrize(
    "name, task", [("panda", "position"), ("panda", "pose"), ("puma560", "pose")]
)
def test_one_target_is_answered_as_among_many(path, name, task, home, reachable):
    arm = fd.load_arm(name)
    X = reachable(arm, 12, 1)
    targets = X if task == "pose" else X[:, :3, 3]
    solver = fd.Solver(arm, task=task)
    for start in (home.get(name, arm.default_position), None):
        many = solver.solve_batch(targets, start)
        for i, target in enumerate(targets):
            one = solver.solve(target, start)
            assert one.success and one.status == fd.SolverStatus.SOLVED
            np.testing.assert_allclose(one.q, many.q[i], rtol=0, atol=1e-6)
            assert one.cycles == many.cycles[i]
            assert one.position_error == pytest.approx(many.position_error[i], abs=1e-9)
            assert one.rotation_error == pytest.approx(many.rotation_error[i], abs=1e-9)


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_postures_in_the_corners_of_the_limits(path, name, home):
    arm, rng = fd.load_arm(name), np.random.default_rng(3)
    solver = fd.Solver(arm, task="pose")
    for _ in range(15):
        corner = np.where(rng.random(arm.num_joints) < 0.5, arm.lower, arm.upper)
        solution = solver.solve(arm.forward_kinematics(corner), home[name])
        assert solution.success
        assert (solution.q >= arm.lower).all() and (solution.q <= arm.upper).all()


def test_targets_that_are_none(path, home):
    solver = fd.Solver(fd.load_arm("iiwa14"))
    solution = solver.solve([np.nan, 0.0, 0.5], home["iiwa14"])
    assert solution.status == fd.SolverStatus.INVALID_INPUT and not solution.success
    np.testing.assert_array_equal(solution.q, home["iiwa14"])
    assert np.isnan(solution.position_error)
    solution = solver.solve([3.0, 0.0, 0.36])
    assert solution.status == fd.SolverStatus.UNREACHABLE
    assert solution.position_error == pytest.approx(3.0 - 0.946, abs=2e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.solve([0.1, 0.2]), r"must have shape \(3,\), got \(2,\)"),
        (lambda s: s.solve(np.eye(4)), r"must have shape \(3,\), got \(4, 4\)"),
        (lambda s: s.solve([0.5, 0, 0.5], [0.0] * 6), r"must have shape \(7,\)"),
        (
            lambda s: s.solve([0.5, 0, 0.5], [0, 9, 0, 0, 0, 0, 0]),
            r"initial_position\[1\] must be finite and in",
        ),
        (lambda s: s.solve([0.5, 0, 0.5], [np.inf] * 7), r"initial_position\[0\] must be finite"),
        (lambda s: s.solve_batch([[0.5, 0, 0.5]], threads=0), "threads must be an integer"),
        (lambda s: fd.Solver("iiwa14"), "arm must be a SerialChain"),
    ],
)
def test_bad_arguments(call, message):
    solver = fd.Solver(fd.load_arm("iiwa14"))
    with pytest.raises(ValueError, match=message):
        call(solver)


def test_once():
    solution = fd.solve(fd.load_arm("iiwa14"), [0.5, 0.0, 0.5])
    assert solution.success and solution.position_error < 1e-3


@pytest.mark.parametrize("name", ["iiwa14", "puma560", "planar4"])
@pytest.mark.parametrize("task", ["position", "pose"])
def test_kernel_and_numpy_give_the_same_answers(native_kernel, name, task, reachable):
    arm = fd.load_arm(name)
    X = reachable(arm, 400, 5)
    X[::50, 2, 3] += 5.0
    targets = X if task == "pose" else X[:, :3, 3].copy()
    targets[7] = np.nan
    problem = fd.Solver(arm, task=task)._problem
    for start in (None, np.clip(np.full(arm.num_joints, 0.5), arm.lower, arm.upper)):
        q, figures = search.NumpySearch(problem).run(targets, start)
        native_q, native_figures = search.NativeSearch(problem, native_kernel).run(targets, start)
        np.testing.assert_array_equal(native_figures[:, 0], figures[:, 0])
        # Rounding grows where a search goes on for long, as past what is out of reach.
        solved = figures[:, 0] == fd.SolverStatus.SOLVED
        assert (np.abs(native_q - q).max(axis=1) < 1e-9)[solved].mean() > 0.99
        assert (native_figures[:, 1] == figures[:, 1]).mean() > 0.99


def test_ten_thousand_targets_have_the_same_successes(native_kernel, reachable):
    arm = fd.load_arm("iiwa14")
    X = reachable(arm, 10_000, 6)
    problem = fd.Solver(arm, task="pose")._problem
    _, figures = search.NumpySearch(problem).run(X, None)
    _, native_figures = search.NativeSearch(problem, native_kernel).run(X, None)
    np.testing.assert_array_equal(native_figures[:, 0], figures[:, 0])
    assert (figures[:, 0] == fd.SolverStatus.SOLVED).all()


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 30.0, 1e6])
@pytest.mark.parametrize("name", ["planar4", "kim_lee3r", "puma560"])
def test_arms_of_all_sizes_are_alike(path, name, scale):
    def solve(scale):
        table = fd.load_arm(name).table
        for row in [*table.joints, table.tool]:
            row.a *= scale
            row.d *= scale
        arm, rng = fd.DhArm(table), np.random.default_rng(0)
        lower, upper = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
        X = arm.forward_kinematics(rng.uniform(lower, upper, (60, arm.num_joints)))
        solver = fd.Solver(arm, task="pose", tolerance=(1e-3 * scale, 0.0087))
        return solver.solve_batch(X)

    ordinary, other = solve(1.0), solve(scale)
    assert other.success.all() and ordinary.success.all()
    np.testing.assert_allclose(other.q, ordinary.q, rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", [0, 1, 77])
def test_solvers_postures_are_none_of_the_users(seed):
    arm = fd.load_arm("panda")
    users = np.random.default_rng(seed).uniform(arm.lower, arm.upper, (300, 7))
    own = PosturePool(arm.chain, 0.3, seed).q.T
    away = np.abs(users[:, None] - own[None]).max(axis=2)
    assert away.min() > 1e-3  # a seventh power of chance else
    X = arm.forward_kinematics(users)
    assert (fd.solve_batch(arm, X, task="pose", seed=seed).cycles > 0).mean() > 0.99


def test_threads_progress_and_order(path, reachable):
    arm = fd.load_arm("iiwa14")
    X = reachable(arm, 1500, 8)
    solver, told = fd.Solver(arm, task="pose"), []
    one = solver.solve_batch(X, threads=1)
    many = solver.solve_batch(
        X, threads=3, progress=lambda done: told.append((done, threading.get_ident()))
    )
    for field in dataclasses.fields(one):
        np.testing.assert_allclose(getattr(many, field.name), getattr(one, field.name), atol=1e-9)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert told[-1][0] == 1.0 and len(told) >= 3
    assert {thread for _, thread in told} == {threading.get_ident()}


def test_chain_of_a_plant(path):
    arm, plant = fd.load_arm("iiwa14"), MultibodyPlant(0.0)
    fd.AddDhArm(plant, arm)
    plant.Finalize()
    chain = fd.SerialChain.from_plant(plant, "tool")
    X = arm.forward_kinematics(np.random.default_rng(9).uniform(-1.5, 1.5, (20, 7)))
    ours, plants = (fd.solve_batch(a, X, task="pose") for a in (arm, chain))
    assert plants.success.all()
    np.testing.assert_allclose(plants.q, ours.q, rtol=0, atol=1e-6)
