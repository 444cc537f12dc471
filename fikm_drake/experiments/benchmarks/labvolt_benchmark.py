"""Costs and success for the LabVolt 5250, ours beside the ordinary (`fikm-drake benchmark labvolt`)."""

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, hypot
from statistics import median

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.reproduce.labvolt.peers import (
    Solver,
    drake_inverse_kinematics,
    python_callback,
)
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.labvolt.fuzzy_starts import initial_guess
from fikm_drake.solvers.labvolt.geometry import MODEL, labvolt
from fikm_drake.solvers.labvolt.plane_targets import random_targets
from fikm_drake.solvers.labvolt.program import LabVoltProgram
from fikm_drake.solvers.labvolt.solve import solve
from fikm_drake.systems.labvolt_ik import LabVoltIk

REACHED = 1e-6
"""Counts as solved, for the peers' sake [m]; ours is within 1e-9."""
BATCH, SINGLE = 20_000, 200
"""Targets of a round: of the closed form, and of the solvers that take one at a time."""
STEPS = 1000
"""Cycles of the path."""
OURS = "reused symbolic SLSQP"
CALLBACK, DRAKE = "rebuilt, Python callback, SLSQP", "Drake's InverseKinematics, SNOPT"
BATCHED = "closed form, batch"


@dataclass(frozen=True)
class Cost:
    """One solver from one kind of start."""

    name: str
    """The solver."""
    start: str
    """`random`, `zero`, `middle` or `fuzzy`."""
    success: float
    """Targets reached [%]."""
    microseconds: float
    """Median over the rounds of the CPU time a target [µs]."""
    ratio: float
    """Median over the rounds of the time over that of ours from the same start in the round [-]."""


@dataclass(frozen=True)
class PathCost:
    """`LabVoltIk` on a smooth path."""

    start: str
    """`last solution` or `fuzzy`."""
    jumps: int
    """Steps in which a joint moves by more than 5°."""
    largest: float
    """Largest motion of a joint in a step [deg]."""
    microseconds: float
    """Median over the rounds of the CPU time a cycle [µs]."""


def solver_costs(
    *, rounds: int = 5, seed: int = 0, progress: Callable[[float], None] | None = None
) -> list[Cost]:
    """Solve reachable targets, solver by solver, from each kind of start.

    Solvers take turns on the same targets, which lie all round the base.

    Args:
        rounds: how often, with new targets.
        seed: of targets and random starts.
        progress: called after each round with the fraction done.

    Raises:
        ValueError: rounds is not positive.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be positive, got {rounds}")
    arm, rng = load_arm(MODEL), np.random.default_rng(seed)
    solvers = {OURS: _ours(), CALLBACK: python_callback(), DRAKE: drake_inverse_kinematics()}
    done: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for k in range(rounds):
        points = random_targets(SINGLE, seed=seed + 1000 * (k + 1))
        targets = _in_space(points, rng)
        batch = random_targets(BATCH, seed=seed + k)
        for start, starts in _starts(arm, targets, rng).items():
            for name, solver in solvers.items():
                done.setdefault((name, start), []).append(_timed(arm, solver, targets, starts))
        gc.collect()
        begin = time.process_time()
        solution = solve(batch)
        seconds = (time.process_time() - begin) / BATCH
        done.setdefault((BATCHED, "-"), []).append((seconds, float(solution.success.mean())))
        if progress:
            progress((k + 1) / rounds)
    return [
        Cost(
            name,
            start,
            100.0 * float(np.mean([success for _, success in runs])),
            1e6 * median(seconds for seconds, _ in runs),
            median(
                a / b
                for (a, _), (b, _) in zip(runs, done[OURS, "middle" if start == "-" else start])
            ),
        )
        for (name, start), runs in done.items()
    ]


def path_costs(*, rounds: int = 5) -> list[PathCost]:
    """Follow a smooth path with the block, from the last solution and from the fuzzy rules each cycle.

    Raises:
        ValueError: rounds is not positive.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be positive, got {rounds}")
    targets = path()
    blocks = {
        "last solution": LabVoltIk(period=0.01),
        "fuzzy": LabVoltIk(period=0.01, warm_start=False),
    }
    runs: dict[str, list[tuple[float, Array]]] = {start: [] for start in blocks}
    for _ in range(rounds):
        for start, block in blocks.items():
            runs[start].append(_follow(block, targets))
    costs = []
    for start, done in runs.items():
        moves = np.rad2deg(np.abs(np.diff(done[0][1], axis=0))).max(axis=1)
        seconds = median(time for time, _ in done) / len(targets)
        jumps = int((moves > 5.0).sum())
        costs.append(PathCost(start, jumps, float(moves.max()), 1e6 * seconds))
    return costs


