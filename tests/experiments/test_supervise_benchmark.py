"""What `fikm-drake benchmark supervise` measures, and the quiet around Drake's solver."""

import os

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.experiments.benchmarks.supervise_benchmark import (
    HOME,
    REACH,
    far_pose,
    supervise_benchmark,
)


def test_supervision_ends_the_chatter_and_keeps_the_tracking():
    """At a pose out of reach Drake's controller shakes by 0.606 rad/s, 99 a second."""
    before, after = supervise_benchmark(arms=["iiwa14"], poses=1, seed=3)
    assert before.unrest == pytest.approx(0.606, abs=1e-3) and before.reversals == 99
    assert after.unrest < before.unrest / 50.0 and after.reversals == 0
    assert after.e_max == pytest.approx(before.e_max, rel=1e-6)
    assert after.e_mean == pytest.approx(before.e_mean, rel=1e-6)
    assert after.reached >= before.reached


@pytest.mark.parametrize("name", HOME)
def test_the_far_pose_is_out_of_reach_of_every_posture(name):
    arm = fd.load_arm(name)
    height, reach = REACH[name]
    shoulder = np.array([0.0, 0.0, height])
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, (20000, 7))
    assert np.linalg.norm(arm.forward_kinematics(q)[:, :3, 3] - shoulder, axis=1).max() <= reach
    X = far_pose(arm, arm.forward_kinematics(HOME[name]))
    assert np.linalg.norm(X.translation() - shoulder) == pytest.approx(reach + 0.4)


def test_bad_arguments_are_named():
    with pytest.raises(ValueError, match="poses must be positive, got 0"):
        supervise_benchmark(poses=0)
    with pytest.raises(ValueError, match="arms must be of .*iiwa14.*got 'arm7'"):
        supervise_benchmark(arms=["arm7"])


def test_quiet_drake_silences_the_process_and_gives_the_terminal_back(capfd):
    with pytest.raises(RuntimeError), quiet_drake():
        os.write(1, b"lost\n")
        raise RuntimeError
    os.write(1, b"seen\n")
    assert capfd.readouterr().out == "seen\n"
