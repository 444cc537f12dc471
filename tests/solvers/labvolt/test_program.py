"""The program: both solvers, its traps, and that one target leaves nothing behind for the next."""

import numpy as np
import pytest

from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.plane_targets import random_targets
from fikm_drake.solvers.labvolt.program import LabVoltProgram

GEOMETRY = labvolt()
LOWER, UPPER = np.array(GEOMETRY.lower), np.array(GEOMETRY.upper)


def random_postures(count, seed):
    return np.random.default_rng(seed).uniform(LOWER, UPPER, (count, 3))


@pytest.mark.parametrize("solver", ["slsqp", "snopt"])
def test_middle_of_the_limits_is_a_good_start(solver):
    program, points = LabVoltProgram(GEOMETRY, solver=solver), random_targets(150, seed=0)
    q = np.array([program.reach(point, GEOMETRY.middle) for point in points]).T
    assert (GEOMETRY.error(q, points.T) < 1e-9).mean() > 0.95
    assert GEOMETRY.contains(q, 0.0).all()


def test_local_minima_are_postures_that_no_step_improves():
    """What fails from random starts: at a limit, and finite differences show no way down."""
    program, points = LabVoltProgram(GEOMETRY), random_targets(150, seed=1)
    q = np.array([program.reach(p, s) for p, s in zip(points, random_postures(150, 2))])
    failed = GEOMETRY.error(q.T, points.T) > 1e-6
    assert 0.02 < failed.mean() < 0.25
    for point, stuck in zip(points[failed], q[failed]):
        steps = np.clip(stuck + 1e-4 * np.concatenate([np.eye(3), -np.eye(3)]), LOWER, UPPER)
        assert (GEOMETRY.error(steps.T, point[:, None]) > GEOMETRY.error(stuck, point) - 1e-7).all()


def test_stretched_arm_reaches_straight_inward():
    """A saddle: no step is downhill. The elbow is bent first."""
    program = LabVoltProgram(GEOMETRY)
    for angle in np.deg2rad([10.0, 30.0, 50.0, 80.0]):
        point = 0.5 * np.array([np.cos(angle), np.sin(angle)])
        assert GEOMETRY.error(program.reach(point, np.array([angle, 0.0, 0.0])), point) < 1e-9


def test_targets_do_not_influence_each_other():
    program, points = LabVoltProgram(GEOMETRY), random_targets(20, seed=3)
    first = [program.reach(point, GEOMETRY.middle) for point in points]
    again = [program.reach(point, GEOMETRY.middle) for point in points[::-1]][::-1]
    alone = [LabVoltProgram(GEOMETRY).reach(point, GEOMETRY.middle) for point in points]
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(first, alone)


def test_the_start_is_left_alone_and_may_be_outside():
    program = LabVoltProgram(GEOMETRY)
    for start in ([0.1, 0.0, 0.0], [9.0, -9.0, 9.0]):
        given = np.array(start)
        q = program.reach(np.array([0.4, 0.2]), given)
        assert given.tolist() == start
        assert GEOMETRY.contains(q, 0.0)


def test_absolute_angles_reach_the_same_targets_less_often():
    """Equation 5 as printed: the same minimum, more local ones (reference: .86-.91 against .9998)."""
    points = random_targets(150, seed=4)
    share = []
    for absolute in (False, True):
        program = LabVoltProgram(GEOMETRY, absolute=absolute)
        q = np.array([program.reach(point, GEOMETRY.middle) for point in points]).T
        assert GEOMETRY.contains(q, 0.0).all()
        share.append((GEOMETRY.error(q, points.T) < 1e-9).mean())
    assert share[0] == 1.0 and 0.7 < share[1] < 0.97


@pytest.mark.parametrize(("solver", "within"), [("slsqp", 1e-9), ("snopt", 1e-7)])
def test_settle_comes_nearer_to_the_wish_and_stays_on_the_target(solver, within):
    program, points = LabVoltProgram(GEOMETRY, solver=solver), random_targets(40, seed=5)
    nearer = 0
    for point, wish in zip(points, random_postures(40, 6)):
        q = program.reach(point, GEOMETRY.middle)
        settled = program.settle(point, q, wish)
        assert GEOMETRY.error(settled, point) < within and GEOMETRY.contains(settled, 0.0)
        nearer += np.sum((settled - wish) ** 2) < np.sum((q - wish) ** 2) - 1e-9
    assert nearer > 30


def test_unknown_solver():
    with pytest.raises(
        ValueError, match=r"solver must be one of \('slsqp', 'snopt'\), got 'ipopt'"
    ):
        LabVoltProgram(GEOMETRY, solver="ipopt")
