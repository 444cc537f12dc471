"""Tool frames, joint axes and Jacobians of many postures at once, as a structure of arrays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools

ROUNDING = 1e-15
"""Sines, cosines and lengths below this are the rounding errors of right angles and of zero."""


@dataclass(frozen=True)
class Frames:
    """Tool frames and joint axes of N postures, in the base frame."""

    rotation: Array
    """(3,3,N): rotation[k] holds axis k of the tool frame, x, y, z."""
    position: Array
    """(3,N): the tool point [m]."""
    axes: Array
    """(3,n,N): unit vectors of the joints' axes."""
    points: Array
    """(3,n,N): a point on each axis [m]."""
    revolute: Bools
    """(n,): which joints turn; the others are prismatic."""

    def select(self, lanes: NDArray[np.intp]) -> "Frames":
        """The frames of some of the postures."""
        return Frames(
            self.rotation.take(lanes, axis=-1),
            self.position.take(lanes, axis=-1),
            self.axes.take(lanes, axis=-1),
            self.points.take(lanes, axis=-1),
            self.revolute,
        )

    def jacobian(self, length: float | None = 1.0) -> Array:
        """Jacobians of the tool point in the base frame: the only one that this project has.

        Column j is [z_j; z_j × (p_tool − p_j)] for a revolute joint and [0; z_j] for a prismatic one.
        Equations 6 and 7 of Xu & Nechyba 1993 as printed give the velocity of another point.

        Args:
            length: the rotation rows are multiplied by this [m]; None leaves them out.

        Returns:
            (6,n,N), rows [ω; v], or (3,n,N), rows v.
        """
        axes = self.axes
        levers = self.position[:, None] - self.points
        top = 0 if length is None else 3
        J = np.empty((top + 3, *axes.shape[1:]))
        if length is not None:
            np.multiply(axes, length, out=J[:3])
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            np.multiply(axes[i], levers[j], out=J[top + k])
            J[top + k] -= axes[j] * levers[i]
        if not self.revolute.all():
            J[top:, ~self.revolute] = axes[:, ~self.revolute]
            J[:top, ~self.revolute] = 0.0
        return J


class FramesOfPostures:
    """From joint positions to `Frames`, for a chain of joints that each act on their own z.

    Whatever lies between two joints is Rz(φ) Rx(α) Rz(θ) with an offset: φ adds to the angle of the
    joint before, θ to that of the joint after. So each joint costs two turns in a plane instead of a
    product of matrices, and right angles cost nothing.

    Args:
        before: (n,4,4), pose of each joint's frame in the frame that the joint before it moves.
        tool: (4,4), of the tool in the frame that the last joint moves.
        revolute: (n,), which joints turn.
    """

    def __init__(self, before: Array, tool: Array, revolute: Bools) -> None:
        n = len(before)
        self.revolute = revolute
        self._elements = [_elements(before[i]) for i in range(n)]
        turns = np.array([element.theta for element in self._elements])
        self._first = before[0][:3, :3] @ _rotation_z(-turns[0])
        self._start = before[0][:3, 3:]
        turns[:-1] += [element.phi for element in self._elements[1:]]
        self._offset = turns
        self._tool = np.where(np.abs(tool) < ROUNDING, 0.0, tool)
        self._tool_turns = not np.array_equal(self._tool[:3, :3], np.eye(3))

    def packed(self) -> Array:
        """The chain as the native kernel takes it, 12 + 7 n + 12 numbers; see `native/lanes.h`."""
        numbers = [*self._first.T.ravel(), *self._start.ravel()]
        for i, element in enumerate(self._elements):
            x, cos, sin, y, z = 0.0, 1.0, 0.0, 0.0, 0.0
            if i:
                x, cos, sin, y, z = element.x, element.cos, element.sin, element.y, element.z
            numbers += [x, y, z, cos, sin, self._offset[i], float(self.revolute[i])]
        return np.array([*numbers, *self._tool[:3, :3].T.ravel(), *self._tool[:3, 3]])

    def __call__(self, q: Array) -> Frames:
        """Frames of the tool and of the joints.

        Args:
            q: joint positions (n,N) [rad or m].
        """
        n, count = q.shape
        angles = np.where(self.revolute[:, None], q, 0.0) + self._offset[:, None]
        cosines, sines = np.cos(angles), np.sin(angles)
        axes, points = np.empty((3, n, count)), np.empty((3, n, count))
        # Joint 1: its axis stands still, and its x and y before it turns are constants.
        first = self._first
        x = first[:, :1] * cosines[0] + first[:, 1:2] * sines[0]
        y = first[:, 1:2] * cosines[0] - first[:, :1] * sines[0]
        z = np.broadcast_to(first[:, 2:], (3, count))
        p = np.broadcast_to(self._start, (3, count))
        for i in range(n):
            if i:
                element = self._elements[i]
                if element.x:
                    p = p + element.x * x
                y, z = _turned(y, z, element.cos, element.sin)
                if element.y:
                    p = p + element.y * y
                if element.z:
                    p = p + element.z * z
                x, y = x * cosines[i] + y * sines[i], y * cosines[i] - x * sines[i]
            if not self.revolute[i]:
                p = p + q[i] * z
            axes[:, i], points[:, i] = z, p
        rotation = np.empty((3, 3, count))
        rotation[0], rotation[1], rotation[2] = x, y, z
        for k in range(3):
            if self._tool[k, 3]:
                p = p + self._tool[k, 3] * rotation[k]
        if self._tool_turns:
            turned = np.empty_like(rotation)
            for k in range(3):
                turned[k] = sum(
                    self._tool[i, k] * rotation[i] for i in range(3) if self._tool[i, k]
                )
            rotation = turned
        return Frames(rotation, np.ascontiguousarray(p), axes, points, self.revolute)


@dataclass(frozen=True)
class _Elements:
    """A fixed pose as Rz(φ) Rx(α), then a translation, then Rz(θ)."""

    phi: float
    cos: float
    sin: float
    x: float
    y: float
    z: float
    theta: float


def _elements(pose: Array) -> _Elements:
    """Elements of a pose (4,4); φ and y are exactly zero for a Denavit-Hartenberg row."""
    R, t = pose[:3, :3], pose[:3, 3]
    phi = 0.0
    if abs(R[0, 2]) > ROUNDING:
        # In [−π/2, π/2]; however small sin α is, the error of the product stays that of R.
        phi = float(np.arctan(-R[0, 2] / R[1, 2])) if R[1, 2] else np.pi / 2.0
        R, t = _rotation_z(-phi) @ R, _rotation_z(-phi) @ t
    cos, sin = R[2, 2], -R[1, 2]
    shift = (t[0], cos * t[1] + sin * t[2], cos * t[2] - sin * t[1])
    theta = float(np.arctan2(-R[0, 1], R[0, 0]))
    cos, sin, x, y, z = (0.0 if abs(e) < ROUNDING else float(e) for e in (cos, sin, *shift))
    return _Elements(phi, cos, sin, x, y, z, theta)


def _rotation_z(angle: float) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _turned(y: Array, z: Array, cos: float, sin: float) -> tuple[Array, Array]:
    """Axes y and z after a turn about x."""
    if sin == 0.0 and cos > 0.0:
        return y, z
    if cos == 0.0:
        return (z, -y) if sin > 0.0 else (-z, y)
    return cos * y + sin * z, cos * z - sin * y
