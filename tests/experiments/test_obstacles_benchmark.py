"""What `fikm-drake benchmark obstacles` measures."""

import numpy as np
import pytest

from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.experiments.benchmarks.obstacle_pink import has_pink, run_pink
from fikm_drake.experiments.benchmarks.obstacle_runs import run_ours
from fikm_drake.experiments.benchmarks.obstacle_scenes import obstacle_scenes
from fikm_drake.experiments.benchmarks.obstacle_settings import (
    DRAKE_GRID,
    DrakeSettings,
    PinkSettings,
    sweep,
)
from fikm_drake.experiments.benchmarks.obstacles_benchmark import (
    DRAKE,
    OURS,
    SEARCH,
    obstacles_benchmark,
)
from fikm_drake.kinematics.load_arm import load_arm


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


@pytest.mark.parametrize(
    ("arm", "task", "place", "seed"),
    [
        ("ur5", "pose", 1, 5),
        ("panda", "position", 5, 5),
        ("iiwa14", "pose", 0, 11),
        ("panda", "pose", 2, 11),
    ],
)
def test_between_the_boards_of_a_shelf_a_way_with_bends_is_found(arm, task, place, seed):
    """Neither the straight way nor one with a posture in between leads there."""
    scene = obstacle_scenes(arm, "shelf", task, place + 1, seed)[place]
    checker, near = scene.checker(), ClearanceConfig()
    q, _ = run_ours(scene, checker, rate=100.0, seconds=8.0, clearance=near, restart_search=True)
    X = load_arm(arm).forward_kinematics(q[-1])
    np.testing.assert_allclose(X[:3, 3], scene.target[:3, 3], atol=1e-3)
    if task == "pose":
        np.testing.assert_allclose(X[:3, :3], scene.target[:3, :3], atol=1e-2)
    guard = Clearance(checker, period=0.01)
    assert min(guard.distance(x) for x in q) >= near.safe_distance - 1e-3


def test_scenes_are_seeded_and_their_start_is_clear():
    one, two = (obstacle_scenes("panda", "boxes", "pose", 1, seed=3)[0] for _ in range(2))
    np.testing.assert_array_equal(one.target, two.target)
    assert Clearance(one.checker(), period=0.01).distance(one.start) > 0.03
    other = obstacle_scenes("panda", "boxes", "pose", 1, seed=4)[0]
    assert np.abs(one.target - other.target).max() > 1e-3


def test_bad_counts():
    with pytest.raises(ValueError, match="scenes"):
        obstacles_benchmark(scenes=0)


def test_a_sweep_takes_the_best_of_each_field_with_the_others_at_their_best():
    asked = []

    def reached(settings):
        asked.append(settings)
        return int(10 - 9 * abs(settings.gain - 0.3) - abs(np.log10(settings.speed / 3.0)))

    found = sweep(DrakeSettings(), DRAKE_GRID, reached)
    assert found.best == DrakeSettings(gain=0.3, speed=3.0) and found.reached == 10
    assert len(asked) == len(set(asked)) == 1 + sum(len(v) - 1 for v in DRAKE_GRID.values())
    assert len(found.lines) == 4 and found.lines[0].startswith("gain 0.02: 7, 0.05: 7")


@pytest.mark.skipif(not has_pink(), reason="Pink is not installed")
def test_pinks_barrier_keeps_the_distances_of_the_same_shapes():
    scene = obstacle_scenes("iiwa14", "second arm", "position", 1, seed=0)[0]
    checker, near = scene.checker(), ClearanceConfig()
    q, times = run_pink(
        scene, checker, rate=100.0, seconds=1.0, clearance=near, settings=PinkSettings()
    )
    guard = Clearance(checker, period=0.01)
    assert min(guard.distance(x) for x in q) >= near.safe_distance - 1e-3
    assert np.abs(q[-1] - scene.start).max() > 0.05 and (times > 0.0).all()
