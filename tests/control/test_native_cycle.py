"""The native kernel's cycle equals Python's tick, and leaves it what is out of the ordinary."""

import pickle
from collections import Counter
from contextlib import nullcontext

import numpy as np
import pytest
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform

import fikm_drake as fd
from fikm_drake.control.joint_limits import JointLimits, StepBox
from fikm_drake.control.native_cycle import (
    PARTS,
    NativeCycle,
    native_cycle,
    packed,
    search_place,
)
from fikm_drake.control.native_safe_step import native_safe_step
from fikm_drake.control.near_pairs import NearPairs
from fikm_drake.control.restart_state import RestartState
from fikm_drake.experiments.benchmarks.obstacle_scenes import obstacle_scenes
from fikm_drake.experiments.fuzz.native_fuzz import native_case
from fikm_drake.kinematics.native import kernel as loading
from fikm_drake.kinematics.native.kernel import numpy_only
from fikm_drake.kinematics.tasks import make_task

POSE_LAW = fd.FuzzyMapping(iterations=6, damping=0.1, row_floor=0.05)


@pytest.fixture(autouse=True)
def with_kernel(native_kernel, monkeypatch):
    monkeypatch.setattr(loading, "_load", lambda: (native_kernel, ""))


@pytest.fixture
def counted(monkeypatch):
    """Counts cycles that the kernel did, those that it left, and calmed ones among the former."""
    counts, advance = Counter(), NativeCycle.advance

    def count(self, command, velocity, memory, *inputs):
        done = advance(self, command, velocity, memory, *inputs)
        counts["done" if done else "left"] += 1
        counts["calmed"] += done and memory[1 + self._cycle.task.size + 1] < 1.0
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
        {"law": fd.FuzzyMapping(iterations=2)},
        {"law": fd.DampedLeastSquares()},
    ],
)
def test_other_configurations_are_pythons(options):
    assert native_cycle(make_cycle("arm7")) is not None
    assert native_cycle(make_cycle("arm7", **options)) is None


def test_the_numbers_are_those_of_the_kernel(native_kernel):
    assert native_kernel.cycle_size() == sum(PARTS.values())


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
        assert native.tick(*own, target, q) is None
        for part, old in zip(own, before):
            np.testing.assert_array_equal(part, old)


def run_beside(plain, native, state, target, cycles, others=lambda k: None):
    """Cycles of Python from `state`, each beside the kernel's; what the searches did in the latter's."""
    found, place = Counter(), search_place(state).start
    for k in range(cycles):
        own = [state.command.copy(), state.velocity.copy(), packed(state)]
        before = RestartState(int(own[2][place])) if plain.restart else None
        at = others(k)
        seen = native.tick(*own, target, own[0].copy(), at)
        done = native.advance(*own, target, state.command, at)
        with numpy_only():
            tick = plain.tick(state, target, state.command, others=at)
            status = plain.status(state, tick)
            assert seen is None or plain.status(state, seen) == status
            plain.advance(state, target, state.command, tick, at)
        assert done == (seen is not None)
        if not done:
            continue
        for mine, other in zip(own, (state.command, state.velocity, packed(state))):
            np.testing.assert_allclose(mine, other, rtol=1e-9, atol=1e-12, err_msg=f"cycle {k}")
        assert seen.cleared.pair == tick.cleared.pair
        found["done"] += 1
        found[before] += 1
        found["pushed"] += seen.cleared.pair[0] >= 0
    return found


def scene_cycles(arm, kind, task, **options):
    """A scene of the benchmark: the cycle by numpy, the kernel's, the state before, the target."""
    (scene,) = obstacle_scenes(arm, kind, task, 1, 0)
    law = POSE_LAW if task == "pose" else fd.FuzzyMapping(iterations=3)
    options = {"law": law, "control_rate": 100.0, **options}
    kinds = {"position": fd.PositionTask, "pose": fd.PoseTask}
    chosen = kinds[task](fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm(arm))))
    config, checker = fd.FuzzyIkConfig(task=task, **options), scene.checker()
    cycles = []
    for without in (numpy_only, nullcontext):  # the same task: its own test compares it with Drake
        with without():
            cycles.append(fd.ControlCycle(chosen, config, collision_checker=checker))
    target = RigidTransform(scene.target) if task == "pose" else scene.target[:3, 3]
    return cycles[0], native_cycle(cycles[1]), cycles[0].start(scene.start), target


