"""Steps along a curve of self-motion: predictor, corrector, points where one more condition holds."""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.native_curve import CurveOptions
from fikm_drake.solvers.self_motion.spare_task import SpareTask

ITERATIONS = 12
"""Newton steps at most."""
CONVERGED = 1e-8
"""Newton's last step, at most [rad or m]: the error after it is the square of that."""
LEAST_COSINE = 0.95
"""Least cosine of the turn of the tangent in one step: 18 degrees."""
FIRST_STEP = 0.03
"""[rad or m]."""
LEAST_STEP = 1e-7
"""[rad or m]; where even this fails the curve ends in a singular posture."""
ROUNDING = 1e-12
"""How far past a limit is none [rad or m]."""
SEARCH_STEPS = 40
"""Steps of the search for a point of a curve, at most."""
LONGEST = 0.5
"""Step of that search [rad or m]."""
FOUND = 1e-6
"""Error at which Newton's method takes over from it [lever]."""
DAMPING = 1e-2
"""Damping of that search, times the square of the error."""
OPTIONS = CurveOptions(
    ITERATIONS,
    CONVERGED,
    LEAST_COSINE,
    LEAST_STEP,
    ROUNDING,
    SEARCH_STEPS,
    LONGEST,
    FOUND,
    DAMPING,
)


@dataclass(frozen=True)
class CurvePoint:
    """A point of the curve."""

    q: Array
    """(k,) positions of the moving joints [rad or m]."""
    tangent: Array
    """(k,), of length 1, forward."""
    orientation: float = 0.0
    """Sign of the determinant of the Jacobian's rows and the tangent: the same all along a curve."""

    def reversed(self) -> "CurvePoint":
        """The same point, backward."""
        return CurvePoint(self.q, -self.tangent, -self.orientation)


class SelfMotionCurve:
    """The postures of an arm that hold a tool at its target: a curve in the space of its joints.

    Args:
        task: the task with one spare degree of freedom.
        target: of the tool.
        start: (n,) positions that the joints that do not move the tool keep [rad or m].
    """

    def __init__(self, task: SpareTask, target: RigidTransform, start: Array) -> None:
        self.task = task
        self.target = target
        self.start = start
        self._q = start.copy()
        self.native = task.native_curve(target, start, OPTIONS)
        """The same by the native kernel, where there is one."""

    def __reduce__(self) -> tuple:
        """Pickled as its arguments: the kernel's addresses mean nothing elsewhere."""
        return SelfMotionCurve, (self.task, self.target, self.start)

    def linearise(self, q: Array) -> tuple[Array, Array]:
        """Error (k−1,) [lever] and Jacobian (k−1,k) at the moving joints' positions (k,)."""
        self._q[self.task.moving] = q
        return self.task.error_and_jacobian(self.target, self._q)

    def is_met(self, q: Array) -> bool:
        """Whether a point of the curve (k,) meets the rows that no joint moves, too."""
        self._q[self.task.moving] = q
        return self.task.is_met(self.target, self._q)

    def solve(self, q: Array, row: Array, value: float) -> CurvePoint | None:
        """The point of the curve near `q` (k,) with row · q = value, by Newton's method.

        Args:
            q: where to start.
            row: (k,), such as a tangent or the unit vector of a joint.
            value: what row · q must be.

        Returns:
            The point with its tangent on the side of `row`; None where Newton's method fails.
        """
        if self.native:
            found = self.native.newton(q, row, value)
            return CurvePoint(*found) if found else None
        k = q.size
        A, right = np.empty((k, k)), np.zeros((k, 2))
        A[-1], right[-1, 1] = row, 1.0
        for _ in range(ITERATIONS):
            right[:-1, 0], A[:-1] = self.linearise(q)
            right[-1, 0] = value - row @ q
            try:
                step, tangent = np.linalg.solve(A, right).T
            except np.linalg.LinAlgError:
                return None
            size = np.abs(step).max()
            if not size < 1.0:
                return None
            q = q + step
            if size < CONVERGED:
                orientation = float(np.sign(np.linalg.det(A)))
                return CurvePoint(q, tangent / np.sqrt(tangent @ tangent), orientation)
        return None

    def arrive(self, q: Array) -> Array | None:
        """Where damped steps from `q` (k,) come within `FOUND` of the target, if they do."""
        if self.native:
            return self.native.arrive(q)
        for _ in range(SEARCH_STEPS):
            error, J = self.linearise(q)
            square = float(error @ error)
            if square < FOUND**2:
                return q
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * square * np.eye(len(error)), error)
            q = q + step * min(1.0, LONGEST / np.sqrt(step @ step))
        return None

    def point(self, q: Array) -> CurvePoint | None:
        """The point of the curve at or next to `q` (k,); None where the curve is singular."""
        null = self.direction(q)
        return self.solve(q, null, float(null @ q))

    def direction(self, q: Array) -> Array:
        """A direction (k,) in which the joints at `q` (k,) do not move the tool, of length 1."""
        return np.linalg.svd(self.linearise(q)[1])[2][-1]

    def advance(
        self, here: CurvePoint, before: CurvePoint | None, step: float
    ) -> CurvePoint | None:
        """The point about `step` ahead; None where the step is too long for the curve's bends."""
        ahead = step * here.tangent
        if before is not None:
            back = here.q - before.q
            ahead = ahead + (0.5 * step**2 / np.sqrt(back @ back)) * (here.tangent - before.tangent)
        guess = here.q + ahead
        there = self.solve(
            guess, here.tangent, float(here.tangent @ (here.q + step * here.tangent))
        )
        if there is None or there.tangent @ here.tangent < LEAST_COSINE:
            return None
        if there.orientation != here.orientation:  # over to another branch that nearly meets this
            return None
        miss = there.q - guess
        return there if miss @ miss < (0.5 * step) ** 2 else None
