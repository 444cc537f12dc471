"""Paper 4: its methods on random targets, errors and times."""

import time
from dataclasses import dataclass
from functools import cache

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.solvers.labvolt.fuzzy_starts import default_starts
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.plane_targets import random_targets
from fikm_drake.solvers.labvolt.program import LabVoltProgram
from fikm_drake.solvers.labvolt.solve import TOLERANCE, solve

FEW, MANY = 500, 5000
"""Targets: the paper's number, and ours."""
SEED = 20
"""Seed of the targets; the calibration has other ones."""
RANDOM_START = "sqp, random start"
PAPER = {
    "analytic": ((5.79, 24.80), (4.09, 17.53)),
    "hybrid_analytic": ((3.86, 22.2), (2.10, 3.08)),
    RANDOM_START: ((4833.38, 20262.56), (39.41, 155.23)),
    "sqp": (None, None),
    "hybrid_sqp": ((286.93, 2593.29), (34.03, 45.13)),
    "ha_after_hs": ((4.76, 37.99), (31.47, 3.59)),
    "hs_after_ha": ((3.55e-3, 1.53e-3), (25.14, 5.63)),
    "cascade": (None, None),
    "exact": (None, None),
}
"""Tables 3 and 4: average and standard deviation of the error [µm] and of the time [ms]. The paper does
not say where its SQP starts; what it prints is like a random start."""


@dataclass(frozen=True)
class Run:
    """A method on N targets."""

    error: Array
    """(N,) [m]."""
    milliseconds: Array
    """(N,): CPU time of a target, one call each [ms]; empty where all went in one call."""

    @property
    def solved(self) -> int:
        """Targets reached within the tolerance of `solve`."""
        return int((self.error <= TOLERANCE).sum())


@cache
def targets(count: int) -> Array:
    """Reachable targets (N,2), seeded [m]."""
    return random_targets(count, seed=SEED)


@cache
def many() -> dict[str, Run]:
    """Every method on 5000 targets, in one call each."""
    return {name: Run(_errors(name, targets(MANY)), np.empty(0)) for name in PAPER}


@cache
def few() -> dict[str, Run]:
    """Every method on the paper's number of targets, one call a target; the first call is not timed."""
    points = targets(FEW)
    runs = {}
    for name in PAPER:
        _errors(name, points[:1])
        errors, times = np.empty(FEW), np.empty(FEW)
        for i, point in enumerate(points):
            start = time.process_time()
            errors[i] = _errors(name, point[None], seed=i)[0]
            times[i] = 1e3 * (time.process_time() - start)
        runs[name] = Run(errors, times)
    return runs


@cache
def bare() -> dict[str, Array]:
    """CPU time (FEW,) [ms] of the SQP alone by its start: no `solve` around it to read and check."""
    points, geometry, program = targets(FEW), labvolt(), _program(False)
    low, high = geometry.lower, geometry.upper
    random, starts = np.random.default_rng(0).uniform(low, high, (FEW, 3)), default_starts()
    ways = {
        RANDOM_START: lambda i: random[i],
        "sqp": lambda i: geometry.middle,
        "hybrid_sqp": lambda i: starts.posture(points[i][:, None])[:, 0],
    }
    found = {}
    for name, start in ways.items():
        program.reach(points[0], start(0))
        times = np.empty(FEW)
        for i, point in enumerate(points):
            began = time.process_time()
            program.reach(point, start(i))
            times[i] = 1e3 * (time.process_time() - began)
        found[name] = times
    return found


def random_start_errors(points: Array, *, absolute: bool = False, seed: int = 0) -> Array:
    """Errors (N,) [m] of the SQP from postures uniform inside the limits, for targets (N,2) [m]."""
    geometry = labvolt()
    starts = np.random.default_rng(seed).uniform(geometry.lower, geometry.upper, (len(points), 3))
    return sqp_errors(_program(absolute), points, starts)


def sqp_errors(program: LabVoltProgram, points: Array, starts: Array) -> Array:
    """Errors (N,) [m] of the SQP from starts (N,3), relative [rad], for targets (N,2) [m]."""
    q = np.array([program.reach(point, start) for point, start in zip(points, starts)])
    return labvolt().error(q.T, points.T)


@cache
def _program(absolute: bool) -> LabVoltProgram:
    return LabVoltProgram(labvolt(), absolute=absolute)


def _errors(name: str, points: Array, *, seed: int = 0) -> Array:
    if name == RANDOM_START:
        return random_start_errors(points, seed=seed)
    return solve(points, method=name).error
