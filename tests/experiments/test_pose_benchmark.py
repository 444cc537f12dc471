"""What `fikm-drake benchmark poses` measures."""

import pytest

from fikm_drake.experiments.pose_benchmark import pose_benchmark


def test_three_iterations_reach_poses_and_are_calm_out_of_reach():
    results = {result.name: result for result in pose_benchmark(poses=4, seed=1)}
    calm = results["fuzzy, 3 iterations"]
    assert calm.reached >= 3 and calm.unrest < 1e-3
    assert results["fuzzy, paper's law"].unrest > 0.1
    assert results["rate control, 3 sweeps"].reached >= 3
    assert results["rate control, 3 sweeps"].unrest < 1e-9


def test_bad_number_of_poses():
    with pytest.raises(ValueError, match="poses must be positive, got 0"):
        pose_benchmark(poses=0)