@pytest.mark.parametrize(
    ("arm", "kind", "task"),
    [
        ("panda", "boxes", "position"),
        ("panda", "spheres", "position"),
        ("ur5", "boxes", "pose"),
        ("iiwa14", "shelf", "pose"),
    ],
)
@pytest.mark.parametrize("search", [False, True])
def test_among_obstacles_it_equals_numpys(arm, kind, task, search):
    plain, native, state, target = scene_cycles(arm, kind, task, restart_search=search)
    found = run_beside(plain, native, state, target, 250)
    assert found["done"] > 150
    if arm == "panda":
        assert found["pushed"] > 50
    if arm == "panda" and search:
        assert found[RestartState.SEARCHING] > 5 and found[RestartState.UNDERWAY] > 5


def test_what_was_looked_at_ahead_is_not_asked_again(monkeypatch):
    """An arm slides along obstacles: the end of its step is where it is next. A new shape is seen at once."""
    plain, native, state, target = scene_cycles("panda", "boxes", "pose")
    checker, asked, ask = plain.clearance._checker, [], NearPairs.ask

    def count(self, *inputs):
        asked.append(self)
        return ask(self, *inputs)

    monkeypatch.setattr(NearPairs, "ask", count)
    for k in range(120):
        if k == 100:
            times = asked.count(native._cycle.clearance.near)
            body = checker.plant().GetBodyByName("tool")
            held = RigidTransform([0.0, 0.0, 0.1])
            assert checker.AddCollisionShapeToBody("held", body, Sphere(0.4), held)
        own = [state.command.copy(), state.velocity.copy(), packed(state)]
        done = native.advance(*own, target, state.command)
        with numpy_only():
            tick = plain.tick(state, target, state.command)
            plain.advance(state, target, state.command, tick)
        if done:
            np.testing.assert_allclose(own[0], state.command, rtol=1e-9, atol=1e-12)
            state.command[:] = own[0]  # to the bit what was looked at
    assert times < 1.4 * 100


def test_obstacles_that_move_are_told():
    plain, native, state, target = scene_cycles("iiwa14", "second arm", "position")
    default = plain.clearance.default_others
    found = run_beside(
        plain, native, state, target, 100, lambda k: default + 0.1 * np.sin(0.05 * k)
    )
    assert found["done"] > 50


@pytest.mark.parametrize("measured", [False, True])
def test_a_search_in_a_free_world_equals_pythons(measured):
    """The stretched arm: watched, searched, driven; measured joints are those of the last cycle."""
    options = {"restart_search": True, "measured_position": measured, "singularity_nudge": 0.0}
    cycle = make_cycle("planar2", **options)
    with numpy_only():
        plain = fd.ControlCycle(cycle.task, cycle.config)
    state, target = plain.start(np.zeros(2)), np.array([1.0, 0.0, 0.0])
    found = run_beside(plain, native_cycle(cycle), state, target, 150)
    assert all(found[s] > 5 for s in (RestartState.NONE, RestartState.UNDERWAY)), found
    assert found[RestartState.SEARCHING]
    assert np.linalg.norm(plain.task.error(target, state.command)) < 1e-3


@pytest.mark.parametrize("acceleration", [[], [20.0]])
@pytest.mark.parametrize("task", ["position", "pose"])
def test_joints_that_draw_back_equal_pythons(task, acceleration, counted):
    """Near the target and far, with limits in the way."""
    config = fd.FuzzyIkConfig(task=task, acceleration_limits=acceleration).for_reaching()
    arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("iiwa14")))
    cycle = fd.ControlCycle(make_task(arm, task), config)
    native = native_cycle(cycle)
    with numpy_only():
        plain = fd.ControlCycle(cycle.task, config)
    rng = np.random.default_rng(0)
    for _ in range(6):
        q = 0.7 * rng.uniform(arm.lower, arm.upper)
        goal = RigidTransform(arm.chain.forward_kinematics(0.7 * rng.uniform(arm.lower, arm.upper)))
        goal = goal if task == "pose" else goal.translation()
        state = cycle.start(q)
        for k in range(150):
            own = [state.command.copy(), state.velocity.copy(), packed(state)]
            done = native.advance(*own, goal, state.command)
            with numpy_only():
                plain.advance(state, goal, state.command, plain.tick(state, goal, state.command))
            other = state.command, state.velocity, packed(state)
            for mine, his in zip(own, other) if done else ():
                np.testing.assert_allclose(mine, his, rtol=1e-9, atol=1e-12, err_msg=f"cycle {k}")
    assert counted["done"] > 800


