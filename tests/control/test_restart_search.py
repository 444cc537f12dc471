"""The way out of dead points and local minima: when it begins, what it costs, how it ends."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

import fikm_drake as fd
from fikm_drake import RestartState
from fikm_drake.control.restart_search import LOOKS, PATIENCE, STARTS, RestartSearch

PACE = 0.03


class Counted:
    """Task error and Jacobian of an arm, with the number of calls."""

    def __init__(self, arm, rows):
        self.arm, self.rows, self.calls = arm, rows, 0

    def __call__(self, desired, q):
        self.calls += 1
        tool = self.arm.forward_kinematics(q)[:3, 3]
        return desired - tool[[row - 3 for row in self.rows]], self.arm.jacobian(q)[self.rows]


class Loop:
    """A detour round a law that takes half of what is left, cycle by cycle."""

    def __init__(self, arm, q, target, law=None):
        self.arm = fd.load_arm(arm)
        rows = [3, 4] if arm.startswith("planar") else [3, 4, 5]
        self.kinematics = Counted(self.arm, rows)
        self.restart_search = RestartSearch(
            self.kinematics,
            len(rows),
            lower=self.arm.lower,
            upper=self.arm.upper,
            tolerance=1e-3,
            pace=PACE,
        )
        self.law = law or fd.FuzzyMapping(row_floor=0.05)
        self.memory = self.restart_search.initial_memory()
        self.q, self.target = np.array(q, dtype=float), np.array(target)
        self.states, self.path, self.costs = [], [self.q], []

    @property
    def state(self):
        return self.restart_search.state(self.memory)

    @property
    def error(self):
        return float(np.linalg.norm(self.kinematics(self.target, self.q)[0]))

    def cycle(self, cycles=1, target=None):
        for _ in range(cycles):
            self.target = self.target if target is None else np.array(target)
            self.states.append(self.state)
            dr, J = self.kinematics(self.target, self.q)
            step = self.restart_search.step(self.memory, self.q, self.law.step(J, 0.5 * dr))
            before = self.kinematics.calls
            size = float(np.linalg.norm(dr))
            self.restart_search.remember(self.memory, self.target, self.q, size)
            self.costs.append(self.kinematics.calls - before)
            self.q = np.clip(self.q + step, self.arm.lower, self.arm.upper)
            self.path.append(self.q)
        return self

    def until(self, *states, most=2000):
        while self.state not in states:
            assert len(self.states) < most
            self.cycle()
        return self


def stretched(target=(1.0, 0.0)):
    """planar2, stretched, with a target straight inward: a dead point of every local law."""
    return Loop("planar2", [0.0, 0.0], target)


def test_the_stretched_arm_is_led_out_and_back_to_the_law():
    loop = stretched().until(RestartState.SEARCHING)
    assert len(loop.states) == PATIENCE // 3 + 2  # the first cycle has nothing to compare with
    np.testing.assert_array_equal(loop.path, np.zeros((len(loop.path), 2)))
    loop.until(RestartState.UNDERWAY).until(RestartState.NONE)
    assert len(loop.states) < 200
    loop.cycle(20)
    assert loop.error < 1e-4
    assert loop.state == RestartState.NONE


def test_the_way_is_straight_at_its_pace_and_ends_softly():
    loop = stretched().until(RestartState.UNDERWAY)
    posture, start = loop.memory[4:].copy(), len(loop.path) - 1
    assert np.linalg.norm(loop.kinematics(loop.target, posture)[0]) <= 0.5e-3
    loop.until(RestartState.NONE)
    way = np.array(loop.path[start:])
    steps = np.diff(way, axis=0)
    largest = np.abs(steps).max(axis=1)
    assert largest.max() <= PACE * (1 + 1e-12) and largest[0] == pytest.approx(PACE)
    total = posture - way[0]
    along = (way - way[0]) @ total / (total @ total)
    np.testing.assert_allclose(way - way[0], np.outer(along, total), atol=1e-12)
    assert (np.diff(largest) <= 1e-12).all() and largest[-1] < 1e-3
    assert np.abs(posture - way[-1]).max() <= 1.5e-3


def test_only_on_the_way_is_the_law_s_step_replaced():
    loop, step = stretched(), np.array([0.1, -0.2])
    for state in RestartState:
        loop.memory[0] = state
        taken = loop.restart_search.step(loop.memory, loop.q, step)
        assert (taken is step) == (state != RestartState.UNDERWAY)


def test_a_law_that_gets_nearer_is_left_alone():
    loop = Loop("planar2", [0.3, 0.5], [0.2, 0.9]).cycle(200)
    assert set(loop.states) == {RestartState.NONE}
    assert loop.error < 1e-6


def test_a_slow_law_is_left_alone_while_it_gets_nearer():
    """Half a percent of the error a cycle."""
    loop = Loop("planar2", [0.3, 0.5], [0.2, 0.9])
    step = loop.law.step
    loop.law = type("Slow", (), {"step": staticmethod(lambda J, dr: 0.01 * step(J, dr))})
    loop.cycle(400)
    assert set(loop.states) == {RestartState.NONE}


def test_a_law_that_moves_but_gets_nowhere_has_more_patience():
    """`PATIENCE` cycles, where one at rest needs a third of them."""
    loop = stretched()
    turn = [1.0]

    def sway(J, dr):  # to and fro
        turn[0] = -turn[0]
        return np.array([0.02, 0.0]) * turn[0]

    loop.law = type("Sways", (), {"step": staticmethod(sway)})
    loop.until(RestartState.SEARCHING)
    assert PATIENCE <= len(loop.states) <= PATIENCE + 3


def test_a_target_that_moves_is_followed_and_not_searched_for():
    """Out of reach all the time: its motion is what counts."""
    loop = stretched()
    for k in range(300):
        loop.cycle(target=[2.0 + 0.001 * k, 0.0])
    assert set(loop.states) == {RestartState.NONE}


def test_a_target_out_of_reach_ends_stuck_until_it_moves():
    loop = stretched([2.5, 0.0]).until(RestartState.STUCK)
    assert len(loop.states) < 100 + STARTS * 8 / LOOKS * 6
    loop.cycle(200)
    assert loop.state == RestartState.STUCK
    np.testing.assert_array_equal(loop.q, loop.path[0])
    loop.cycle(target=[2.45, 0.0])  # by less than a tenth of the error of 1 m
    assert loop.state == RestartState.STUCK
    loop.cycle(target=[1.0, 0.0])
    assert loop.state == RestartState.NONE
    loop.until(RestartState.UNDERWAY).until(RestartState.NONE).cycle(20)
    assert loop.error < 1e-4


@pytest.mark.parametrize(("arm", "target"), [("planar4", [0.0, 2.5]), ("puma560", [3.0, 0.0, 0.0])])
def test_a_cycle_s_cost_is_bounded(arm, target):
    """`LOOKS` steps of the search, and the starts are sorted anew for at most one of them."""
    loop = Loop(arm, fd.load_arm(arm).default_position, target).until(RestartState.STUCK, most=4000)
    assert max(loop.costs) <= LOOKS + STARTS
    assert np.mean(loop.costs) < 2 * LOOKS + STARTS
    loop.cycle(5)
    assert max(loop.costs[-5:]) <= 1


def test_a_search_is_the_same_each_time():
    loops = [Loop("puma560", np.full(6, 0.1), [-0.3, 0.2, 0.1]).cycle(200) for _ in range(2)]
    np.testing.assert_array_equal(loops[0].path, loops[1].path)
    assert loops[0].states == loops[1].states and RestartState.UNDERWAY in loops[0].states


def test_postures_stay_inside_the_joint_limits():
    loop = Loop("puma560", fd.load_arm("puma560").upper, [-0.3, 0.4, -0.1])
    for _ in range(80):
        loop.cycle()
        if loop.state != RestartState.NONE:
            posture = loop.memory[4:]
            assert (posture >= loop.arm.lower).all() and (posture <= loop.arm.upper).all()
    assert RestartState.SEARCHING in loop.states


@pytest.mark.parametrize("state", [RestartState.SEARCHING, RestartState.UNDERWAY])
def test_a_lost_target_ends_a_restart(state):
    for bad in (np.nan, np.inf):
        loop = stretched().until(state)
        loop.restart_search.remember(loop.memory, loop.target, loop.q, bad)
        assert loop.state == RestartState.NONE


def test_a_target_that_leaves_its_place_ends_the_way():
    loop = stretched().until(RestartState.UNDERWAY).cycle(5)
    loop.cycle(target=[1.0, 0.005])  # within ten tolerances: it goes on
    assert loop.state == RestartState.UNDERWAY
    loop.cycle(target=[1.0, 0.02])
    assert loop.state == RestartState.NONE


def test_a_way_that_is_held_up_is_given_up():
    """An arm that does not follow, such as one at a limit that it was not told of."""
    loop = stretched().until(RestartState.UNDERWAY)
    way = np.abs(loop.memory[4:] - loop.q).max()
    cycles = 0
    while loop.state == RestartState.UNDERWAY and cycles < 1000:
        loop.restart_search.remember(loop.memory, loop.target, loop.q, loop.error)
        cycles += 1
    assert way / PACE < cycles <= 3 * way / PACE + PATIENCE + 1


def test_a_target_reached_ends_a_search():
    loop = stretched().until(RestartState.SEARCHING)
    loop.restart_search.remember(loop.memory, loop.target, loop.q, 1e-3)
    assert loop.state == RestartState.NONE


@pytest.mark.parametrize("arm", ["arm7", "iiwa14"])
def test_the_memory_is_finite_and_as_long_as_it_says(arm):
    loop = Loop(arm, np.zeros(7), [0.0, 0.3, 0.4])
    size = len(loop.memory)
    assert not loop.memory.any() and size == 4 + 7
    for _ in range(100):
        loop.cycle()
        assert len(loop.memory) == size and np.isfinite(loop.memory).all()


def searched(arm, pose, cycles=600):
    """The joints after a drive to a pose with restart search, and the last status."""
    config = fd.FuzzyIkConfig(
        task="pose",
        characteristic_length=0.3 * arm.chain.reach,
        restart_search=True,
        tolerance=1e-3 * arm.chain.reach,
        error_limit=0.2 * arm.chain.reach,
        law=fd.FuzzyMapping.iterated(),
    )
    plant = fd.MakeDhArmPlant(arm)
    cycle = fd.ControlCycle(fd.PoseTask(fd.PlantArm(plant), config.characteristic_length), config)
    state, path = cycle.start(arm.default_position), []
    for _ in range(cycles):
        tick = cycle.tick(state, pose, state.command)
        cycle.advance(state, pose, state.command, tick)
        path.append(state.command.copy())
    return np.array(path), tick.error_length / arm.chain.reach


@pytest.mark.parametrize("size", [0.1, 10.0])
def test_arms_of_all_sizes_search_alike(size):
    """Errors are judged by the reach: a large arm gives no start up that a small one follows."""
    table = fd.load_arm("puma560").table
    for row in (*table.joints, table.tool):
        row.a *= size
        row.d *= size
    arm, other = fd.load_arm("puma560"), fd.DhArm(table)
    rng = np.random.default_rng(3)
    reached = []
    for q in rng.uniform(arm.lower, arm.upper, (6, 6)):
        pairs = []
        for one in (arm, other):
            pose = RigidTransform(one.forward_kinematics(q))
            pairs.append(searched(one, pose)[1] < 1e-3)
        reached.append(pairs)
    assert np.array(reached)[:, 0].sum() >= 5
    np.testing.assert_array_equal(*np.transpose(reached))


def test_no_whole_turn_is_made_on_the_way():
    """A joint that may turn twice goes to the nearest of the same postures: half a turn at most."""
    arm = fd.load_arm("ur5")
    lower, upper = np.full(6, -2 * np.pi), np.full(6, 2 * np.pi)

    def kinematics(desired, q):
        return desired - arm.forward_kinematics(q)[:3, 3], arm.jacobian(q)[3:]

    rng, ways = np.random.default_rng(5), []
    for start, goal in rng.uniform(-np.pi, np.pi, (10, 2, 6)):
        search = RestartSearch(
            kinematics,
            3,
            lower=lower,
            upper=upper,
            tolerance=1e-3,
            pace=PACE,
            turning=arm.chain.revolute,
        )
        memory, target = search.initial_memory(), arm.forward_kinematics(goal)[:3, 3]
        error = float(np.linalg.norm(kinematics(target, start)[0]))
        for _ in range(200):
            search.remember(memory, target, start, error)
            if search.state(memory) == RestartState.UNDERWAY:
                break
        assert search.state(memory) == RestartState.UNDERWAY
        ways.append(np.abs(memory[4:10] - start).max())
    assert max(ways) <= np.pi + 1e-9
