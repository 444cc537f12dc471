"""What the calm costs where a target can be followed, and what it is for (`fikm-drake benchmark calm`)."""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.calm_out_of_reach import calm_out_of_reach, rest_lines
from fikm_drake.experiments.benchmarks.calm_runs import TASKS, CalmRun, calm_run, config_of
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task import Task
from fikm_drake.kinematics.task_kinematics import PlantTask
from fikm_drake.kinematics.tasks import PointingTask, PositionTask, make_task

CALMING = 0.8
"""The default's."""
HARM = 1.1
"""How much larger the worst error may be with the calm than without."""
LEAST = 1e-5
"""Errors below this are of no account [m]."""
OUT_OF_REACH = 5e-3
"""A `line` leaves the reach if without the calm its last error is above this [m]."""
CHUNK = 10
"""Runs that a process takes at a time."""
SHOWN = 20
"""Violations that are printed."""


@dataclass(frozen=True)
class CalmResult:
    """One run with the calm and without."""

    index: int
    name: str
    """What was run."""
    kind: str
    calm: float
    """Worst error with the calm [m]."""
    off: float
    """Worst error without [m]."""
    calm_mean: float
    off_mean: float
    took_part: float
    """Fraction of the cycles in which the calm saw a joint oscillate, or had calmed one [-]."""
    reachable: bool
    """False for a straight line out of the arm's reach: it does not count."""

    @property
    def ratio(self) -> float:
        """Worst error with the calm over that without [-]."""
        return max(self.calm, LEAST) / max(self.off, LEAST)


def calm_benchmark(
    indices: Iterable[int],
    *,
    seed: int = 0,
    arms: Sequence[str] = tuple(TASKS),
    processes: int = 1,
    progress: Callable[[float], None] | None = None,
) -> list[CalmResult]:
    """Runs by number, each with the calm and without, and the worst error of both.

    A run depends on its number and the seed only, so they can be shared out at will.

    Args:
        indices: numbers of the runs, such as `range(0, 100)`.
        seed: of all runs.
        arms: that take turns, of `TASKS`.
        processes: that share them out; 1: in this one.
        progress: called now and then with the fraction done.

    Raises:
        ValueError: an arm is none of `TASKS`, or processes is not positive.
    """
    for name in arms:
        if name not in TASKS:
            raise ValueError(f"arms must be of {tuple(TASKS)}, got {name!r}")
    if processes < 1:
        raise ValueError(f"processes must be positive, got {processes}")
    indices = list(indices)
    measure = partial(measure_run, seed=seed, arms=tuple(arms))
    results: list[CalmResult] = []

    def collect(found: Iterable[CalmResult]) -> None:
        for result in found:
            results.append(result)
            if progress:
                progress(len(results) / len(indices))

    if processes == 1:
        collect(map(measure, indices))
    else:
        with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
            collect(pool.map(measure, indices, chunksize=CHUNK))
    return results


def measure_run(index: int, *, seed: int = 0, arms: Sequence[str] = tuple(TASKS)) -> CalmResult:
    """One run, with the calm and without."""
    run = calm_run(index, seed=seed, arms=arms)
    arm = PlantArm(MakeDhArmPlant(load_arm(run.arm)), "tool")
    (on, joint), (off, _) = (follow(run, arm, calming=c) for c in (CALMING, 1.0))
    on, off = on[run.counted], off[run.counted]
    return CalmResult(
        index=index,
        name=run.name,
        kind=run.kind,
        calm=float(on.max()),
        off=float(off.max()),
        calm_mean=float(on.mean()),
        off_mean=float(off.mean()),
        took_part=float((joint >= 0).mean()),
        reachable=run.kind != "line" or float(off[-1]) <= OUT_OF_REACH,
    )


def follow(run: CalmRun, arm: PlantArm, *, calming: float) -> tuple[Array, Array]:
    """Length of the error, noise apart, at each cycle (N,) [m], and the joint that oscillates (N,)."""
    config = config_of(run, calming=calming)
    task = make_task(arm, run.task, config.characteristic_length)
    cycle = ControlCycle(task, config)
    state = cycle.start(run.start)
    errors, joints = [], []
    goals, targets = (_targets(task, run.task, poses) for poses in (run.poses, run.shaken))
    for goal, seen, noise in zip(goals, targets, run.sensor):
        errors.append(float(np.linalg.norm(task.error(goal, state.command))))
        joints.append(cycle.supervision.oscillating_joint(state.supervision))
        q = state.command + noise
        cycle.advance(state, seen, q, cycle.tick(state, seen, q))
    return np.array(errors), np.array(joints)


def _targets(task: PlantTask, name: str, poses: Array) -> list:
    """What the task takes for these poses of the tool (N,4,4)."""
    if isinstance(task, PositionTask):
        return list(poses[:, Task(name).coordinates, 3])
    if isinstance(task, PointingTask):
        return list(np.concatenate([poses[:, :3, 3], poses[:, :3, 2]], axis=1))
    return [RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3]) for T in poses]


def table(runs: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    processes = min(len(os.sched_getaffinity(0)), -(-runs // CHUNK))
    results = calm_benchmark(range(runs), processes=processes, progress=progress)
    lines = [
        f"{runs} runs, targets that the arm can follow: worst error with the calm over that without,",
        f"largest and median; runs above {HARM:g}; runs in which the calm took part; median worst error",
    ]
    counted = [r for r in results if r.reachable]
    kinds = sorted({r.kind for r in counted})
    for kind in (*kinds, "all"):
        of_kind = [r for r in counted if kind in (r.kind, "all")]
        ratios = np.array([r.ratio for r in of_kind])
        lines.append(
            f"  {kind:12s} {len(of_kind):5d} runs  {ratios.max():6.3f} {np.median(ratios):6.3f}"
            f"  above: {int((ratios > HARM).sum()):3d}"
            f"  calmed: {sum(r.took_part > 0.0 for r in of_kind):4d}"
            f"  {1e3 * np.median([r.calm for r in of_kind]):8.3f} mm"
        )
    lines.append(f"  left out, straight lines out of reach: {len(results) - len(counted)}")
    bad = sorted((r for r in counted if r.ratio > HARM), key=lambda r: -r.ratio)
    lines += [
        f"  {r.ratio:6.2f}  {1e3 * r.calm:9.3f} mm, without {1e3 * r.off:9.3f}  {r.name}"
        for r in bad[:SHOWN]
    ]
    rests = calm_out_of_reach()
    return BenchmarkTable([*lines, *rest_lines(rests)], [*results, *rests])
