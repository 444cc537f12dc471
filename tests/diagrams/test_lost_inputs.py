"""NaN and infinity at the controller's inputs in the middle of a run."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status

Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])
TARGET = np.array([0.5, -0.45, 0.3])


def lengths(vectors):
    return np.linalg.norm(vectors, axis=-1)


def stop_and_go(desired, start, stop, bad):
    desired = desired.copy()
    desired[start:stop, 1] = bad
    return desired


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("when", [(0, 5), (3, 4), (8, 40), (100, 130)])
def test_a_lost_target_holds_the_command(plant, run, fused, bad, when):
    start, stop = when
    desired = np.tile(TARGET, (400, 1))
    undisturbed = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, desired)
    series = run(plant, fd.FuzzyIkConfig(fused=fused), Q0, stop_and_go(desired, start, stop, bad))
    assert all(np.isfinite(values).all() for values in series.values())
    assert (series["status"][start:stop] == Status.INVALID_INPUT).all()
    assert (np.delete(series["status"], np.s_[start:stop]) != Status.INVALID_INPUT).all()
    held = series["commanded_position"][start : stop + 1]
    np.testing.assert_array_equal(held, np.tile(held[0], (len(held), 1)))
    assert not series["commanded_velocity"][start + 1 : stop + 1].any()
    assert not series["task_error"][start:stop].any()
    assert not series["joint_step"][start:stop].any()
    # No jump: nothing larger than the largest step of the run that nothing disturbed.
    largest = np.abs(undisturbed["joint_step"]).max()
    assert np.abs(series["joint_step"][stop:]).max() <= largest * 1.001
    if 0 < start and stop - start > 1:  # and the first step is no larger than the one before
        before, after = (lengths(series["joint_step"][k]) for k in (start - 1, stop))
        assert after <= before * 1.001
    assert lengths(series["task_error"])[-1] < 1e-6


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("joint", [0, 6])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_lost_measurement_holds_the_command(plant, run, fused, bad, joint):
    start, stop = 6, 30

    def measure(k, commanded):
        if start <= k < stop:
            commanded[joint] = bad
        return commanded

    config = fd.FuzzyIkConfig(fused=fused, measured_position=True)
    series = run(plant, config, Q0, np.tile(TARGET, (400, 1)), measure)
    assert all(np.isfinite(values).all() for values in series.values())
    assert (series["status"][start:stop] == Status.INVALID_INPUT).all()
    held = series["commanded_position"][start : stop + 1]
    np.testing.assert_array_equal(held, np.tile(held[0], (len(held), 1)))
    assert lengths(series["joint_step"][stop]) <= lengths(series["joint_step"][start - 1])
    assert lengths(series["task_error"])[-1] < 1e-6


def test_a_measurement_of_an_inner_frame_counts(plant, run, fused):
    """The controller of link4 has the four joints before it; one that is lost holds them all."""

    def measure(k, commanded):
        if 5 <= k < 9:
            commanded[3] = np.nan
        return commanded

    config = fd.FuzzyIkConfig(fused=fused, measured_position=True, frame="link4")
    series = run(plant, config, Q0[:4], np.tile([0.2, -0.2, 0.5], (20, 1)), measure)
    assert (series["status"][5:9] == Status.INVALID_INPUT).all()
    held = series["commanded_position"][5:10]
    np.testing.assert_array_equal(held, np.tile(held[0], (5, 1)))
    assert np.abs(np.diff(series["commanded_position"][9:], axis=0)).max() > 0
