"""Feasible regions: exactness and time a point (`fikm-drake benchmark regions`)."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.interleaved import jacobian_time
from fikm_drake.experiments.reproduce.anfis.region import ARM
from fikm_drake.experiments.reproduce.anfis.scan import scan_intervals
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.self_motion import SelfMotionStatus
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer

SEED = 2021
CHUNK = 2000
"""Points that are scanned side by side."""


@dataclass(frozen=True)
class RegionCost:
    """One method on random feasible targets."""

    label: str
    """What, against what."""
    targets: int
    """How many."""
    same: bool
    """Whether each has the intervals, or the postures, that it should have."""
    error: float
    """The largest difference of a bound [rad], or residual on a curve [m and rad]."""
    seconds: float
    """Mean CPU time a target [s]."""
    limit: float = np.nan
    """CPU time of as many Jacobians as its curve has points, at once and nothing else [s]; NaN: no curve."""


def closed_form_against_scan(count: int) -> RegionCost:
    """Bounds of θ1 of the thesis's arm at `count` random feasible points, against a scan's."""
    arm, rng = load_arm(ARM), np.random.default_rng(SEED)
    q = rng.uniform(arm.lower, arm.upper, (count, 3))
    points = arm.forward_kinematics(q)[:, :2, 3]
    began = time.process_time()
    table = feasible_interval_table(arm, points)
    seconds = (time.process_time() - began) / count
    same, error = True, 0.0
    for start in range(0, count, CHUNK):
        part = slice(start, start + CHUNK)
        rows, lower, upper = scan_intervals(arm, points[part], q[part, 0])
        same &= np.array_equal(np.bincount(rows, minlength=len(points[part])), table.count[part])
        if same:
            found = ~np.isnan(table.lower[part])
            differences = [lower - table.lower[part][found], upper - table.upper[part][found]]
            error = max(error, float(np.abs(differences).max()))
    return RegionCost("closed form against scan", count, same, error, seconds)


def planar_against_closed_form(
    count: int, progress: Callable[[float], None] | None = None
) -> RegionCost:
    """Traced bounds of θ1 at `count` random feasible points, against the closed form's."""
    arm, rng = load_arm(ARM), np.random.default_rng(SEED + 1)
    tracer = SelfMotionTracer(arm, "xy")
    points = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (count, 3)))[:, :2, 3]
    table = feasible_interval_table(arm, points)
    same, error, seconds = True, 0.0, 0.0
    for i, point in enumerate(points):
        began = time.process_time()
        traced = tracer.trace(point).intervals(0)
        seconds += time.process_time() - began
        exact = table[i]
        same &= len(traced) == len(exact)
        for ours, theirs in zip(traced, exact):
            error = max(error, abs(ours.lower - theirs.lower), abs(ours.upper - theirs.upper))
        if progress:
            progress((i + 1) / count)
    return RegionCost("traced against closed form, planar 3R", count, same, error, seconds / count)


def seven_joints(
    name: str, count: int, progress: Callable[[float], None] | None = None
) -> RegionCost:
    """Residuals of the self-motions of a 7-joint arm at `count` random poses within its limits.

    Checked with Drake's plant, which the tracer does not use where there is a native kernel: the largest
    difference of an element of the pose.
    """
    arm, rng = load_arm(name), np.random.default_rng(SEED + 2)
    tracer, plant = SelfMotionTracer(arm, "pose"), MakeDhArmPlant(arm)
    postures = rng.uniform(arm.lower, arm.upper, (count, arm.num_joints))
    same, error, seconds, traced = True, 0.0, 0.0, 0
    for i, q in enumerate(postures):
        began = time.process_time()
        motion = tracer.trace(q)
        seconds += time.process_time() - began
        same &= motion.status == SelfMotionStatus.TRACED
        points = np.concatenate([component.q for component in motion.components])
        traced += len(points)
        same &= bool(((points >= arm.lower - 1e-12) & (points <= arm.upper + 1e-12)).all())
        off = _poses(plant, points) - _poses(plant, q[None])
        error = max(error, float(np.abs(off).max()))
        if progress:
            progress((i + 1) / count)
    limit = traced / count * jacobian_time(arm, postures)
    return RegionCost(f"residual on the curves, {name}", count, same, error, seconds / count, limit)


def _poses(plant: MultibodyPlant, q: Array) -> Array:
    """Poses (N,4,4) of the tool at `q` (N,n), by Drake."""
    context, tool = plant.CreateDefaultContext(), plant.GetFrameByName("tool")
    found = []
    for row in q:
        plant.SetPositions(context, row)
        found.append(tool.CalcPoseInWorld(context).GetAsMatrix4())
    return np.array(found)


def table(points: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """Text of all three: 4 times as many points for the closed form, a 50th of them for 7 joints."""
    poses = max(1, points // 50)
    costs = [
        closed_form_against_scan(4 * points),
        planar_against_closed_form(points, lambda share: progress(0.5 * share)),
        seven_joints("iiwa14", poses, lambda share: progress(0.5 + 0.3 * share)),
        seven_joints("panda", poses, lambda share: progress(0.8 + 0.2 * share)),
    ]
    lines = [
        f"{'':40s} {'targets':>8s} {'all':>4s} {'largest error':>14s} {'CPU a target':>13s} {'limit':>8s}"
    ]
    lines += [
        f"{cost.label:40s} {cost.targets:8d} {'yes' if cost.same else 'NO':>4s} {cost.error:14.2e} "
        f"{1e3 * cost.seconds:10.4g} ms"
        + (f" {1e3 * cost.limit:8.2f}" if np.isfinite(cost.limit) else "")
        for cost in costs
    ]
    return BenchmarkTable(lines, costs)
