"""The native kernel's cycle equals Python's tick, and leaves it what is out of the ordinary."""

import threading
from collections import Counter

import numpy as np
import pytest
from pydrake.math import RigidTransform

import fikm_drake as fd
from fikm_drake.control.native_cycle import NativeCycle, native_cycle, packed
from fikm_drake.experiments.fuzz.native_fuzz import native_case
from fikm_drake.kinematics.native import kernel as loading
from fikm_drake.kinematics.native.kernel import numpy_only

POSE_LAW = fd.FuzzyMapping(iterations=6, damping=0.1, row_floor=0.05)


@pytest.fixture(autouse=True)
def with_kernel(native_kernel, monkeypatch):
    monkeypatch.setattr(loading, "_load", lambda: (native_kernel, ""))


@pytest.fixture
def counted(monkeypatch):
    """Counts cycles that the kernel did, those that it left, and calmed ones among the former."""
    counts, advance = Counter(), NativeCycle.advance

    def count(self, command, velocity, memory, target, q):
        done = advance(self, command, velocity, memory, target, q)
        counts["done" if done else "left"] += 1
        counts["calmed"] += done and memory[1 + self._m + 1] < 1.0
        return done

    monkeypatch.setattr(NativeCycle, "advance", count)
    return counts


def cases(count, seed):
    """What random cases violate."""
    found = []
    with np.errstate(all="ignore"):
        for i in range(count):
            try:
                found += sum(native_case(np.random.default_rng([seed, i])), [])
            except ValueError:  # a config that is refused
                pass
    return found


def test_random_cycles_equal_those_of_python(counted):
    assert not cases(50, 1)
    assert counted["done"] > 800 and counted["left"] > 800 and counted["calmed"] > 20


def test_a_difference_in_the_calm_is_seen(monkeypatch):
    monkeypatch.setattr(
        "fikm_drake.control.calm_rule.CalmRule.lowered", lambda self, calm: 0.9 * calm
    )
    assert cases(50, 1)


def make_cycle(arm, task="position", **options):
    plant_arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm(arm)))
    kinds = {"position": fd.PositionTask, "pose": fd.PoseTask}
    return fd.ControlCycle(kinds[task](plant_arm), fd.FuzzyIkConfig(task=task, **options))


@pytest.mark.parametrize(
    ("arm", "task", "law", "target"),
    [
        ("planar4", "position", fd.FuzzyMapping(), [0.0, 2.0, 0.0]),
        ("arm7", "position", fd.FuzzyMapping(), [2.0, 0.0, 0.0]),
        ("arm7", "position", fd.FuzzyMapping(iterations=6), [1.0, 1.3, 0.5]),
        ("iiwa14", "pose", POSE_LAW, [0.9, 0.5, 0.6]),
        ("iiwa14", "pose", fd.FuzzyMapping(), [0.9, 0.9, 0.6]),
    ],
)
def test_a_long_run_equals_numpys(arm, task, law, target, counted):
    """Shaking, calmed, creeping; every part by the kernel against every part by numpy and Drake."""
    with numpy_only():
        plain = make_cycle(arm, task, law=law)
    cycle = make_cycle(arm, task, law=law)
    native = native_cycle(cycle)
    q = cycle.task.arm.default_position + 0.3
    goal = np.array(target)
    if task == "pose":
        R = cycle.task.arm.pose(cycle.task.arm.context_at(q)).rotation()
        goal = RigidTransform(R, goal)
    state = plain.start(np.clip(q, cycle.task.arm.lower, cycle.task.arm.upper))
    for k in range(400):
        own = [state.command.copy(), state.velocity.copy(), packed(state)]
        done = native.advance(*own, goal, state.command)
        with numpy_only():
            plain.advance(state, goal, state.command, plain.tick(state, goal, state.command))
        if done:
            for mine, other in zip(own, (state.command, state.velocity, packed(state))):
                np.testing.assert_allclose(mine, other, rtol=1e-9, atol=1e-12, err_msg=f"cycle {k}")
    assert counted["done"] > 100


@pytest.mark.parametrize(
    "options",
    [
        {"posture_rate": 0.5},
        {"restart_search": True},
        {"acceleration_limits": [3.0]},
        {"law": fd.FuzzyMapping(iterations=2)},
        {"law": fd.DampedLeastSquares()},
    ],
)
def test_other_configurations_are_pythons(options):
    assert native_cycle(make_cycle("arm7")) is not None
    assert native_cycle(make_cycle("arm7", **options)) is None


def test_without_a_kernel_there_is_none():
    with numpy_only():
        assert native_cycle(make_cycle("arm7")) is None


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e200])
def test_a_bad_input_is_left_and_nothing_is_written(bad):
    cycle = make_cycle("arm7", measured_position=True)
    native = native_cycle(cycle)
    state = cycle.start(np.full(7, 0.3))
    good = state.command.copy()
    for target, q in ((np.array([0.4, bad, 0.2]), good), (np.full(3, 0.4), np.full(7, bad))):
        own = [state.command.copy(), state.velocity.copy(), packed(state)]
        before = [part.copy() for part in own]
        assert not native.advance(*own, target, q)
        assert native.tick(own[0], own[2], target, q) is None
        for part, old in zip(own, before):
            np.testing.assert_array_equal(part, old)


def test_threads_do_not_share_buffers():
    cycle = make_cycle("arm7")
    native, wrong = native_cycle(cycle), []

    def run(seed):
        start = np.random.default_rng(seed).uniform(-0.5, 0.5, 7)
        target, state = np.array([0.5, 0.1 * seed, 0.4]), cycle.start(start)
        memory, first = packed(state), None
        for _ in range(300):
            tick = native.tick(state.command, memory, target, state.command)
            first = tick.command if first is None else first
            if not np.array_equal(tick.command, first):
                wrong.append(seed)

    threads = [threading.Thread(target=run, args=(seed,)) for seed in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
