"""The hand at a given angle, exact where it can be, else at the nearest angle."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.solvers.labvolt import LabVoltStatus, random_targets, solve
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.methods import theta_3_search

GEOMETRY = labvolt()


@pytest.fixture(scope="module")
def asked():
    targets = random_targets(400, seed=31)
    approach = np.random.default_rng(32).uniform(-np.pi, np.pi, len(targets))
    return targets, approach, solve(targets, approach=approach)


def test_every_target_is_reached_and_the_error_is_the_angles(asked):
    targets, approach, found = asked
    assert found.success.all() and found.error.max() < 1e-12
    np.testing.assert_array_equal(found.nearest, targets)
    off = found.angles[:, 2] - approach - found.approach_error
    np.testing.assert_allclose(np.exp(1j * off), 1.0, rtol=0, atol=1e-9)
    exact = found.approach_error == 0.0
    assert (found.status[exact] == LabVoltStatus.SOLVED).all() and 0.1 < exact.mean() < 0.9
    assert (found.status[~exact] == LabVoltStatus.TURNED).all()
    assert GEOMETRY.contains(fd.labvolt.to_relative(found.angles).T, 1e-12).all()


def test_no_angle_of_a_grid_is_nearer(asked):
    """By algorithm 1's own closed form, every quarter of a degree."""
    targets, approach, found = asked
    grid = np.deg2rad(np.arange(-180.0, 180.0, 0.25))
    some = slice(0, 20)
    for point, wanted, error in zip(targets[some], approach[some], found.approach_error[some]):
        points = np.repeat(point[:, None], len(grid), axis=1)
        _, tries = theta_3_search(GEOMETRY, points, grid)
        away = np.abs(np.angle(np.exp(1j * (grid[tries == 1] - wanted))))
        if away.size:  # else the arc is thinner than the grid
            assert abs(error) <= away.min() + 1e-9
            assert abs(error) > away.min() - np.deg2rad(0.26) or away.size < 3


def test_posture_chooses_the_elbow():
    points = random_targets(300, seed=33)
    first = solve(points, approach=-1.0)
    mirrored = fd.labvolt.to_relative(first.angles)
    mirrored[:, 1] *= -1.0
    other = solve(points, approach=-1.0, posture=fd.labvolt.to_absolute(mirrored))
    np.testing.assert_allclose(other.approach_error, first.approach_error, rtol=0, atol=1e-12)
    bends = [fd.labvolt.to_relative(s.angles)[:, 1] for s in (first, other)]
    both = np.abs(bends[0] - bends[1]) > 1e-3
    assert both.any()  # where both elbows are inside the limits
    assert other.error.max() < 1e-12


def test_out_of_reach_and_invalid_are_told_as_ever():
    found = solve([[0.9, 0.0], [np.nan, 0.0], [0.4, 0.1]], approach=[0.0, 0.0, -0.5])
    plain = solve([[0.9, 0.0], [np.nan, 0.0], [0.4, 0.1]])
    assert found.status[:2].tolist() == plain.status[:2].tolist()
    np.testing.assert_array_equal(found.distance, plain.distance)
    assert np.isnan(found.approach_error[:2]).all() and np.isfinite(found.approach_error[2])
    assert plain.approach_error[2] == 0.0
