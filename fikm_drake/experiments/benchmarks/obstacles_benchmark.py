"""Past obstacles: ours beside Drake's differential IK (`fikm-drake benchmark obstacles`)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.obstacle_runs import DrakeSettings, run_drake, run_ours
from fikm_drake.experiments.benchmarks.obstacle_scenes import (
    HOME,
    KINDS,
    TASKS,
    ObstacleScene,
    obstacle_scenes,
)
from fikm_drake.experiments.benchmarks.pose_checks import as_pose, is_near
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.kinematics.load_arm import load_arm

RATE, SECONDS = 100.0, 12.0
"""Rate, seconds of every run [Hz, s]."""
RATES = (50.0, 1000.0)
"""At which one scene of each class of one arm is run once more, for its clearance [Hz]."""
TAIL = 20
"""Cycles at the end in which motion is measured (-)."""
OURS, SEARCH, DRAKE = "fuzzy IK", "fuzzy IK, restart search", "Drake"
Run = Callable[[ObstacleScene, CollisionChecker], tuple[Array, Array]]


@dataclass(frozen=True)
class ObstacleRow:
    """What one method does in the scenes of one class."""

    arm: str
    kind: str
    task: str
    method: str
    scenes: int
    reached: int
    """Targets within 1 mm, and 0.01 rad for poses, at the end."""
    clearance: float
    """Smallest in any cycle of any scene [m]."""
    tail: float
    """Largest motion of a joint in one of the last cycles [rad]."""
    microseconds: float
    """CPU time of a cycle, median over cycles and scenes [µs]."""


def obstacles_benchmark(
    *,
    scenes: int = 3,
    arms: Sequence[str] = tuple(HOME),
    kinds: Sequence[str] = KINDS,
    tasks: Sequence[str] = TASKS,
    seconds: float = SECONDS,
    seed: int = 0,
    settings: DrakeSettings | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[ObstacleRow]:
    """Run every method in every scene, with one checker, one safe distance, the same limits of speed.

    Args:
        scenes: of each class: 24 classes with the defaults.
        arms: of `HOME`.
        kinds: of `KINDS`.
        tasks: of `TASKS`.
        seconds: of a run [s].
        seed: of the scenes.
        settings: Drake's; None: the defaults of `DrakeSettings`.
        progress: called after each class with the fraction done.

    Raises:
        ValueError: a count is not positive.
    """
    check_counts(scenes=scenes)
    near = ClearanceConfig()
    methods: dict[str, Run] = {
        OURS: partial(run_ours, rate=RATE, seconds=seconds, clearance=near, restart_search=False),
        SEARCH: partial(run_ours, rate=RATE, seconds=seconds, clearance=near, restart_search=True),
        DRAKE: partial(
            run_drake,
            rate=RATE,
            seconds=seconds,
            clearance=near,
            settings=settings or DrakeSettings(),
        ),
    }
    rows = []
    classes = [(arm, kind, task) for arm in arms for kind in kinds for task in tasks]
    with quiet_drake():
        for k, (arm, kind, task) in enumerate(classes, start=1):
            made = obstacle_scenes(arm, kind, task, scenes, seed)
            checkers = [scene.checker() for scene in made]
            for method, run in methods.items():
                runs = [run(scene, checker) for scene, checker in zip(made, checkers)]
                rows.append(_row(made, checkers, method, runs))
            if progress:
                progress(k / len(classes))
    return rows


def clearance_at(rate: float, *, arm: str = "iiwa14", seed: int = 0, seconds: float = 3.0) -> float:
    """Smallest clearance of ours in a scene of every class of an arm, at another rate [Hz], [m]."""
    least = np.inf
    with quiet_drake():
        for kind, task in [(k, t) for k in KINDS for t in TASKS]:
            for scene in obstacle_scenes(arm, kind, task, 1, seed):
                checker = scene.checker()
                q, _ = run_ours(
                    scene,
                    checker,
                    rate=rate,
                    seconds=seconds,
                    clearance=ClearanceConfig(),
                    restart_search=True,
                )
                least = min(least, _clearance(checker, q))
    return float(least)


def table(scenes: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    rows = obstacles_benchmark(scenes=scenes, progress=progress)
    rates = [
        f"{OURS} at {rate:g} Hz, iiwa14, a scene of each class: {1e3 * clearance_at(rate):.2f} mm"
        for rate in RATES
    ]
    return BenchmarkTable([*_lines(rows), *rates], rows)


def _row(
    scenes: list[ObstacleScene],
    checkers: list[CollisionChecker],
    method: str,
    runs: list[tuple[Array, Array]],
) -> ObstacleRow:
    first = scenes[0]
    return ObstacleRow(
        arm=first.arm,
        kind=first.kind,
        task=first.task,
        method=method,
        scenes=len(scenes),
        reached=sum(_reached(scene, q[-1]) for scene, (q, _) in zip(scenes, runs)),
        clearance=min(_clearance(checker, q) for checker, (q, _) in zip(checkers, runs)),
        tail=max(float(np.abs(np.diff(q[-TAIL:], axis=0)).max()) for q, _ in runs),
        microseconds=1e6 * float(np.median([np.median(times) for _, times in runs])),
    )


def _reached(scene: ObstacleScene, q: Array) -> bool:
    X, Y = as_pose(load_arm(scene.arm).forward_kinematics(q)), as_pose(scene.target)
    if scene.task == "position":
        return bool(np.linalg.norm(X.translation() - Y.translation()) < 1e-3)
    return is_near(X, Y)


def _clearance(checker: CollisionChecker, q: Array) -> float:
    guard = Clearance(checker, period=1.0 / RATE)
    moves = np.r_[True, np.abs(np.diff(q, axis=0)).max(axis=1) > 1e-9]
    return min(guard.distance(x) for x in q[moves])


def _lines(rows: list[ObstacleRow]) -> Iterator[str]:
    near = ClearanceConfig()
    yield (
        f"{RATE:g} Hz, {SECONDS:g} s, one checker, {1e3 * near.safe_distance:g} mm kept from "
        f"{1e3 * near.influence_distance:g} mm on; Drake: {DrakeSettings()}"
    )
    yield "reached | smallest clearance [mm] | last motion of a joint [rad a cycle] | CPU a cycle [us]"
    for row in rows:
        yield (
            f"  {row.arm:7s} {row.kind:10s} {row.task:8s} {row.method:25s} {row.reached:2d} of "
            f"{row.scenes:2d} | {1e3 * row.clearance:7.2f} | {row.tail:8.1e} | {row.microseconds:4.0f}"
        )
    for method in (OURS, SEARCH, DRAKE):
        own = [row for row in rows if row.method == method]
        yield (
            f"{method}: {sum(r.reached for r in own)} of {sum(r.scenes for r in own)} reached, clearance "
            f"{1e3 * min(r.clearance for r in own):.2f} mm, motion {max(r.tail for r in own):.1e} rad, "
            f"{np.median([r.microseconds for r in own]):.0f} us"
        )