def path() -> Array:
    """A smooth closed path once round the base: (N,3) [m], some 3 mm a step."""
    s = np.linspace(0.0, 2.0 * np.pi, STEPS)
    r, z = 0.45 + 0.05 * np.cos(2.0 * s), 0.4 + 0.1 * np.sin(s)
    return np.column_stack([r * np.cos(s), r * np.sin(s), z])


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = solver_costs(rounds=rounds, progress=progress)
    lines = [
        "LabVolt 5250, reachable targets: solved to 1 µm, CPU time a target (median), over ours from the"
        " same start"
    ]
    lines += [
        f"  {cost.name:34s} {cost.start:7s} {cost.success:7.2f} % {cost.microseconds:8.1f} µs"
        f"  {cost.ratio:8.3g}"
        for cost in costs
    ]
    lines.append("LabVoltIk on a smooth path round the base, CPU time a cycle (median)")
    paths = path_costs(rounds=rounds)
    lines += [
        f"  start: {cost.start:27s} {cost.jumps:4d} jumps above 5°, largest step {cost.largest:6.2f}°"
        f" {cost.microseconds:8.1f} µs  {cost.microseconds / paths[-1].microseconds:8.3g}"
        for cost in paths
    ]
    return BenchmarkTable(lines, [*costs, *paths])


def _ours() -> Solver:
    geometry = labvolt()
    program = LabVoltProgram(geometry)

    def solve(target: Array, start: Array) -> Array:
        x, y, z = target.tolist()
        point = np.array([hypot(x, y) - geometry.offset, z - geometry.height])
        return np.array([atan2(y, x), *program.reach(point, start[1:])])

    return solve


def _starts(arm: DhArm, targets: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Joint positions (N,4) of each kind; all but zero face the target."""
    geometry, yaw = labvolt(), np.arctan2(targets[:, 1], targets[:, 0])
    count = len(targets)
    random = rng.uniform(geometry.lower, geometry.upper, (count, 3))
    middle = np.repeat(geometry.middle[None], count, axis=0)
    return {
        "random": np.column_stack([rng.uniform(-np.pi, np.pi, count), random]),
        "zero": np.zeros((count, 4)),
        "middle": np.column_stack([yaw, middle]),
        "fuzzy": initial_guess(targets),
    }


def _in_space(points: Array, rng: np.random.Generator) -> Array:
    """Points of the plane (N,2) as targets (N,3) all round the base; those behind it are left out."""
    geometry = labvolt()
    points = points[points[:, 0] + geometry.offset > 0.0]
    yaw, radius = rng.uniform(-np.pi, np.pi, len(points)), points[:, 0] + geometry.offset
    height = points[:, 1] + geometry.height
    return np.column_stack([radius * np.cos(yaw), radius * np.sin(yaw), height])


def _timed(arm: DhArm, solver: Solver, targets: Array, starts: Array) -> tuple[float, float]:
    """Seconds a target, share of the targets that are reached inside the limits."""
    gc.collect()
    begin = time.process_time()
    q = np.array([solver(target, start) for target, start in zip(targets, starts)])
    seconds = (time.process_time() - begin) / len(targets)
    error = np.linalg.norm(arm.forward_kinematics(q)[:, :3, 3] - targets, axis=1)
    inside = ((q >= arm.lower - REACHED) & (q <= arm.upper + REACHED)).all(axis=1)
    return seconds, float(((error <= REACHED) & inside).mean())


def _follow(block: LabVoltIk, targets: Array) -> tuple[float, Array]:
    """CPU time of the path [s], joint positions (N,4) [rad]."""
    context = block.CreateDefaultContext()
    port, output = block.GetInputPort("desired_position"), block.GetOutputPort("commanded_position")
    positions = np.empty((len(targets), 4))
    gc.collect()
    begin = time.process_time()
    for k, target in enumerate(targets):
        port.FixValue(context, target)
        positions[k] = output.Eval(context)
        context.SetDiscreteState(block.EvalUniquePeriodicDiscreteUpdate(context))
    return time.process_time() - begin, positions
