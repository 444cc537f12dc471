"""What `fikm-drake benchmark poses` measures."""

import pytest

from fikm_drake.experiments.benchmarks.pose_benchmark import pose_benchmark


def test_ours_reach_poses_and_rest_out_of_reach_and_drakes_does_not():
    results = {result.name: result for result in pose_benchmark(poses=3, seed=1)}
    for name, result in results.items():
        assert 0 <= result.reached <= 3 and result.microseconds > 0
        if "fuzzy" in name:
            assert result.unrest < 1e-3
    best = results["fuzzy, 6 iterations, restart_search"]
    assert best.reached == 3 and best.reversals == 0
    chatter = results["Drake DifferentialInverseKinematicsController"]
    assert chatter.unrest > 0.1 and chatter.reversals > 10


def test_bad_number_of_poses():
    with pytest.raises(ValueError, match="poses must be positive, got 0"):
        pose_benchmark(poses=0)
