"""Goes along the targets of a path, and looks for another posture where it must."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.solvers.paths.path_solver import PathSolver
from fikm_drake.solvers.paths.path_targets import between

APART = 0.02
"""Targets further apart than this fraction of the reach are reached through others in between [-]."""
STARTS = 64
"""Random postures from which postures of a target are searched [-]."""
TRIES, AHEAD = 8, 40
"""Postures that are tried at a reconfiguration, and the number of targets that each is tried on [-]."""
STILL = 1e-3
"""What a joint may move where the tool does not [rad, or over the reach]."""


class PathStatus(IntEnum):
    """How a target of a path was met."""

    INVALID_INPUT = 0
    """The target is NaN, infinite or no pose; the joints stay."""
    FOLLOWED = 1
    """Within the tolerance, without a leap."""
    RECONFIGURED = 2
    """Within the tolerance, but the joints have to change to another posture before this target."""
    NOT_REACHED = 3
    """No posture was found that is inside the limits, clear, and solves the target; the joints stay."""


class Follower:
    """Follows targets with one solver; the arguments are those of `joint_path`."""

    def __init__(self, solver: PathSolver, targets: Array, max_ratio: float, seed: int) -> None:
        self._solver, self._targets, self._ratio = solver, targets, max_ratio
        valid: Bools = np.array(np.isfinite(targets).reshape(len(targets), -1).all(axis=1))
        self._valid = valid
        if targets.ndim == 3:
            R = targets[self._valid][:, :3, :3]
            far = np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).reshape(len(R), 9).max(axis=1)
            self._valid[self._valid] = (far < 1e-4) & (np.linalg.det(R) > 0.0)
        chain = solver.chain
        low, high = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
        slides = ~chain.revolute
        low = np.where(slides, np.maximum(chain.lower, -chain.reach), low)
        high = np.where(slides, np.minimum(chain.upper, chain.reach), high)
        n = chain.num_joints
        self._starts = low + (high - low) * np.random.default_rng(seed).random((STARTS, n))
        self._units = np.where(chain.revolute, 1.0, chain.reach)

    def run(self, start: Array | None) -> tuple[Array, NDArray[np.int_], Array]:
        """Joint positions (N,n), statuses (N,) and errors (N,)."""
        count = len(self._targets)
        q = np.empty((count, self._solver.chain.num_joints))
        status = np.full(count, PathStatus.INVALID_INPUT.value)
        error = np.full(count, np.nan)
        here, last = start, -1  # the last target that was reached
        for k in range(count):
            if self._valid[k]:
                there = None
                if last >= 0 and here is not None:
                    there = self._follow(here, last, k)
                status[k] = PathStatus.FOLLOWED
                if there is None:
                    there = self._other_posture(here, k, first=last < 0)
                    status[k] = PathStatus.FOLLOWED if last < 0 else PathStatus.RECONFIGURED
                if there is None:
                    status[k] = PathStatus.NOT_REACHED
                else:
                    here, last = there, k
            q[k] = self._solver.chain.default_position if here is None else here
            if self._valid[k]:
                error[k] = self._solver.errors(q[k][None], self._targets[k])[1][0]
        return q, status, error

    def _follow(self, q: Array, before: int, k: int) -> Array | None:
        """The posture of target k, continuous from q at target `before`; None: there is none."""
        one, two = self._targets[before], self._targets[k]
        reach = self._solver.chain.reach
        motion = self._motion(one, two)
        parts = max(1, int(np.ceil(motion / (APART * reach))))
        for i in range(1, parts + 1):
            target = two if i == parts else between(one, two, i / parts)
            there, size = self._solver.follow(q, target, motion / parts)
            most = self._ratio * motion / parts / reach + STILL
            leaps = np.abs((there - q) / self._units).max() > most
            if size > self._solver.tolerance or leaps or not self._solver.clear_between(q, there):
                return None
            q = there
        return q

    def _other_posture(self, q: Array | None, k: int, *, first: bool) -> Array | None:
        """The posture of target k that follows furthest; of a first one, that next to q."""
        solver, target = self._solver, self._targets[k]
        if first and q is not None:
            there, size = solver.follow(q, target, 0.0)
            if size <= solver.tolerance and solver.clear_between(there, there):
                return there
        starts = self._starts if q is None else np.vstack([q, self._starts])
        found = solver.search(target, starts)
        if not len(found):
            return None
        chain = solver.chain
        middle = np.clip(np.zeros(chain.num_joints), chain.lower, chain.upper) if q is None else q
        found = found[np.argsort(np.abs((found - middle) / self._units).max(axis=1))]
        if first and q is not None:
            return found[0]
        chosen, furthest = found[0], -1
        for there in _distinct(found)[:TRIES]:
            far = self._ahead(there, k, len(self._targets) if first else AHEAD)
            if far > furthest:
                chosen, furthest = there, far
            if k + far >= len(self._targets) - 1:
                break
        return chosen

    def _ahead(self, q: Array, k: int, most: int) -> int:
        """The number of targets after k that q follows, up to `most`."""
        here: Array | None = q
        last = min(len(self._targets), k + 1 + most) - 1
        for after in range(k + 1, last + 1):
            if self._valid[after] and self._valid[after - 1] and here is not None:
                here = self._follow(here, after - 1, after)
            if here is None:
                return after - k - 1
        return last - k

    def _motion(self, one: Array, two: Array) -> float:
        """How far the tool moves between two targets [m]."""
        if one.ndim == 1:
            return float(np.linalg.norm(two - one))
        cosine = 0.5 * (np.trace(one[:3, :3].T @ two[:3, :3]) - 1.0)
        turn = self._solver.length * float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return float(np.hypot(np.linalg.norm(two[:3, 3] - one[:3, 3]), turn))


def _distinct(found: Array) -> Array:
    """Postures (K,n) that differ from those before them by 0.1 rad or more in a joint."""
    kept: list[Array] = []
    for q in found:
        if all(np.abs(q - other).max() > 0.1 for other in kept):
            kept.append(q)
    return np.array(kept)
