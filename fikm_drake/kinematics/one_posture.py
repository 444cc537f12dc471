"""Tool frame and Jacobian of one posture, in numpy: a third of what many at once cost for one."""

import numpy as np

from fikm_drake.arrays import Array, Bools

_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


class OnePosture:
    """From the joint positions of one posture to its frames.

    The pose of what a joint moves in what the joint before it moves is K + u U + v V, with constant
    matrices and u, v = cos q, sin q of a joint that turns, q, 0 of one that slides.

    Args:
        before: (n,4,4), pose of each joint's frame in the frame that the joint before it moves.
        tool: (4,4), of the tool in the frame that the last joint moves.
        revolute: (n,), which joints turn.
    """

    def __init__(self, before: Array, tool: Array, revolute: Bools) -> None:
        self._tool, self._turns = tool, revolute
        self._slides = None if revolute.all() else np.flatnonzero(~revolute)
        self._constant = before.copy()
        self._constant[revolute, :, :2] = 0.0
        self._u, self._v = np.zeros_like(before), np.zeros_like(before)
        self._u[revolute, :, :2] = before[revolute, :, :2]
        self._v[revolute, :, 0] = before[revolute, :, 1]
        self._v[revolute, :, 1] = -before[revolute, :, 0]
        self._u[~revolute, :, 3] = before[~revolute, :, 2]

    def poses(self, q: Array) -> tuple[Array, Array]:
        """Poses (n,4,4) of what the joints move, and of the tool (4,4), at `q` (n,)."""
        u, v = np.cos(q), np.sin(q)
        if self._slides is not None:
            u[self._slides], v[self._slides] = q[self._slides], 0.0
        X = self._u * u[:, None, None]
        X += self._v * v[:, None, None]
        X += self._constant
        for i in range(1, len(X)):
            X[i] = X[i - 1].dot(X[i])
        return X, X[-1].dot(self._tool)

    def jacobian(self, poses: Array, tool: Array, length: float | None = 1.0) -> Array:
        """Rows [ω; v] (6,n) of the tool point; the rotation rows are multiplied by `length` [m].

        With `length` None: rows v (3,n).
        """
        axes = poses[:, :3, 2]
        levers = tool[:3, 3] - poses[:, :3, 3]
        linear = axes[:, _NEXT] * levers[:, _LAST]
        linear -= axes[:, _LAST] * levers[:, _NEXT]
        if self._slides is not None:
            linear[self._slides] = axes[self._slides]
        if length is None:
            return linear.T
        J = np.empty((6, len(axes)))
        J[3:] = linear.T
        np.multiply(axes.T, length, out=J[:3])
        if self._slides is not None:
            J[:3, self._slides] = 0.0
        return J
