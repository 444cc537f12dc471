"""Points that follow others at limited speed and acceleration."""

import numpy as np
import pytest

from fikm_drake.control.follower import follow

STEP = 1e-3
CASES = 200


def run(target, *, speed, acceleration, velocity=0.0, steps=3000):
    """Positions and velocities (N,CASES) from 0 while following target(t) -> place, velocity."""
    q, v = np.zeros(CASES), np.full(CASES, velocity)
    limits = {"speed": np.full(CASES, speed), "acceleration": acceleration}
    series = []
    for k in range(steps):
        place, slope = (np.broadcast_to(x, CASES) for x in target((k + 1) * STEP))
        q, v = follow(q, v, place, slope, step=STEP, **limits)
        series.append((q, v))
    return tuple(np.array(x) for x in zip(*series))


@pytest.mark.parametrize("acceleration", [5.0, 20.0, 200.0])
@pytest.mark.parametrize("speed", [1.5, np.inf])
def test_comes_to_a_goal_inside_the_limits(speed, acceleration):
    rng = np.random.default_rng(0)
    goals, start = rng.uniform(-2.0, 2.0, CASES), rng.uniform(-1.5, 1.5, CASES)
    q, v = run(lambda t: (goals, 0.0), speed=speed, acceleration=acceleration, velocity=start)
    v = np.concatenate([start[None], v])
    assert np.abs(v).max() <= max(speed, 1.5)
    assert np.abs(np.diff(v, axis=0)).max() <= acceleration * STEP * (1 + 1e-9)
    np.testing.assert_allclose(q[-1], goals, atol=1e-6)
    np.testing.assert_allclose(v[-1], 0.0, atol=1e-6)


@pytest.mark.parametrize("acceleration", [5.0, 20.0, 200.0])
def test_goes_as_fast_as_it_can_brake_and_does_not_overshoot(acceleration):
    goals = np.linspace(0.01, 2.0, CASES)
    q, _ = run(lambda t: (goals, 0.0), speed=np.inf, acceleration=acceleration)
    assert (q.max(axis=0) <= goals + acceleration * STEP**2).all()
    late = STEP * (q < 0.99 * goals).sum(axis=0)
    assert (late < 2.0 * np.sqrt(goals / acceleration) + 0.02).all()


def test_is_on_a_curve_that_asks_for_less_than_the_limits():
    q, _ = run(lambda t: (0.25 * t**2, 0.5 * t), speed=10.0, acceleration=20.0)
    times = STEP * np.arange(1, len(q) + 1)
    np.testing.assert_allclose(q[:, 0], 0.25 * times**2, atol=1e-6)


def test_catches_up_with_a_target_that_starts_at_once():
    q, _ = run(lambda t: (0.3 * t, 0.3), speed=np.inf, acceleration=20.0)
    behind = 0.3 * STEP * np.arange(1, len(q) + 1) - q[:, 0]
    assert behind.max() == pytest.approx(0.3**2 / (2 * 20.0), rel=0.1)
    assert behind.min() > -20.0 * STEP**2
    np.testing.assert_allclose(behind[-1], 0.0, atol=1e-9)
