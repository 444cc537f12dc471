"""Single calls: kinematics, one pose, poses at limits, the import (`fikm-drake benchmark single`)."""

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.batch_benchmark import HOME
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.interleaved import interleaved
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.native.kernel import kernel
from fikm_drake.solvers.solver import Solver

ARM = "iiwa14"
CORNERS = 60
"""Postures with every joint at one of its limits."""
BEST_OF = 5
"""A target is timed so often; the least time is what it takes when nothing else disturbs."""
IMPORT = """
import time
start = time.perf_counter()
import pydrake.all
middle = time.perf_counter()
import fikm_drake
after = time.perf_counter()
for name in fikm_drake.__all__:
    getattr(fikm_drake, name)
print(middle - start, after - middle, time.perf_counter() - after)
"""


@dataclass(frozen=True)
class SingleCost:
    """One kind of call."""

    what: str
    """The call."""
    native: float
    """Median time with the native kernel [µs]; NaN without one."""
    numpy: float
    """The same without it."""
    slowest: float
    """The slowest target's with the kernel [µs]; NaN where all calls are alike."""
    slowest_numpy: float
    """The same without it."""
    limit: float
    """Time of the same in a batch, a posture or target [µs]: what remains is the call. NaN: no kernel."""
    success: float
    """Targets reached [%]."""


def single_benchmark(
    rounds: int = 20, *, progress: Callable[[float], None] | None = None
) -> list[SingleCost]:
    """Time calls for one posture, one target; poses of the corners of the limits; CPU time.

    Args:
        rounds: how often the kinematics are timed.
        progress: called now and then with the fraction done.

    Raises:
        ValueError: rounds is not positive.
    """
    if rounds < 1:
        raise ValueError(f"rounds must be positive, got {rounds}")
    chain, costs = load_arm(ARM).chain, []
    q = np.array(HOME[ARM])
    many = np.tile(q, (512, 1))
    pairs: list[tuple[str, Callable[[Array], Array], Callable[[Array], Array]]] = [
        ("forward kinematics", chain.forward_kinematics, chain.one.pose),
        ("Jacobian", chain.jacobian, chain.one.jacobian),
    ]
    for name, ours, in_numpy in pairs:
        calls: dict[str, Callable[[], Any]] = {
            "one": partial(ours, q),
            "numpy": partial(in_numpy, q),
            "batch": partial(ours, many),
        }
        times = interleaved(calls, rounds=rounds, repeats=100)
        one, numpy, batch = (1e6 * float(np.median(times[key])) for key in calls)
        limit = batch / len(many) if kernel() else np.nan
        native = one if kernel() else np.nan
        costs.append(SingleCost(f"{name}, {ARM}", native, numpy, np.nan, np.nan, limit, np.nan))
    for k, name in enumerate((ARM, "panda")):
        costs += [_targets(name, corners=False), _targets(name, corners=True)]
        if progress:
            progress(0.5 * (k + 1))
    return costs


def import_seconds(processes: int = 5) -> tuple[float, float, float]:
    """Median time of `import pydrake.all`, of `import fikm_drake` after it, of all its names then [s]."""
    runs = []
    for _ in range(processes):
        done = subprocess.run(
            [sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True, timeout=120
        )
        runs.append([float(word) for word in done.stdout.split()])
    drake, ours, names = np.median(runs, axis=0).tolist()
    return drake, ours, names


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = single_benchmark(rounds, progress=progress)
    drake, ours, names = import_seconds()
    lines = [
        f"{'CPU time of a call, median [µs]':44s} {'native':>8s} {'slowest':>8s} {'numpy':>8s}"
        f" {'slowest':>8s} {'batch':>8s} {'reached':>8s}"
    ]
    for c in costs:
        cells = (c.native, c.slowest, c.numpy, c.slowest_numpy, c.limit)
        cut = [f"{cell:8.2f}" if np.isfinite(cell) else f"{'':8s}" for cell in cells]
        reached = f"{c.success:6.1f} %" if np.isfinite(c.success) else ""
        lines.append(f"  {c.what:42s} {' '.join(cut)} {reached}")
    lines.append(
        f"import pydrake.all {drake:.3f} s, then import fikm_drake {ours:.4f} s, then each of its names "
        f"{names:.3f} s (on the clock)"
    )
    imports = {
        "import pydrake.all [s]": drake,
        "then import fikm_drake [s]": ours,
        "then each of its names [s]": names,
    }
    return BenchmarkTable(lines, [*costs, imports])


def _targets(name: str, corners: bool) -> SingleCost:
    arm, rng = load_arm(name), np.random.default_rng(0)
    home = np.array(HOME[name])
    if corners:
        postures = np.where(
            rng.integers(0, 2, (CORNERS, arm.num_joints)) == 1, arm.upper, arm.lower
        )
    else:
        postures = rng.uniform(arm.lower, arm.upper, (10 * CORNERS, arm.num_joints))
    targets, figures, reached, limit = arm.forward_kinematics(postures), [], [], np.nan
    for native in (True, False):
        if native and kernel() is None:
            figures += [np.nan, np.nan]
            continue
        solver = Solver(arm, task="pose", native=native)
        solver.solve(targets[0], home)
        least = np.full(len(targets), np.inf)
        for _ in range(BEST_OF):
            for i, target in enumerate(targets):
                start = time.process_time()
                solution = solver.solve(target, home)
                least[i] = min(least[i], time.process_time() - start)
                reached.append(solution.success)
        slow = 100.0 if corners else 99.0
        figures += [1e6 * float(np.median(least)), 1e6 * float(np.percentile(least, slow))]
        if native:
            batch = partial(solver.solve_batch, targets, home, threads=1)
            limit = 1e6 * min(interleaved({"batch": batch}, rounds=BEST_OF, repeats=1)["batch"])
    what = (
        f"pose at limits, {name}, worst of {CORNERS}" if corners else f"pose from home, {name}, p99"
    )
    native_, slowest, numpy, slowest_numpy = figures
    share = 100.0 * float(np.mean(reached))
    limit /= len(targets)
    return SingleCost(what, native_, numpy, slowest, slowest_numpy, limit, share)
