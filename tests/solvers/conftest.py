"""Arms and checks of solutions."""

import numpy as np
import pytest

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform

HOME = {
    "iiwa14": np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0]),
    "panda": np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
}


@pytest.fixture
def home():
    """Ready postures of arms by their names."""
    return HOME


@pytest.fixture
def scara():
    """An arm with a prismatic joint, the third."""
    right = DhJoint(alpha=0.0, a=0.0, d=0.4, lower=-2.0, upper=2.0)
    elbow = DhJoint(alpha=0.0, a=0.35, lower=-2.2, upper=2.2)
    lift = DhJoint(alpha=np.pi, a=0.25, type="prismatic", lower=0.05, upper=0.3)
    wrist = DhJoint(lower=-3.0, upper=3.0)
    return DhArm(DhTable("scara", "craig", [right, elbow, lift, wrist], DhTransform(d=0.05)))


@pytest.fixture
def reachable():
    """Makes poses (N,4,4) of random postures inside the limits: reachable(arm, count, seed)."""

    def make(arm, count, seed):
        lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
        q = np.random.default_rng(seed).uniform(lower, upper, (count, arm.num_joints))
        return arm.forward_kinematics(q)

    return make


def errors(arm, q, targets):
    """Position [m] and rotation errors [rad] by an independent way: traces of relative rotations."""
    X = arm.forward_kinematics(q)
    if targets.ndim == 2:
        return np.linalg.norm(X[:, :3, 3] - targets, axis=1), np.zeros(len(q))
    relative = np.swapaxes(X[:, :3, :3], 1, 2) @ targets[:, :3, :3]
    # |R - I|_F = 2 sqrt(2) sin(θ / 2)
    sine = np.linalg.norm(relative - np.eye(3), axis=(1, 2)) / np.sqrt(8.0)
    distance = np.linalg.norm(X[:, :3, 3] - targets[:, :3, 3], axis=1)
    return distance, 2.0 * np.arcsin(np.clip(sine, 0.0, 1.0))


@pytest.fixture
def check():
    """Checks every row of a solution against the arm's own kinematics and limits."""

    def check(arm, targets, solution, *, tolerance=(1e-3, np.pi / 360), limits=True):
        targets = np.asarray(targets, dtype=float)
        assert solution.q.shape == (len(targets), arm.num_joints)
        assert np.isfinite(solution.q).all()
        if limits:
            assert (solution.q >= arm.lower).all() and (solution.q <= arm.upper).all()
        valid = solution.status != 0
        distance, angle = errors(arm, solution.q[valid], targets[valid])
        np.testing.assert_allclose(solution.position_error[valid], distance, rtol=0, atol=1e-10)
        np.testing.assert_allclose(solution.rotation_error[valid], angle, rtol=0, atol=1e-7)
        within = (distance <= tolerance[0] + 1e-9) & (angle <= tolerance[1] + 1e-9)
        assert within[solution.success[valid]].all()
        np.testing.assert_array_equal(solution.success, solution.status == 1)
        assert np.isnan(solution.position_error[~valid]).all()
        assert np.isnan(solution.rotation_error[~valid]).all()

    return check
