"""A step that keeps clear, on arms with capsules among shapes."""

import dataclasses

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform

import fikm_drake as fd
from fikm_drake.control.clearance import LOSS, Clearance
from fikm_drake.control.clearance_config import (
    ClearanceConfig,
    clearance_table,
    load_clearance_rules,
)

HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
ARM = fd.load_arm("iiwa14")
TOOL = ARM.forward_kinematics(HOME)[:3, 3]


@pytest.fixture
def clearance(checker_with):
    def guard(*shapes, rate=100.0, config=None, floating=False):
        checker = checker_with(*shapes, floating=floating, padding=0.03)
        return Clearance(checker, config, period=1.0 / rate)

    return guard


def drive(guard, target, seconds=3.0, rate=100.0, start=HOME):
    """Least clearance on the way, final error and the last step, of a plain loop with speed limits."""
    law, q, least = fd.FuzzyMapping(iterations=3), start.copy(), np.inf
    fastest = ARM.velocity_limits / rate
    for _ in range(round(seconds * rate)):
        error = target - ARM.forward_kinematics(q)[:3, 3]
        J = ARM.jacobian(q)[3:]
        step = law(J, min(1.0, 10.0 / rate) * error)
        step = step / max(1.0, np.abs(step / fastest).max())
        step, _ = guard(q, step, J=J, low=-fastest, high=fastest)
        q = q + step
        least = min(least, guard.distance(q))
    return least, np.linalg.norm(target - ARM.forward_kinematics(q)[:3, 3]), np.abs(step).max()


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
@pytest.mark.parametrize("shape", [Sphere(0.1), Box(0.1, 0.1, 0.3)])
def test_an_arm_goes_round_and_keeps_the_safe_distance(rate, shape, clearance):
    target = TOOL + [-0.1, -0.45, 0.05]
    guard = clearance((shape, 0.5 * (TOOL + target)), rate=rate)
    least, error, last = drive(guard, target, rate=rate, seconds=0.6 if rate > 500 else 3.0)
    assert least >= guard.config.safe_distance - LOSS
    if rate < 500 and isinstance(shape, Sphere):  # the box's flat side is a local minimum
        assert error < 1e-3 and last < 1e-5


def test_without_anything_near_the_step_is_the_step(clearance):
    guard = clearance((Sphere(0.1), [-0.8, 0.0, 0.0]))
    step = np.full(7, 1e-3)
    kept, info = guard(HOME, step)
    assert np.array_equal(kept, step)
    assert info == (np.inf, False, (-1, -1))


@pytest.mark.parametrize("away", [0.2, 0.14, 0.1])  # clear; the padding penetrated; penetrated
def test_rows_are_the_derivatives_of_the_distances(away, clearance):
    guard = clearance((Sphere(0.1), TOOL + [0.0, away, 0.0]))
    near = guard.near(HOME)
    assert len(near.distances)
    for j in range(7):
        h = np.zeros(7)
        h[j] = 1e-6
        change = guard.near(HOME + h).distances - guard.near(HOME - h).distances
        np.testing.assert_allclose(change / 2e-6, near.rows[:, j], atol=1e-5)


@pytest.mark.parametrize("kernel", [True, False])
def test_from_penetration_it_backs_out(clearance, kernel, monkeypatch):
    """At once, each cycle a little, no faster than the retreat speed; then it rests."""
    guard = clearance((Sphere(0.1), TOOL))
    if not kernel:
        monkeypatch.setattr(guard, "_native", None)
    assert guard.distance(HOME) < -0.05
    q, distances = HOME.copy(), []
    for _ in range(150):
        distances.append(guard.distance(q))
        step, info = guard(q, np.zeros(7))
        assert info.distance == pytest.approx(distances[-1], abs=1e-12)
        q = q + step
    inside = np.array(distances) < guard.config.safe_distance - 1e-3
    won = np.diff(distances)[inside[1:]]
    assert (won > 0.0).all()
    assert won.max() <= 1.5 * guard.config.retreat_speed * guard.period
    assert guard.distance(q) >= guard.config.safe_distance - 1e-3
    assert np.abs(step).max() < 1e-3


