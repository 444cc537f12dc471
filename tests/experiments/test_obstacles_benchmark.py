"""What `fikm-drake benchmark obstacles` measures."""

import numpy as np
import pytest

from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.experiments.benchmarks.obstacle_scenes import obstacle_scenes
from fikm_drake.experiments.benchmarks.obstacles_benchmark import (
    DRAKE,
    OURS,
    SEARCH,
    obstacles_benchmark,
)


def test_ours_keeps_clear_and_gets_at_least_as_far_as_drakes():
    rows = obstacles_benchmark(
        scenes=1, arms=["iiwa14"], kinds=["spheres"], tasks=["position"], seconds=4.0
    )
    by_method = {row.method: row for row in rows}
    assert set(by_method) == {OURS, SEARCH, DRAKE}
    for method in (OURS, SEARCH):
        row = by_method[method]
        assert row.clearance >= ClearanceConfig().safe_distance - 1e-3
        assert row.reached >= by_method[DRAKE].reached and row.microseconds > 0.0
        assert row.tail <= 1e-5


def test_scenes_are_seeded_and_their_start_is_clear():
    one, two = (obstacle_scenes("panda", "boxes", "pose", 1, seed=3)[0] for _ in range(2))
    np.testing.assert_array_equal(one.target, two.target)
    assert Clearance(one.checker(), period=0.01).distance(one.start) > 0.03
    other = obstacle_scenes("panda", "boxes", "pose", 1, seed=4)[0]
    assert np.abs(one.target - other.target).max() > 1e-3


def test_bad_counts():
    with pytest.raises(ValueError, match="scenes"):
        obstacles_benchmark(scenes=0)
