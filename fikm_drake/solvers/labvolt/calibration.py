"""Calibration of the memberships that the paper's figures give no numbers for."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.fuzzy.mamdani import MamdaniConfig, MamdaniSystem, load_mamdani
from fikm_drake.fuzzy.memberships import Triangle
from fikm_drake.solvers.labvolt.fuzzy_starts import POSTURE, THETA_3, FuzzyStarts
from fikm_drake.solvers.labvolt.geometry import Geometry, labvolt
from fikm_drake.solvers.labvolt.methods import theta_3_search
from fikm_drake.solvers.labvolt.plane_targets import random_targets
from fikm_drake.solvers.labvolt.program import LabVoltProgram

Loss = Callable[[MamdaniSystem, float], float]
Progress = Callable[[float], None]
FIRST_PEAKS = {
    THETA_3: (-1.57, -1.22, -0.79, 0.0, 0.52, 1.22, 0.26),
    POSTURE: (0.35, 0.79, 1.75, -0.7, 0.35, 1.57, -1.05, 0.0, 1.05),
}
"""Peaks of the outputs' memberships that the search starts from, in the order of the file [rad]."""
HALF_WIDTH = {THETA_3: 0.52, POSTURE: 1.57}
"""Half width of the outputs' triangles [rad]."""
FAR, RANGE = 0.5, (-2.1, 2.6)
"""Share of the trials that are drawn anew, at first, and from where [rad]; the others change the best."""
WHAT = {THETA_3: "guesses of θ_3, mean", POSTURE: "targets that the SQP misses"}
"""What is made small."""
APART = 0.17
"""Neighbouring peaks are apart by this at least [rad]."""
STEPS = (0.05, 0.4, 0.7)
"""Standard deviation of a trial's change: least, first and greatest [rad]."""
DIGITS = 3
"""Decimals of the peaks."""
MOVED = 0.4
"""Share of the peaks that a trial moves [-]."""
REACHED = 1e-9
"""A start is good if the SQP ends this near to the target [m]."""


@dataclass(frozen=True)
class Calibration:
    """A calibrated system."""

    system: MamdaniSystem
    """With the best peaks that were found."""
    what: str
    """What was made small."""
    first: float
    """That with the first peaks."""
    last: float
    """That with the best peaks."""


def calibrate(
    name: str,
    *,
    targets: int = 5000,
    rounds: int = 400,
    seed: int = 0,
    progress: Progress | None = None,
) -> Calibration:
    """Search the peaks of the outputs' memberships at random; what the solver needs decides.

    For `labvolt_theta3` that is the mean number of guesses of θ_3, for `labvolt_posture` the
    number of targets that the SQP misses. Rules, inputs and the order of the peaks stay.

    Args:
        name: `labvolt_theta3` or `labvolt_posture`.
        targets: how many, see `random_targets`.
        rounds: trials, at most; fewer if nothing is left to win.
        seed: of targets and trials: the same seed gives the same memberships.
        progress: called after each round with the fraction done.

    Raises:
        ValueError: an unknown name, a count that is not positive, or a negative seed.
    """
    if name not in FIRST_PEAKS:
        raise ValueError(f"name must be one of {tuple(FIRST_PEAKS)}, got {name!r}")
    check_counts(targets=targets, rounds=rounds)
    check_counts(0, seed=seed)
    make_loss = _tries if name == THETA_3 else _misses
    loss = make_loss(labvolt(), np.ascontiguousarray(random_targets(targets, seed=seed).T))
    config, rng = load_mamdani(name).config, np.random.default_rng(seed)
    peaks, size = np.array(FIRST_PEAKS[name]), STEPS[1]
    best = _with_peaks(config, peaks, HALF_WIDTH[name])
    first = least = loss(best, np.inf)
    for k in range(rounds):
        if k < rounds * FAR:
            trial = rng.uniform(*RANGE, len(peaks))
        else:
            trial = peaks + size * rng.normal(size=len(peaks)) * (rng.random(len(peaks)) < MOVED)
        trial = _apart(config, trial, FIRST_PEAKS[name])
        system = _with_peaks(config, trial, HALF_WIDTH[name])
        found = loss(system, least)
        if found <= least:
            best, least, peaks = system, found, trial
            size = min(1.3 * size, STEPS[2])
        else:
            size = max(0.95 * size, STEPS[0])
        if progress:
            progress((k + 1) / rounds)
        if least == 0.0:
            break
    return Calibration(best, WHAT[name], first, least)


def _tries(geometry: Geometry, points: Array) -> Loss:
    """Mean number of guesses of θ_3."""

    def loss(system: MamdaniSystem, bound: float) -> float:
        guess, _ = FuzzyStarts(theta_3=system).theta_3(points)
        return float(theta_3_search(geometry, points, guess)[1].mean())

    return loss


def _misses(geometry: Geometry, points: Array) -> Loss:
    """Targets that the SQP misses."""
    program = LabVoltProgram(geometry)
    hardest = list(range(points.shape[1]))

    def loss(system: MamdaniSystem, bound: float) -> float:
        starts = FuzzyStarts(posture=system).posture(points)
        missed: list[int] = []
        for i in hardest:
            q = program.reach(points[:, i], starts[:, i])
            if geometry.error(q, points[:, i]) > REACHED:
                missed.append(i)
                if len(missed) > bound:
                    break
        easy = set(hardest).difference(missed)
        hardest[:] = [*missed, *(i for i in hardest if i in easy)]  # the next bad trial ends early
        return float(len(missed))

    return loss


def _with_peaks(config: MamdaniConfig, peaks: Array, half_width: float) -> MamdaniSystem:
    """A system whose outputs' memberships are triangles with these peaks, in the order of the file."""
    values = iter(peaks.tolist())
    for variable in config.outputs:
        for label in variable.memberships:
            peak = next(values)
            left, right = round(peak - half_width, DIGITS), round(peak + half_width, DIGITS)
            variable.memberships[label] = Triangle(left, peak, right)
    return MamdaniSystem(config)


def _apart(config: MamdaniConfig, peaks: Array, first: tuple[float, ...]) -> Array:
    """The peaks of each output in the order of the first ones, apart, and inside its range."""
    ordered, start = np.round(peaks, DIGITS), 0
    for variable in config.outputs:
        own = slice(start, start + len(variable.memberships))
        ranks = np.argsort(np.argsort(first[own]))
        room = APART * np.arange(len(ranks))
        low = np.maximum.accumulate(np.sort(ordered[own]) - room)
        ordered[own] = (np.clip(low, variable.lower, variable.upper - room[-1]) + room)[ranks]
        start = own.stop
    return ordered