def test_the_pair_that_blocks_has_names(clearance):
    guard = clearance((Box(0.05, 1.0, 1.0), TOOL + [0.12, 0.0, 0.0]))
    J = ARM.jacobian(HOME)[3:]
    q = HOME.copy()
    for _ in range(100):
        J = ARM.jacobian(q)[3:]
        step, info = guard(q, np.linalg.pinv(J) @ [0.01, 0.0, 0.0], J=J)
        q = q + step
    assert info.blocked
    one, two = guard.names(info.pair)
    assert one.startswith("iiwa14::link") and two.endswith("::world")
    assert guard.names((-1, -1)) == ("", "")
    assert guard.distance(q) == pytest.approx(guard.config.safe_distance, abs=1e-3)


def test_the_elbow_gives_way_and_the_tool_goes_on(clearance):
    """What obstacles take of the task is asked of the joints that are free."""
    elbow = ARM.link_poses(HOME)[3][:3, 3]
    guard = clearance((Sphere(0.05), elbow + [0.0, 0.125, 0.0]))
    J = ARM.jacobian(HOME)[3:]
    away = np.linalg.svd(J)[2][3:]  # motions that leave the tool where it is
    near = guard.near(HOME)
    toward = -away.T @ (away @ near.rows[near.distances.argmin()])
    step = np.linalg.pinv(J) @ [0.0, 0.0, 0.01] + 0.05 * toward / np.linalg.norm(toward)
    kept, info = guard(HOME, step, J=J)
    assert np.linalg.norm(kept - step) > 0.01
    assert np.linalg.norm(J @ (kept - step)) < 0.15 * np.linalg.norm(J @ step)
    assert not info.blocked


def test_what_moves_toward_the_arm_is_evaded(clearance):
    """Its speed counts: without it the arm is later, and the distance less."""
    least = []
    for seen in (True, False):
        guard = clearance((Sphere(0.08), [0.0, 0.0, 0.0]), floating=True)
        q, before, nearest = HOME.copy(), None, np.inf
        for k in range(200):
            position = TOOL + [0.0, 0.35 - 0.15 * k / 100.0, 0.0]
            others = np.r_[1.0, 0.0, 0.0, 0.0, position]
            q = q + guard(q, np.zeros(7), others=others, others_before=before)[0]
            nearest = min(nearest, guard.distance(q, others))
            before = others if seen else None
        assert position[1] < TOOL[1] + 0.06  # it went to where the tool was
        least.append(nearest)
    assert least[0] >= guard.config.safe_distance - 1e-3
    assert least[1] < least[0] - 1e-4


def test_what_a_hand_holds_counts(checker_with):
    """Its distance, and the step: what is held is kept clear of the table, not only the hand."""
    checker = checker_with((Box(0.4, 0.4, 0.02), TOOL + [0.0, 0.0, -0.25]), padding=0.03)
    guard = Clearance(checker, period=0.01)
    alone, (down, _) = guard.distance(HOME), drive_down(guard)
    body = checker.plant().GetBodyByName("tool")
    checker.AddCollisionShapeToBody("ball", body, Sphere(0.09), RigidTransform([0.0, 0.0, 0.08]))
    assert guard.distance(HOME) < alone
    held, q = drive_down(guard)
    assert held < down - 0.05
    assert guard.distance(q) >= guard.config.safe_distance - LOSS
    checker.RemoveAllAddedCollisionShapes()
    assert guard.distance(HOME) == alone


