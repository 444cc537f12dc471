"""A quick descent of one start in numpy: what `Descent` does, in a tenth of its time for a single lane."""

from math import atan2, sqrt
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.one_posture import PostureBuffers
from fikm_drake.solvers.batch.batch_targets import (
    NEARLY_HALF_TURN,
    BatchTargets,
    rotation_error,
)
from fikm_drake.solvers.batch.descent import (
    AT_LIMIT,
    BLOCKED,
    DAMPING,
    FLOOR,
    LENGTH,
    STEP,
    Descent,
)

TINY = float(np.finfo(float).tiny)


class End(NamedTuple):
    """How a start ended; as in `Ends`."""

    q: Array
    size: float
    distance: float
    angle: float
    cycles: int


class DescentOfOne:
    """`Descent.run` for one target, start after start, in arrays that are made once.

    Args:
        descent: how; not a careful one.
        targets: one target.
    """

    def __init__(self, descent: Descent, targets: BatchTargets) -> None:
        rotation = None if targets.rotation is None else targets.rotation[..., 0]
        self._descent = descent
        self._posture = PostureBuffers(descent.arm.one, targets.length(LENGTH))
        self._target = _OneTarget(targets.position[:, 0], rotation, self._posture.tool)
        self._step = _Step(self._posture.columns)
        self._limits = _Limits(*descent.limits) if descent.limits is not None else None

    def run(self, q: Array) -> End:
        """The end of a start (n,)."""
        descent, posture, target, limits = self._descent, self._posture, self._target, self._limits
        least, checked, best, errors = np.inf, np.inf, q, (0.0, 0.0)
        for k in range(descent.max_cycles + 1):
            posture.move(q)
            error, size, distance, angle = target.error()
            solved = distance <= descent.tolerance[0] and angle <= descent.tolerance[1]
            if solved or size < least:
                least, best, errors = -1.0 if solved else size, q, (distance, angle)
            if solved or k == descent.max_cycles:
                break
            if k and k % descent.window == 0:
                if checked - least < descent.progress * min(checked, STEP):
                    break
                checked = least
            J = posture.jacobian()
            near = min(size, STEP)
            if size > STEP:
                error *= STEP / size
            weights = limits.weights(q, J, error) if limits else None
            q = q + self._step(error, DAMPING[0] + DAMPING[1] * near, weights)
            if limits:
                limits.hold(q)
        return End(best, least, *errors, k)


class _OneTarget:
    """A target's position (3,) and, for a pose, its rotation (3,3) with the axes as rows.

    `tool` (≥3,4) is where the tool's pose will stand.
    """

    def __init__(self, position: Array, rotation: Array | None, tool: Array) -> None:
        self._position, self._axes = position, rotation
        self._columns = None if rotation is None else np.ascontiguousarray(rotation.T)
        self._point, self._tool_axes = tool[:3, 3], tool[:3, :3].T

    def error(self) -> tuple[Array, float, float, float]:
        """Task error (m,), its size, the distance and the angle of the tool as it is."""
        offset = self._position - self._point
        if self._columns is None or self._axes is None:
            distance = sqrt(float(offset.dot(offset)))
            return offset, distance, distance, 0.0
        # Of R_target Rᵀ, which turns the tool into the target.
        (a, b, c), (d, e, f), (g, h, i) = self._columns.dot(self._tool_axes).tolist()
        x, y, z = 0.5 * (h - f), 0.5 * (c - g), 0.5 * (d - b)
        sine, cosine = sqrt(x * x + y * y + z * z), 0.5 * (a + e + i - 1.0)
        angle = atan2(sine, cosine)
        if cosine < NEARLY_HALF_TURN:
            axes = np.ascontiguousarray(self._tool_axes)[..., None]
            x, y, z = rotation_error(axes, self._axes[..., None])[0][:, 0].tolist()
            scale = LENGTH
        else:
            scale = LENGTH * (angle / sine if sine > 1e-9 else 1.0)
        x, y, z = scale * x, scale * y, scale * z
        u, v, w = offset.tolist()
        square = u * u + v * v + w * w
        size = sqrt(x * x + y * y + z * z + square)
        return np.array([x, y, z, u, v, w]), size, sqrt(square), angle


class _Step:
    """`batch_step` for one Jacobian, whose columns (n,m) will stand in an array."""

    def __init__(self, columns: Array) -> None:
        n, m = columns.shape
        self._columns, self._m = columns, m
        self._sizes, self._scaled, self._M = np.empty((n, m)), np.empty((n, m)), np.empty((m, m))
        self._sums, self._ones = np.empty(m + n), np.ones(max(m, n))
        self._rows, self._joints = self._sums[:m], self._sums[m:]
        self._diagonal = self._M.reshape(-1)[:: m + 1]
        self._damped, self._step = np.empty(m), np.empty(n)

    def __call__(self, error: Array, damping: float, weights: Array | None) -> Array:
        """dθ (n,), valid until the next call."""
        m, sums = self._m, self._sums
        np.abs(self._columns, out=self._sizes)
        np.dot(self._ones[: len(self._joints)], self._sizes, self._rows)
        np.dot(self._sizes, self._ones[:m], self._joints)
        np.multiply(sums, sums, out=sums)
        squares = sums.tolist()
        self._rows += FLOOR * FLOOR * max(squares[:m]) + TINY
        self._joints += FLOOR * FLOOR * max(squares[m:]) + TINY
        np.sqrt(sums, out=sums)
        if weights is not None:
            self._joints /= weights
        np.divide(self._columns, self._joints[:, None], out=self._scaled)
        np.dot(self._scaled.T, self._columns, self._M)
        self._diagonal += np.multiply(self._rows, damping, out=self._damped)
        return np.dot(self._scaled, np.linalg.solve(self._M, error), self._step)


class _Limits:
    """Joint limits (n,) and (n,)."""

    def __init__(self, lower: Array, upper: Array) -> None:
        self._lower, self._upper = lower, upper
        self._near = lower + AT_LIMIT, upper - AT_LIMIT
        self._at = np.empty((2, len(lower)), dtype=bool)

    def weights(self, q: Array, J: Array, error: Array) -> Array | None:
        """Mobilities (n,), or None if no joint is at a limit."""
        at_lower, at_upper = self._at
        np.less_equal(q, self._near[0], out=at_lower)
        np.greater_equal(q, self._near[1], out=at_upper)
        if not np.count_nonzero(self._at):
            return None
        push = error.dot(J)
        blocked = (at_lower & (push < 0.0)) | (at_upper & (push > 0.0))
        return np.where(blocked, BLOCKED, 1.0)

    def hold(self, q: Array) -> None:
        """Bring `q` back inside."""
        np.maximum(q, self._lower, out=q)
        np.minimum(q, self._upper, out=q)
