"""Past obstacles: ours beside Drake's differential IK, and Pink (`fikm-drake benchmark obstacles`)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.obstacle_pink import has_pink, run_pink
from fikm_drake.experiments.benchmarks.obstacle_runs import run_drake, run_ours
from fikm_drake.experiments.benchmarks.obstacle_scenes import (
    HOME,
    KINDS,
    TASKS,
    ObstacleScene,
    obstacle_scenes,
)
from fikm_drake.experiments.benchmarks.obstacle_settings import (
    DRAKE_GRID,
    PINK_GRID,
    DrakeSettings,
    PinkSettings,
    Settings,
    Sweep,
    sweep,
)
from fikm_drake.experiments.benchmarks.pose_checks import as_pose, is_near
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.kinematics.load_arm import load_arm

RATE, SECONDS = 100.0, 12.0
"""Rate, seconds of every run [Hz, s]."""
SWEPT = 2 * len(HOME) * len(KINDS) * len(TASKS)
"""Scenes of a sweep: two of each class [-]."""
RATES = (50.0, 200.0, 1000.0)
"""At which one scene of each class is run once more, for its clearance [Hz]."""
SEEDS, SWEEP_SEED = (0, 1), 10
"""Of the scenes, and of those in which the peers' settings are swept."""
TAIL = 20
"""Cycles at the end in which motion is measured (-)."""
OURS, SEARCH, DRAKE, PINK = "fuzzy IK", "fuzzy IK, restart search", "Drake", "Pink"
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
    drake: DrakeSettings | None = None,
    pink: PinkSettings | None = None,
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
        drake: Drake's settings; None: the defaults.
        pink: run Pink too, which must be installed, with these settings; None: not.
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
            settings=drake or DrakeSettings(),
        ),
    }
    if pink:
        methods[PINK] = partial(run_pink, rate=RATE, seconds=seconds, clearance=near, settings=pink)
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


def clearance_at(
    rate: float, *, arms: Sequence[str] = tuple(HOME), seed: int = 0, seconds: float = 3.0
) -> float:
    """Smallest clearance of ours in a scene of every class at another rate [Hz], [m]."""
    least = np.inf
    with quiet_drake():
        for scene in _of_each(arms, seed):
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


def microseconds_without(*, seed: int = 0, seconds: float = 3.0) -> float:
    """CPU time of a cycle of ours without a checker, median over a scene of every class [µs]."""
    runs = [
        run_ours(
            scene,
            None,
            rate=RATE,
            seconds=seconds,
            clearance=ClearanceConfig(),
            restart_search=False,
        )
        for scene in _of_each(tuple(HOME), seed)
    ]
    return 1e6 * float(np.median([np.median(times) for _, times in runs]))


def _of_each(arms: Sequence[str], seed: int, count: int = 1) -> Iterator[ObstacleScene]:
    for arm in arms:
        for kind in KINDS:
            for task in TASKS:
                yield from obstacle_scenes(arm, kind, task, count, seed)


def sweep_peers(progress: Callable[[float], None]) -> dict[str, Sweep]:
    """The best settings of Drake, and of Pink where it is installed, in two scenes of every class."""
    peers: list[tuple[str, Any, Any, Any]] = [(DRAKE, DrakeSettings(), DRAKE_GRID, run_drake)]
    if has_pink():
        peers.append((PINK, PinkSettings(), PINK_GRID, run_pink))
    found = {}
    with quiet_drake():
        scenes = [(s, s.checker()) for s in _of_each(tuple(HOME), SWEEP_SEED, count=2)]
        total = sum(len(values) for *_, grid, _ in peers for values in grid.values())
        done = 0
        for name, start, grid, run in peers:

            def reached(settings: Settings, run: Any = run) -> int:
                nonlocal done
                options = {"rate": RATE, "seconds": SECONDS, "clearance": ClearanceConfig()}
                runs = [
                    run(scene, checker, settings=settings, **options) for scene, checker in scenes
                ]
                done += 1
                progress(min(1.0, done / total))
                return sum(_reached(scene, q[-1]) for (scene, _), (q, _) in zip(scenes, runs))

            found[name] = sweep(start, grid, reached)
    return found


def table(scenes: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    lines, rows = [], []
    peers = sweep_peers(lambda done: progress(0.4 * done))
    for name, swept in peers.items():
        lines.append(f"{name}, swept in {SWEPT} scenes of seed {SWEEP_SEED}: reached")
        lines += [f"  {line}" for line in swept.lines]
        lines.append(f"  best, {swept.reached} of {SWEPT}: {swept.best}")
    for k, seed in enumerate(SEEDS):
        found = obstacles_benchmark(
            scenes=scenes,
            seed=seed,
            drake=peers[DRAKE].best,
            pink=peers[PINK].best if PINK in peers else None,
            progress=lambda done, k=k: progress(0.4 + 0.6 * (k + done) / len(SEEDS)),  # type: ignore[misc]
        )
        lines += [f"seed {seed}", *_lines(found)]
        rows += found
    for rate in RATES:
        least = clearance_at(rate)
        lines.append(f"{OURS} at {rate:g} Hz, a scene of each class: {1e3 * least:.2f} mm")
    lines.append(f"{OURS} without a checker: {microseconds_without():.0f} us a cycle")
    return BenchmarkTable(lines, rows)


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
        f"{1e3 * near.influence_distance:g} mm on"
    )
    yield "reached | smallest clearance [mm] | last motion of a joint [rad a cycle] | CPU a cycle [us]"
    for row in rows:
        yield (
            f"  {row.arm:7s} {row.kind:10s} {row.task:8s} {row.method:25s} {row.reached:2d} of "
            f"{row.scenes:2d} | {1e3 * row.clearance:7.2f} | {row.tail:8.1e} | {row.microseconds:4.0f}"
        )
    for method in dict.fromkeys(row.method for row in rows):
        own = [row for row in rows if row.method == method]
        yield (
            f"{method}: {sum(r.reached for r in own)} of {sum(r.scenes for r in own)} reached, clearance "
            f"{1e3 * min(r.clearance for r in own):.2f} mm, motion {max(r.tail for r in own):.1e} rad, "
            f"{np.median([r.microseconds for r in own]):.0f} us"
        )
    by_class = {(row.arm, row.kind, row.task, row.method): row.reached for row in rows}
    fewer = [
        f"{row.arm} {row.kind} {row.task}"
        for row in rows
        if row.method == SEARCH and row.reached < by_class[row.arm, row.kind, row.task, DRAKE]
    ]
    yield f"classes in which {SEARCH} reaches fewer than {DRAKE}: {', '.join(fewer) or 'none'}"
