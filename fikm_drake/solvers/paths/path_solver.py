"""Damped Newton steps of a chain toward a target: one posture, or many side by side."""

from dataclasses import dataclass

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.null_space import null_space_step
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.solvers.batch.batch_targets import BatchTargets

DAMPING = 1e-4
"""Damping of the steps, over the square of the characteristic length [-]."""
LONGEST = 0.3
"""A joint moves no further in a step [rad, or times the reach in m]."""
STEPS, SEARCH_STEPS = 30, 60
"""Steps toward the next target of a path, and of a posture that is searched for [-]."""
MIDDLE = 0.5
"""Part of the way to the middle of the limits, over the motion of the tool [-]."""


@dataclass(frozen=True)
class PathSolver:
    """Postures of one chain for single targets.

    Attributes:
        chain: the arm.
        length: a turn of 1 rad counts as this much [m].
        tolerance: of the error, rotations times `length` [m].
        clearance: keeps clear where there is one.
    """

    chain: SerialChain
    length: float
    tolerance: float
    clearance: Clearance | None = None

    def errors(self, q: Array, target: Array) -> tuple[Array, Array]:
        """Errors (m,N) and their lengths (N,) [m] of postures q (N,n) before one target."""
        error, _, _, _ = self._task(q, target)
        return error, np.sqrt(np.sum(error * error, axis=0))

    def follow(self, q: Array, target: Array, motion: float) -> tuple[Array, float]:
        """The posture near q (n,) that solves a target, and what is left of the error [m].

        Args:
            q: where the joints are (n,) [rad or m].
            target: position (3,) or pose (4,4).
            motion: how far the tool has to go [m]; the free joints turn to the middle in proportion.
        """
        chain = self.chain
        q, wish = q.copy(), self._middle(q, motion)
        size = np.inf
        for k in range(STEPS):
            error, J, size, _ = self._one(q, target)
            if size <= self.tolerance and (k or not wish.any()):
                break
            step = self._step(q, J, error)
            if k == 0:
                step = step + null_space_step(J, wish)
            if self.clearance is not None:
                step, _ = self.clearance(q, step, J=J)
            moved = np.clip(q + step, chain.lower, chain.upper)
            if not np.abs(moved - q).max() > 1e-12:
                break
            q = moved
        return q, self._one(q, target)[2]

    def search(self, target: Array, starts: Array) -> Array:
        """Postures (K,n) that solve a target inside the limits and clear, from starts (N,n)."""
        q, chain = starts.copy(), self.chain
        eye = np.eye(3 if target.ndim == 1 else 6)
        for _ in range(SEARCH_STEPS):
            error, J, _, _ = self._task(q, target)
            J, e = J.transpose(2, 0, 1), error.T
            far = np.sqrt(np.sum(e * e, axis=1))[:, None]
            e = e * np.minimum(1.0, chain.reach * LONGEST / np.maximum(far, 1e-300))
            square = J @ J.transpose(0, 2, 1) + DAMPING * self.length**2 * eye
            step = (J.transpose(0, 2, 1) @ np.linalg.solve(square, e[..., None]))[..., 0]
            size = np.abs(step / self._units).max(axis=1, keepdims=True)
            q = np.clip(q + step / np.maximum(1.0, size / LONGEST), chain.lower, chain.upper)
        solved = q[self.errors(q, target)[1] <= self.tolerance]
        if self.clearance is None:
            return solved
        return np.array([x for x in solved if self.clearance.is_clear(x)]).reshape(-1, q.shape[1])

    def clear_between(self, before: Array, after: Array) -> bool:
        """True if the straight way of the joints is clear, looked at every hundredth of a radian."""
        if self.clearance is None:
            return True
        parts = max(1, int(np.ceil(np.abs(after - before).max() / 0.01)))
        ways = (before + k / parts * (after - before) for k in range(1, parts + 1))
        return all(self.clearance.is_clear(q) for q in ways)

    @property
    def _units(self) -> Array:
        """What counts as one radian of a joint (n,) [rad or m]."""
        return np.where(self.chain.revolute, 1.0, self.chain.reach)

    def _task(self, q: Array, target: Array) -> tuple[Array, Array, Array, Array]:
        frames = self.chain.frames(np.ascontiguousarray(q.T))
        wanted = BatchTargets.from_array(np.broadcast_to(target, (len(q), *target.shape)))
        error, distance, angle = wanted.error(frames, self.length)
        return error, frames.jacobian(wanted.length(self.length)), distance, angle

    def _one(self, q: Array, target: Array) -> tuple[Array, Array, float, Array]:
        error, J, distance, _ = self._task(q[None], target)
        return error[:, 0], J[..., 0], float(np.linalg.norm(error)), distance

    def _step(self, q: Array, J: Array, error: Array) -> Array:
        """Damped least squares of the joints that are not at a limit and pushed outward."""
        free = np.ones(len(q))
        step = np.zeros(len(q))
        damping = DAMPING * self.length**2 * np.eye(len(error))
        for _ in range(3):
            W = J * free
            step = W.T @ np.linalg.solve(W @ W.T + damping, error)
            out = ((q <= self.chain.lower) & (step < 0)) | ((q >= self.chain.upper) & (step > 0))
            if not (out & (free > 0)).any():
                break
            free[out] = 0.0
        return step / max(1.0, float(np.abs(step / self._units).max()) / LONGEST)

    def _middle(self, q: Array, motion: float) -> Array:
        """Toward the middle of the limits, as far as the tool moves; a joint about there is left alone."""
        both = np.isfinite(self.chain.upper - self.chain.lower)
        half = np.where(both, 0.5 * (self.chain.upper - self.chain.lower), 1.0)
        middle = np.where(both, 0.5 * (self.chain.upper + self.chain.lower), q)
        off = (q - np.where(both, middle, q)) / half
        return -MIDDLE * motion / self.chain.reach * off**3 * self._units
