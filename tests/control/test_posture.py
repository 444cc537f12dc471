"""The posture that a redundant arm prefers: no motion of the tool, and it goes there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake.control.posture import DAMPING, posture_step


def matrices(seed, shape=(3, 7)):
    rng = np.random.default_rng(seed)
    return rng.normal(size=shape), rng.normal(size=shape[1])


@given(st.integers(0, 10**6), st.sampled_from([(3, 7), (6, 7), (1, 4), (2, 2)]))
def test_the_tool_does_not_move(seed, shape):
    """J N pull = λ (J Jᵀ + λ)⁻¹ J pull, which λ/(σ² + λ) bounds."""
    J, pull = matrices(seed, shape)
    damping = DAMPING * np.trace(J @ J.T)
    least = np.linalg.svd(J, compute_uv=False).min() ** 2
    bound = damping / (least + damping) * np.linalg.norm(J @ pull)
    assert np.linalg.norm(J @ posture_step(J, pull)) <= bound * (1 + 1e-6) + 1e-12


@given(st.integers(0, 10**6))
def test_it_is_the_projection_on_the_null_space(seed):
    J, pull = matrices(seed)
    _, s, Vt = np.linalg.svd(J)
    expected = Vt[3:].T @ Vt[3:] @ pull
    tolerance = 10 * DAMPING * np.trace(J @ J.T) / s.min() ** 2
    np.testing.assert_allclose(posture_step(J, pull), expected, atol=tolerance)
    assert pull @ posture_step(J, pull) >= 0.0  # never away from the posture
    np.testing.assert_allclose(posture_step(J, -2 * pull), -2 * posture_step(J, pull), atol=1e-12)


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6, 1e-100])
def test_the_unit_of_length_does_not_count(scale):
    J, pull = matrices(1)
    np.testing.assert_allclose(posture_step(scale * J, pull), posture_step(J, pull), rtol=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("arm", ["planar2", "planar4", "iiwa14"])
def test_at_a_singular_posture_it_stays_finite(arm):
    arm = fd.load_arm(arm)
    rows = slice(3, 5) if arm.name.startswith("planar") else slice(0, 6)
    J = arm.jacobian(np.zeros(arm.num_joints))[rows]
    assert np.linalg.matrix_rank(J, tol=1e-9) < len(J)
    step = posture_step(J, np.ones(arm.num_joints))
    assert np.linalg.norm(step) <= np.sqrt(arm.num_joints) * (1 + 1e-9)
    assert np.linalg.norm(J @ step) < 1e-4


@pytest.mark.filterwarnings("error")
def test_a_tool_that_nothing_moves_leaves_the_joints_free():
    np.testing.assert_allclose(posture_step(np.zeros((3, 4)), np.ones(4)), np.ones(4))


def self_motion(arm, start, config, seconds):
    """An arm at a target that it has reached, for a while."""
    tool = fd.load_arm(arm).forward_kinematics(start)[:3, 3].tolist()
    scenario = fd.TrackingScenario(
        arm=arm, waypoints=[tool], hold=seconds, initial_position=start, config=config
    )
    return fd.simulate(scenario)


START = [0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("nominal", [[], [0.5, -0.2, 0.1, 0.4, 0.3, -0.4, 0.2]])
def test_a_redundant_arm_goes_to_its_nominal_posture_at_rest(nominal):
    """As near as the task lets it: what is left of the pull is all of the task's rows."""
    config = fd.FuzzyIkConfig(posture_rate=2.0, nominal_position=nominal, fused=True)
    log = self_motion("arm7", START, config, 12.0)
    assert np.linalg.norm(log.cycles.error, axis=1).max() < config.tolerance
    pull = (np.array(nominal) if nominal else np.zeros(7)) - log.cycles.q
    distance = np.linalg.norm(pull, axis=1)
    assert distance[-1] < distance[0] - 0.05
    assert (np.diff(distance) < 1e-6).all()
    arm = fd.load_arm("arm7")
    left = [posture_step(arm.jacobian(log.cycles.q[k])[3:], pull[k]) for k in (0, -1)]
    assert np.linalg.norm(left[1]) < 1e-4 * np.linalg.norm(left[0])
    stays = self_motion("arm7", START, fd.FuzzyIkConfig(fused=True), 1.0)
    np.testing.assert_allclose(stays.q, np.tile(START, (len(stays.q), 1)), atol=1e-12)


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_the_gain_is_a_rate(rate):
    """Of a joint that the task leaves alone: exp(−gain · t), in Euler's steps."""
    start = [0.2, 0.6, 0.0, -1.4, 0.0, 1.0, 0.1]
    config = fd.FuzzyIkConfig(posture_rate=2.0, nominal_position=[*start[:6], 1.1])
    tool = fd.load_arm("iiwa14").forward_kinematics(start)[:3, 3].tolist()
    log = fd.simulate(
        fd.TrackingScenario(
            "iiwa14",
            [tool],
            hold=1.0,
            control_rate=rate,
            initial_position=start,
            config=config,
        )
    )
    left = (1 - 2 / rate) ** np.arange(1, len(log.cycles.q) + 1)
    np.testing.assert_allclose(1.1 - log.cycles.q[:, 6], left, atol=1e-6)
