"""Tool frame and Jacobian of one posture, in numpy: a fraction of what many at once cost for one."""

import numpy as np

from fikm_drake.arrays import Array, Bools

_ROWS = np.eye(4)[[0, 1, 2, 0, 1]]
"""Rows x, y, z, x, y: of five rows in this order any cross product is two products of slices."""


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
        self.tool = np.array(tool)
        self.slides = np.flatnonzero(~revolute)
        terms = np.zeros((3, *before.shape))
        K, U, V = terms
        K[:] = before
        K[revolute, :, :2] = 0.0
        U[revolute, :, :2] = before[revolute, :, :2]
        V[revolute, :, 0] = before[revolute, :, 1]
        V[revolute, :, 1] = -before[revolute, :, 0]
        U[~revolute, :, 3] = before[~revolute, :, 2]
        self.terms = np.ascontiguousarray(terms.reshape(3, len(before), 16).swapaxes(0, 1))

    def pose(self, q: Array) -> Array:
        """Pose (4,4) of the tool at `q` (n,)."""
        posture = PostureBuffers(self)
        posture.move(q)
        X = np.eye(4)
        X[:3] = posture.tool[:3]
        return X

    def jacobian(self, q: Array, length: float | None = 1.0) -> Array:
        """Rows [ω; v] (6,n) of the tool point; the rotation rows are multiplied by `length` [m].

        With `length` None: rows v (3,n).
        """
        posture = PostureBuffers(self, length)
        posture.move(q)
        return np.ascontiguousarray(posture.jacobian())


class PostureBuffers:
    """Kinematics of one posture after the other, into arrays that are made once. Not for several threads.

    Args:
        chain: the chain's constants.
        length: multiplies the Jacobian's rows of rotation [m]; None: rows v only.
    """

    def __init__(self, chain: OnePosture, length: float | None = None) -> None:
        n = len(chain.terms)
        self._chain, self._length, self._slides = chain, length, chain.slides.size > 0
        self._factors = np.ones((n, 1, 3))
        self._u, self._v = self._factors[:, 0, 1], self._factors[:, 0, 2]
        self._moves = np.empty((n, 1, 16))
        poses = np.empty((n + 1, 5, 4))
        moves, chained = list(self._moves.reshape(n, 4, 4)), list(poses)
        self._products = list(zip([_ROWS, *chained], [*moves, chain.tool], chained))
        self.tool: Array = poses[-1]
        """(5,4): rows x, y, z, x, y of the tool's pose."""
        self._point, self._points = poses[-1, :, 3], poses[:n, :, 3]
        axes, self._levers, self._minus = poses[:n, :, 2], np.empty((n, 5)), np.empty((n, 3))
        self.columns: Array = np.empty((n, 3 if length is None else 6))
        """(n,m): the Jacobian's columns."""
        self._linear, self._axes = self.columns[:, -3:], axes[:, :3]
        self._plus = axes[:, 1:4], self._levers[:, 2:]
        self._less = axes[:, 2:], self._levers[:, 1:4]

    def move(self, q: Array) -> None:
        """Go to `q` (n,)."""
        np.cos(q, out=self._u)
        np.sin(q, out=self._v)
        if self._slides:
            which = self._chain.slides
            self._u[which], self._v[which] = q[which], 0.0
        np.matmul(self._factors, self._chain.terms, out=self._moves)
        for before, move, after in self._products:
            np.dot(before, move, after)

    def jacobian(self) -> Array:
        """The Jacobian (m,n) where it is: a view of `columns`."""
        np.subtract(self._point, self._points, out=self._levers)
        np.multiply(*self._plus, out=self._linear)
        np.multiply(*self._less, out=self._minus)
        np.subtract(self._linear, self._minus, out=self._linear)
        if self._length is not None:
            np.multiply(self._axes, self._length, out=self.columns[:, :3])
        if self._slides:
            which = self._chain.slides
            self.columns[which] = 0.0
            self._linear[which] = self._axes[which]
        return self.columns.T