@pytest.mark.parametrize("arm", ["arm7", "ur5"])
@pytest.mark.parametrize("acceleration", [2.0, 30.0])
@pytest.mark.parametrize("task", ["position", "pose"])
def test_limits_that_take_a_part_equal_pythons(arm, acceleration, task):
    """Far targets, one after the other, of slow joints: saturated, braked, cut off by the guard."""
    options = {"acceleration_limits": [acceleration], "velocity_limits": [0.8], "law": POSE_LAW}
    cycle = make_cycle(arm, task, **options)
    with numpy_only():
        plain = fd.ControlCycle(cycle.task, cycle.config)
    rng, done = np.random.default_rng(0), 0
    lower, upper = np.maximum(plain.task.arm.lower, -2.0), np.minimum(plain.task.arm.upper, 2.0)
    state = plain.start(rng.uniform(lower, upper))
    for _ in range(5):
        pose = plain.task.arm.pose(plain.task.arm.context_at(rng.uniform(lower, upper)))
        target = pose if task == "pose" else pose.translation()
        found = run_beside(plain, native_cycle(cycle), state, target, 60)
        done += found["done"]
    assert done > 280


@pytest.mark.parametrize("resolved", [False, True])
@pytest.mark.parametrize("acceleration", [np.inf, 5.0])
@pytest.mark.parametrize(
    "options", [{}, {"posture_rate": 0.2}, {"posture_rate": 0.2, "limit_retreat": 0.06}]
)
def test_a_step_inside_limits_equals_pythons(resolved, acceleration, options):
    """The block of the Diagram: the step before the guard, obstacles near or not, with a posture or not."""
    cycle = make_cycle("iiwa14", "pose", law=POSE_LAW, **options)
    arm, law, rng = cycle.task.arm, cycle.law, np.random.default_rng(1)
    limits = JointLimits(
        arm.lower, arm.upper, period=0.01, velocity_limits=1.0, acceleration_limits=acceleration
    )
    native = native_safe_step(cycle.task, law, cycle.safe_step, limits)
    taken = Counter()
    for _ in range(300):
        q = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
        q[0] = arm.upper[0] - rng.choice([0.0, 0.002, 0.5])
        error = rng.normal(size=6) * 10.0 ** rng.uniform(-6.0, 0.0)
        done = native(q, error, q, 0.1, resolved=resolved)
        if options and not done:  # nearly singular
            continue
        with numpy_only():
            J, box = cycle.task.jacobian(q), StepBox(limits, q)
            step, limited = cycle.safe_step.inside(q, J, error, box, 0.1, resolved=resolved)
        np.testing.assert_allclose(done[0], step, rtol=1e-9, atol=1e-12)
        assert done[1] == limited
        taken[limited] += 1
    assert len(taken) == 2 and min(taken.values()) > (0 if options else 30)


def test_a_cycle_is_pickled_with_its_step():
    """As runs in other processes need it."""
    cycle = make_cycle("arm7")
    q, error = np.full(7, 0.3), np.array([0.1, 0.0, -0.1])
    native = pickle.loads(pickle.dumps(cycle.native_step))
    np.testing.assert_array_equal(
        native(q, error, q, 0.0)[0], cycle.native_step(q, error, q, 0.0)[0]
    )


def test_threads_do_not_share_buffers(in_threads):
    cycle = make_cycle("arm7")
    native = native_cycle(cycle)

    def run(seed):
        start = np.random.default_rng(seed).uniform(-0.5, 0.5, 7)
        target, state = np.array([0.5, 0.1 * seed, 0.4]), cycle.start(start)
        memory = packed(state)
        first = native.tick(state.command, state.velocity, memory, target, state.command)
        for _ in range(300):
            tick = native.tick(state.command, state.velocity, memory, target, state.command)
            np.testing.assert_array_equal(tick.command, first.command)

    in_threads(run)
