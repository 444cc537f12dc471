"""Many starts side by side: the scaled fuzzy mapping until each is solved or stuck.

Lengths are fractions of the chain's reach: the chain that enters has a reach of 1. The native kernel
(`kinematics/native/`) does the same; its constants come from here.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.solvers.batch.batch_targets import BatchTargets

Lanes = NDArray[np.intp]
LENGTH = 0.25
"""Characteristic length that multiplies rotations [reach]; of 0.15 to 0.4 the fastest."""
STEP = 0.2
"""Bound of the task error that one cycle takes on, |dr| [reach]."""
DAMPING = (1e-6, 0.013)
"""λ² = DAMPING[0] + DAMPING[1] |dr|: firm on the way, sharp at the target [-]."""
EXTRA_DAMPING = (1e-3, 10.0)
"""Least, once there is any, and greatest λ² that bad steps of a careful descent add [-]."""
EXTRA_FACTORS = (16.0, 0.5)
"""What multiplies it after a bad and after a good step [-]."""
BLOCKED = 1e-3
"""Mobility of a joint at a limit that is pushed outward [-]."""
AT_LIMIT = 1e-9
"""A joint this near to a limit is at it [rad or reach]."""
FLOOR = 0.05
"""Row and column sums are bounded from below by this fraction of the largest [-]."""
WINDOWS = (4, 12)
"""Cycles between looks at the progress, of a quick and of a careful descent."""
PROGRESS = (0.5, 1e-3)
"""Fraction of the error that the cycles of a window must take away, quick and careful [-]."""


@dataclass(frozen=True)
class Descent:
    """How starts end; each is a lane of a structure of arrays.

    Every `window` cycles a start must have lowered its least error by the fraction `progress` of it,
    or of `STEP` if that is smaller; else it is stuck and given up.

    Args:
        arm: kinematics.
        limits: lower and upper joint limits (n,) and (n,) [rad or m], or None.
        tolerance: position [m] and rotation [rad].
        max_cycles: of each start.
        careful: a step that makes the error greater is taken back and the next ones are damped
            more. That is slower, but where the target is out of reach it ends at the nearest posture
            and not in leaps around it.
    """

    arm: SerialChain
    limits: tuple[Array, Array] | None
    tolerance: tuple[float, float]
    max_cycles: int
    careful: bool = False

    @property
    def window(self) -> int:
        """Cycles between looks at the progress."""
        return WINDOWS[self.careful]

    @property
    def progress(self) -> float:
        """Fraction of the error that the cycles of a window must take away [-]."""
        return PROGRESS[self.careful]

    def run(self, q: Array, targets: BatchTargets, owners: Lanes) -> "Ends":
        """Run all starts; when one is solved, the later ones of its owner end too.

        Args:
            q: starts (n,N) [rad or m], inside the limits.
            targets: N targets, one a start.
            owners: (N,) whose starts they are, 0 to N − 1.

        Returns:
            How they ended. The first of an owner's starts that can be solved is solved, whatever runs
            beside it.
        """
        count = q.shape[1]
        ends = Ends(q.copy(), np.full(count, np.inf), np.zeros((2, count)), np.zeros(count, int))
        if not count:
            return ends
        first = np.full(count, count)
        shared = np.bincount(owners).max() > 1
        lanes = np.arange(count)
        best = _Best(q.copy(), np.full((3, count), np.inf))
        checked = np.full(count, np.inf)
        extra = np.zeros(count)
        for k in range(self.max_cycles + 1):
            frames = self.arm.frames(q)
            error, distance, angle = targets.error(frames, LENGTH)
            size = np.sqrt(np.sum(error * error, axis=0))
            solved = (distance <= self.tolerance[0]) & (angle <= self.tolerance[1])
            best.keep(q, np.where(solved, -1.0, size), distance, angle)
            stop = solved.copy()
            if k == self.max_cycles:
                stop[:] = True
            elif k and k % self.window == 0:
                least = np.maximum(best.figures[0], 0.0)
                stop |= checked - least < self.progress * np.minimum(checked, STEP)
                checked = least
            if stop.any():
                if shared:
                    np.minimum.at(first, owners[solved], lanes[solved])
                    stop |= lanes > first[owners]
                ends.put(lanes[stop], best, stop, k)
                keep = np.flatnonzero(~stop)
                if not keep.size:
                    break
                lanes, owners, checked = lanes[keep], owners[keep], checked[keep]
                extra = extra[keep]
                q, error, size = q.take(keep, axis=1), error.take(keep, axis=1), size[keep]
                targets, frames, best = targets.take(keep), frames.select(keep), best.take(keep)
            J = frames.jacobian(targets.length(LENGTH))
            if not self.careful:
                q = self._step(q, J, error, size)
                continue
            worse = size > best.figures[0]
            raised = np.clip(EXTRA_FACTORS[0] * extra, *EXTRA_DAMPING)
            extra = np.where(worse, raised, EXTRA_FACTORS[1] * extra)
            q = np.where(worse, best.q, self._step(q, J, error, size, extra))
        return ends

    def _step(
        self, q: Array, J: Array, error: Array, size: Array, extra: Array | float = 0.0
    ) -> Array:
        error = error * (STEP / np.maximum(size, STEP))
        damping = DAMPING[0] + DAMPING[1] * np.minimum(size, STEP) + extra
        if self.limits is None:
            return q + batch_step(J, error, damping)
        lower, upper = (limit[:, None] for limit in self.limits)
        at_lower, at_upper = q <= lower + AT_LIMIT, q >= upper - AT_LIMIT
        weights = None
        if at_lower.any() or at_upper.any():
            push = np.sum(J * error[:, None], axis=0)
            blocked = (at_lower & (push < 0.0)) | (at_upper & (push > 0.0))
            weights = np.where(blocked, BLOCKED, 1.0)
        q = q + batch_step(J, error, damping, weights=weights)
        return np.clip(q, lower, upper, out=q)


@dataclass
class _Best:
    """The best posture of each lane so far."""

    q: Array
    figures: Array
    """(3,N): size of the error [m], −1 if solved; position error [m]; rotation error [rad]."""

    def keep(self, q: Array, size: Array, distance: Array, angle: Array) -> None:
        better = size < self.figures[0]
        np.copyto(self.q, q, where=better)
        for figure, value in zip(self.figures, (size, distance, angle)):
            np.copyto(figure, value, where=better)

    def take(self, lanes: Lanes) -> "_Best":
        return _Best(self.q.take(lanes, axis=1), self.figures.take(lanes, axis=1))


@dataclass
class Ends:
    """The best posture of each start."""

    q: Array
    """(n,N) [rad or m]."""
    size: Array
    """(N,): error with rotations scaled [m], −1 if solved."""
    errors: Array
    """(2,N): position [m], rotation [rad]."""
    cycles: NDArray[np.int_]
    """(N,): when it ended."""

    def put(self, lanes: Lanes, best: _Best, stop: Bools, cycle: int) -> None:
        """Write the ended lanes."""
        self.q[:, lanes] = best.q[:, stop]
        self.size[lanes] = best.figures[0, stop]
        self.errors[:, lanes] = best.figures[1:, stop]
        self.cycles[lanes] = cycle

    def best_of(self, count: int) -> "Ends":
        """The best of each `count` successive starts, the first of equals, and the cycles up to it."""
        rows = self.size.reshape(-1, count)
        best = np.argmin(rows, axis=1)
        chosen = np.arange(len(rows)) * count + best
        last = np.where(self.size[chosen] < 0.0, best, count - 1)
        spent = np.cumsum(self.cycles.reshape(-1, count), axis=1)
        cycles = spent[np.arange(len(rows)), last]
        return Ends(self.q[:, chosen], self.size[chosen], self.errors[:, chosen], cycles)


def batch_step(
    J: Array, error: Array, damping: Array, *, weights: Array | None = None, floor: float = FLOOR
) -> Array:
    """Joint steps dθ = C^-½ x, where x minimises |S x − R^-½ e|² + damping |x|².

    S = R^-½ J C^-½ is the Jacobian scaled by the fuzzy mapping's row sums R and column sums C, so
    its norm is at most 1 and the damping is dimensionless. Conjugate gradients of m steps reach the
    same minimum (`laws.conjugate_gradients`); here the m x m normal equations
    (S Sᵀ + damping) y = R^-½ e are solved directly, in three quarters of the time.

    Args:
        J: Jacobians (m,n,N), rows in m.
        error: task errors (m,N) [m].
        damping: (N,) or one number, the square of λ [-].
        weights: mobilities of the joints (n,N) in [0,1], which multiply 1/c_j; None: all 1.
        floor: r_i becomes sqrt(r_i² + (floor max r)²), which is smooth where a row vanishes; c_j too.

    Returns:
        (n,N) [rad or m].
    """
    A = np.abs(J)
    R = _raised(A.sum(1), floor)
    C = 1.0 / _raised(A.sum(0), floor)
    if weights is not None:
        C *= weights
    JC = J * C
    m = len(J)
    M = np.zeros((m, m, J.shape[-1]))
    for i in range(m):
        np.sum(JC[i] * J[: i + 1], axis=1, out=M[i, : i + 1])
        M[i, i] += damping * R[i]
    y = solve_positive_definite(M, error.copy())
    return np.sum(JC * y[:, None], axis=0)


def solve_positive_definite(M: Array, b: Array) -> Array:
    """Solve M y = b for N symmetric positive definite M by L D Lᵀ.

    Args:
        M: (m,m,N), overwritten; only the lower triangles are read.
        b: (m,N), overwritten.

    Returns:
        y (m,N), in the place of b.
    """
    m = len(b)
    inverse = np.empty_like(b)
    for k in range(m):
        np.divide(1.0, M[k, k], out=inverse[k])
        column = M[k + 1 :, k]
        scaled = column * inverse[k]
        b[k + 1 :] -= scaled * b[k]
        for i in range(m - k - 1):
            M[k + 1 + i, k + 1 : k + 2 + i] -= scaled[i] * column[: i + 1]
        M[k + 1 :, k] = scaled
    b *= inverse
    for k in range(m - 2, -1, -1):
        b[k] -= np.sum(M[k + 1 :, k] * b[k + 1 :], axis=0)
    return b


def _raised(sums: Array, floor: float) -> Array:
    """sqrt(sums² + (floor max sums)²), above zero where all are zero."""
    least = floor * sums.max(axis=0)
    squares = sums * sums
    squares += least * least + np.finfo(float).tiny
    return np.sqrt(squares)
