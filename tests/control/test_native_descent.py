"""The search by the native kernel finds what Python's finds, in the same cycles."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.control.restart_search import make_restart_search
from fikm_drake.control.restart_state import RestartState
from fikm_drake.kinematics.native import kernel as loading
from fikm_drake.kinematics.native.kernel import numpy_only


@pytest.fixture(autouse=True)
def with_kernel(native_kernel, monkeypatch):
    monkeypatch.setattr(loading, "_load", lambda: (native_kernel, ""))


def searches(arm, task):
    """The kernel's and Python's, of the same task."""
    plant_arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm(arm)))
    kind = {"position": fd.PositionTask, "pose": fd.PoseTask}[task](plant_arm)
    options = {"tolerance": 1e-3, "speed": 1.0, "period": 0.01}
    with numpy_only():
        plain = make_restart_search(kind, **options)
    return kind, make_restart_search(kind, **options), plain


@pytest.mark.parametrize("arm", ["ur5", "puma560", "arm7"])
@pytest.mark.parametrize("task", ["position", "pose"])
@pytest.mark.parametrize("far", [1.0, 3.0])
def test_it_is_pythons_cycle_by_cycle(arm, task, far):
    kind, native, plain = searches(arm, task)
    assert native._native and not plain._native
    rng, seen = np.random.default_rng(3), set()
    lower, upper = (np.clip(limit, -3.0, 3.0) for limit in (kind.arm.lower, kind.arm.upper))
    for start, goal in rng.uniform(lower, upper, (3, 2, len(lower))):
        target = kind.arm.pose(kind.arm.context_at(goal))
        target.set_translation(far * target.translation())
        target = target if task == "pose" else target.translation()
        error = float(np.linalg.norm(kind.error(target, start)))
        one, two = native.initial_memory(), plain.initial_memory()
        for _ in range(400):
            native.remember(one, target, start, error)
            with numpy_only():
                plain.remember(two, target, start, error)
            np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-9)
            two[:] = one  # what rounding does is not added up
            seen.add(native.state(one))
            if native.state(one) in (RestartState.STUCK, RestartState.UNDERWAY):
                break
    assert RestartState.SEARCHING in seen
    assert (RestartState.STUCK if far > 1.0 else RestartState.UNDERWAY) in seen


@pytest.mark.parametrize(("period", "steps"), [(0.02, 4), (0.01, 4), (0.005, 2), (0.001, 1)])
def test_a_short_cycle_searches_less(period, steps):
    kind = searches("ur5", "position")[0]
    search = make_restart_search(kind, tolerance=1e-3, speed=1.0, period=period)
    memory, q, target = search.initial_memory(), np.full(6, 0.3), np.array([0.3, 0.2, 0.4])
    memory[0], memory[4:10] = RestartState.SEARCHING, 1.0
    search.remember(memory, target, q, float(np.linalg.norm(kind.error(target, q))))
    assert memory[1] == steps


def test_a_target_that_is_not_finite_is_pythons():
    kind, native, _ = searches("ur5", "position")
    bad, memory = np.array([np.nan, 0.0, 0.0]), native.initial_memory()
    memory[0] = RestartState.SEARCHING
    before = memory.copy()
    assert native._native(memory, bad, 4) == 0
    np.testing.assert_array_equal(memory, before)
    assert np.isinf(native._native.sizes(bad, np.zeros((2, kind.arm.num_joints)))).all()


def test_threads_do_not_share_buffers(in_threads):
    kind, native, _ = searches("ur5", "pose")
    postures = np.random.default_rng(0).normal(size=(3, 10, 6))
    targets = [kind.arm.pose(kind.arm.context_at(some[0])) for some in postures]

    def run(i):
        first = native._native.sizes(targets[i], postures[i])
        for _ in range(200):
            np.testing.assert_array_equal(native._native.sizes(targets[i], postures[i]), first)

    in_threads(run)
