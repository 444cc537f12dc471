"""One direct solve in the place of m conjugate gradients on m rows."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.laws.conjugate_gradients import conjugate_gradients


def by_iterations(J, dr, damping, floor):
    """The law's step by conjugate gradients only, from the definition of S."""
    A = np.abs(J)
    r, c = A.sum(1), A.sum(0)
    r = np.hypot(r, floor * r.max()) if floor else r
    S = J / np.sqrt(r)[:, None] / np.sqrt(c)
    return conjugate_gradients(S, dr / np.sqrt(r), len(dr), damping) / np.sqrt(c)


def poses(name, count, seed):
    arm, rng = fd.load_arm(name), np.random.default_rng(seed)
    lower, upper = np.clip(arm.lower, -3, 3), np.clip(arm.upper, -3, 3)
    J = arm.jacobian(rng.uniform(lower, upper, (count, arm.num_joints)))
    return J * np.array([0.3, 0.3, 0.3, 1.0, 1.0, 1.0])[:, None], rng.normal(size=(count, 6)) * 0.1


@pytest.mark.parametrize("damping, tolerance", [(0.1, 1e-11), (0.01, 1e-8), (0.0, 1e-7)])
@pytest.mark.parametrize("name", ["iiwa14", "puma560"])
def test_equals_the_iterations_where_they_have_converged(name, damping, tolerance):
    law = fd.FuzzyMapping(iterations=6, damping=damping, row_floor=0.05)
    J, dr = poses(name, 60, 1)
    together = law(J, dr)
    for jacobian, error, step in zip(J, dr, together):
        expected = by_iterations(jacobian, error, damping, 0.05)
        scale = np.linalg.norm(expected)
        assert np.linalg.norm(law.step(jacobian, error) - expected) <= tolerance * scale
        assert np.linalg.norm(step - expected) <= tolerance * scale


@pytest.mark.parametrize("damping", [0.0, 1e-6])
def test_a_stretched_arm_is_not_thrown(damping):
    # planar4 stretched along x: no step moves it along x, the equations are singular.
    arm, law = fd.load_arm("planar4"), fd.FuzzyMapping(iterations=2, damping=damping)
    for bend in (0.0, 1e-12, 1e-9, 1e-7):
        J = arm.jacobian([0.0, bend, 0.0, 0.0])[3:5]
        for dr in ([0.1, 0.0], [0.1, 0.05], [0.0, 0.0]):
            for step in (law.step(J, np.array(dr)), law(J, dr)):
                assert np.isfinite(step).all()
                # Iterations move what can be moved and leave the rest.
                if bend < 1e-10:
                    assert np.abs(step).max() < 1.0


def test_rows_that_no_joint_moves_are_left_out():
    # Out of plane a planar arm has rows of zeros.
    J = fd.load_arm("planar4").jacobian([0.3, 0.5, -0.4, 0.2])
    dr = np.array([0.1, 0.2, 0.05, 0.02, 0.01, 0.3])
    for damping in (0.0, 0.1):
        law = fd.FuzzyMapping(iterations=6, damping=damping)
        kept = law.step(J[[2, 3, 4]], dr[[2, 3, 4]])
        assert law.step(J, dr) == pytest.approx(kept, abs=1e-9)
        assert law(J, dr) == pytest.approx(kept, abs=1e-9)


def test_fewer_iterations_than_rows_stay_iterations():
    J, dr = (x[0] for x in poses("iiwa14", 1, 2))
    few, all_six = (fd.FuzzyMapping(iterations=k, row_floor=0.05).step(J, dr) for k in (5, 6))
    assert np.abs(few - all_six).max() > 1e-6


def test_iterations_after_the_minimum_stay_there():
    """More rows than joints: three iterations reach the minimum, the others see rounding errors only."""
    rng = np.random.default_rng(0)
    J, dr = rng.normal(size=(2000, 6, 3)), rng.normal(size=(2000, 6))
    steps = fd.FuzzyMapping(iterations=30)(J, dr)
    rows, columns = np.abs(J).sum(axis=2), np.abs(J).sum(axis=1)
    S = J / np.sqrt(rows[:, :, None] * columns[:, None, :])
    x = np.linalg.pinv(S) @ (dr / np.sqrt(rows))[..., None]
    np.testing.assert_allclose(steps, x[..., 0] / np.sqrt(columns), rtol=0.0, atol=1e-7)