def drive_down(guard):
    """How far down the tool comes [m], and where the joints then are."""
    q = HOME.copy()
    for _ in range(200):
        J = ARM.jacobian(q)[3:]
        q = q + guard(q, np.linalg.pinv(J) @ [0.0, 0.0, -0.005], J=J)[0]
    return TOOL[2] - ARM.forward_kinematics(q)[2, 3], q


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_not_finite_never_reaches_the_checker(bad, clearance):
    guard = clearance((Sphere(0.1), TOOL), floating=True)
    broken, fine = HOME.copy(), np.zeros(7)
    broken[2] = bad
    others = guard.default_others
    others[0] = bad
    for step in (
        guard(broken, fine)[0],
        guard(HOME, broken)[0],
        guard(HOME, fine, others=others)[0],
    ):
        assert (step == 0.0).all()
    assert np.isnan(guard.distance(broken)) and np.isnan(guard.distance(HOME, others))
    assert not guard.is_clear(broken) and not guard.is_clear(HOME, others)
    assert guard.room(broken) == guard.room(HOME, others) == -np.inf


def test_a_step_that_would_leap_over_an_obstacle_is_shortened(clearance):
    guard = clearance((Sphere(0.02), TOOL + [0.0, 0.4, 0.0]))
    leap = np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    q, least = HOME.copy(), np.inf
    for _ in range(60):
        q = q + guard(q, leap)[0]
        least = min(least, guard.distance(q))
    assert least >= guard.config.safe_distance - LOSS


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("safe_distance", -0.1, "safe_distance"),
        ("safe_distance", 0.1, "more than safe_distance"),
        ("influence_distance", np.inf, "influence_distance"),
        ("retreat_speed", 0.0, "retreat_speed"),
        ("rules", 3, "rules"),
        ("rules", "labvolt_theta3", "distance"),
    ],
)
def test_bad_config(field, value, words):
    with pytest.raises(ValueError, match=words):
        dataclasses.replace(ClearanceConfig(), **{field: value}).validate()


def test_no_such_rules():
    with pytest.raises(FileNotFoundError, match="clearance"):
        ClearanceConfig(rules="careless").validate()


def test_config_goes_through_yaml():
    config = ClearanceConfig(safe_distance=0.02, rules="clearance")
    assert yaml_load_typed(schema=ClearanceConfig, data=yaml_dump_typed(config)) == config


def test_the_table_is_the_rules():
    system = load_clearance_rules("clearance")
    assert not system.holes()
    points = np.random.default_rng(0).uniform([-1.0, 0.0], [1.0, 8.0], (200, 2))
    table = clearance_table(system)
    np.testing.assert_allclose(table(*points.T), system(points).values[:, 0], atol=1e-9)
    # Nearer or faster is never less careful.
    assert (np.diff(table.consequents, axis=1) <= 1e-12).all()
    outside = table.first.knots >= 0.0
    assert (np.diff(table.consequents[outside], axis=0) >= -1e-12).all()


def test_rules_of_your_own(tmp_path, clearance):
    config = load_clearance_rules("clearance").config
    config.rules = [dataclasses.replace(rule, then={"rate": "CAREFUL"}) for rule in config.rules]
    path = tmp_path / "careful.yaml"
    yaml_dump_typed(config, filename=str(path))
    shape = Box(0.05, 1.0, 1.0), TOOL + [0.12, 0.0, 0.0]
    J = ARM.jacobian(HOME)[3:]
    step = np.linalg.pinv(J) @ [0.02, 0.0, 0.0]
    ours = clearance(shape)(HOME, step)[0]
    careful = clearance(shape, config=ClearanceConfig(rules=str(path)))(HOME, step)[0]
    assert (J @ careful)[0] < (J @ ours)[0]


def test_a_checker_of_another_plant_is_refused():
    checker = fd.MakeCollisionChecker(ARM)
    with pytest.raises(ValueError, match="no joint 'panda::finger'"):
        Clearance(checker, period=0.01, joints=["panda::finger"])
    with pytest.raises(ValueError, match="MakeCollisionChecker"):
        Clearance("checker", period=0.01)
    with pytest.raises(ValueError, match="period"):
        Clearance(checker, period=0.0)
