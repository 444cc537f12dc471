"""What the methods of `solve` are made of: algorithm 1 of the paper, the SQP, the closed form."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import wrap
from fikm_drake.kinematics.planar_links import EDGE, two_links
from fikm_drake.solvers.labvolt.fuzzy_starts import FIRST_GUESS, FuzzyStarts
from fikm_drake.solvers.labvolt.geometry import Geometry, labvolt
from fikm_drake.solvers.labvolt.program import LabVoltProgram

STEP = float(np.deg2rad(1.0))
"""Between guesses [rad]; the paper gives none, M. Elsharif's MATLAB library takes this."""
MOST_TRIES = 361
"""The first guess and up to 180° either way."""


def theta_3_search(
    geometry: Geometry, target: Array, guess: Array
) -> tuple[Array, NDArray[np.int_]]:
    """Guess θ_3, then 1° more, 1° less, 2° more … until the posture is inside the limits.

    Args:
        geometry: of the arm.
        target: points in the arm's plane (2,N) [m].
        guess: first θ_3 (N,), absolute [rad].

    Returns:
        Relative angles (3,N) [rad], NaN where no guess is good; tries (N,).
    """
    q = np.full((3, target.shape[1]), np.nan)
    tries = np.full(target.shape[1], MOST_TRIES)
    left = np.arange(target.shape[1])
    for k in range(MOST_TRIES):
        steps = (k + 1) // 2 * (1 if k % 2 else -1)
        found, good = _postures(geometry, target[:, left], guess[left] + steps * STEP)
        done = left[good]
        q[:, done], tries[done] = found[:, good], k + 1
        left = left[~good]
        if not left.size:
            break
    return q, tries


def _postures(geometry: Geometry, target: Array, theta_3: Array) -> tuple[Array, Bools]:
    """Relative angles (3,N) with the elbow up, else down, and whether they are inside the limits."""
    first, second, third = geometry.lengths
    wrist = target - third * np.array([np.cos(theta_3), np.sin(theta_3)])
    q = np.empty((3, target.shape[1]))
    good = np.zeros(target.shape[1], dtype=bool)
    for side in (-1.0, 1.0):
        theta_1, elbow = two_links(first, second, wrist, side)
        posture = wrap(np.array([theta_1, elbow, theta_3 - theta_1 - elbow]))
        better = geometry.contains(posture, EDGE) & ~good
        q[:, better] = posture[:, better]
        good |= better
    return q, good


Found = tuple[Array, NDArray[np.int_]]
"""Relative angles (3,N) [rad], NaN where there are none, and tries (N,)."""


@dataclass(frozen=True)
class Goals:
    """What is wanted for N targets that can be reached."""

    points: Array
    """(2,N) in the arm's plane [m]."""
    exact: Array
    """(3,N) relative angles: the closed form [rad]."""
    wishes: Array | None
    """(3,N) relative angles that the SQP should come near to [rad]; None: any."""

    def __len__(self) -> int:
        return self.points.shape[1]

    def take(self, lanes: NDArray[np.intp]) -> "Goals":
        """Some of them."""
        wishes = None if self.wishes is None else self.wishes[:, lanes]
        return Goals(self.points[:, lanes], self.exact[:, lanes], wishes)


@dataclass(frozen=True)
class Ways:
    """The ways, and what they need."""

    geometry: Geometry
    """Geometry of the arm."""
    fuzzy: FuzzyStarts
    """The rules."""
    program: LabVoltProgram
    """The SQP."""
    tolerance: float
    """Within this a target is reached [m]."""

    def exact(self, goals: Goals) -> Found:
        """The middle of the widest feasible arc, in closed form."""
        return goals.exact.copy(), np.zeros(len(goals), dtype=int)

    def search(self, goals: Goals) -> Found:
        """Algorithm 1 from θ_3 = −90°."""
        guess = np.full(len(goals), FIRST_GUESS)
        return theta_3_search(self.geometry, goals.points, guess)

    def fuzzy_search(self, goals: Goals) -> Found:
        """Algorithm 1 from the rules' θ_3."""
        return theta_3_search(self.geometry, goals.points, self.fuzzy.theta_3(goals.points)[0])

    def sqp(self, goals: Goals) -> Found:
        """The SQP from the middle of the limits."""
        return self._descend(goals, np.repeat(self.geometry.middle[:, None], len(goals), axis=1))

    def fuzzy_sqp(self, goals: Goals) -> Found:
        """The SQP from the rules' posture."""
        return self._descend(goals, self.fuzzy.posture(goals.points))

    def exact_sqp(self, goals: Goals) -> Found:
        """The SQP from the closed form, which leaves it only a posture to choose."""
        return self._descend(goals, goals.exact)

    def sqp_after_search(self, goals: Goals) -> Found:
        """The SQP from what `fuzzy_search` finds; from the rules' posture where it finds nothing."""
        starts, tries = self.fuzzy_search(goals)
        lost = np.isnan(starts[0])
        starts[:, lost] = self.fuzzy.posture(goals.points[:, lost])
        q, runs = self._descend(goals, starts)
        return q, tries + runs

    def _descend(self, goals: Goals, starts: Array) -> Found:
        q = np.empty(starts.shape)
        for lane, (point, start) in enumerate(zip(goals.points.T, starts.T)):
            q[:, lane] = self.program.reach(point, start)
        return q, np.ones(len(goals), dtype=int)

    def settled(self, goals: Goals, q: Array, tries: NDArray[np.int_]) -> Found:
        """What a way found, moved along the postures that reach the target to the nearest to a wish."""
        if goals.wishes is not None:
            reached = self.geometry.error(q, goals.points) <= self.tolerance  # NaN is not
            for i in np.flatnonzero(reached):
                q[:, i] = self._settled(goals.points[:, i], q[:, i], goals.wishes[:, i])
        return q, tries

    def _settled(self, point: Array, q: Array, wish: Array) -> Array:
        """The nearest to a wish of what SQP finds from `q` and from the wish itself."""
        best = q
        for start in (q, self.program.reach(point, wish)):
            found = self.program.settle(point, start, wish)
            nearer = np.sum((found - wish) ** 2) < np.sum((best - wish) ** 2)
            if nearer and self.geometry.error(found, point) <= self.tolerance:
                best = found
        return best


Way = Callable[[Ways, Goals], Found]
METHODS: dict[str, tuple[Way, ...]] = {
    "exact": (Ways.exact,),
    "analytic": (Ways.search,),
    "hybrid_analytic": (Ways.fuzzy_search,),
    "sqp": (Ways.sqp,),
    "hybrid_sqp": (Ways.fuzzy_sqp,),
    "ha_after_hs": (Ways.fuzzy_sqp, Ways.fuzzy_search),
    "hs_after_ha": (Ways.sqp_after_search,),
    "cascade": (Ways.fuzzy_sqp, Ways.sqp, Ways.exact_sqp),
}
"""Ways of each method: a way is tried on the targets that those before it did not reach."""


class _Programs(threading.local):
    """Programs are built once a thread: a new target changes them."""

    def __init__(self) -> None:
        self.by_solver: dict[str, LabVoltProgram] = {}


_programs = _Programs()


def program(solver: str) -> LabVoltProgram:
    """The thread's program for the LabVolt 5250.

    Raises:
        ValueError: see `LabVoltProgram`.
    """
    if solver not in _programs.by_solver:
        _programs.by_solver[solver] = LabVoltProgram(labvolt(), solver=solver)
    return _programs.by_solver[solver]
