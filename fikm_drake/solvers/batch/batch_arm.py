"""Forward kinematics and Jacobians of many postures at once, as a structure of arrays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_arm import DhArm

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

    def select(self, lanes: NDArray[np.intp]) -> "Frames":
        """The frames of some of the postures."""
        return Frames(
            self.rotation.take(lanes, axis=-1),
            self.position.take(lanes, axis=-1),
            self.axes.take(lanes, axis=-1),
            self.points.take(lanes, axis=-1),
        )


class BatchArm:
    """A DhArm's kinematics for a last axis of postures: the same numbers at a fraction of the time.

    A modified DH joint is a turn about x, a shift along it, a turn about z and a shift along it, so
    each joint costs two turns in a plane instead of a product of matrices, and right angles cost
    nothing.
    """

    def __init__(self, arm: DhArm) -> None:
        self.num_joints = arm.num_joints
        self.revolute = np.array([joint.is_revolute for joint in arm.table.joints])
        origins = [arm.joint_origin(i) for i in range(arm.num_joints)]
        self._elements = [_elements(origin) for origin in origins]
        self._offset = np.array([_turn(origin) for origin in origins])
        self._first = origins[0]
        self._tool = np.where(np.abs(arm.tool_pose) < ROUNDING, 0.0, arm.tool_pose)
        self._tool_turns = not np.array_equal(self._tool[:3, :3], np.eye(3))

    def frames(self, q: Array) -> Frames:
        """Frames of the tool and of the joints.

        Args:
            q: joint positions (n,N) [rad or m].
        """
        n, count = q.shape
        angles = np.where(self.revolute[:, None], q, 0.0) + self._offset[:, None]
        cosines, sines = np.cos(angles), np.sin(angles)
        axes, points = np.empty((3, n, count)), np.empty((3, n, count))
        # Joint 1: its axis stands still, and its x and y before it turns are constants.
        first = self._first[:3, :3] @ _rotation_z(-self._offset[0])
        x = first[:, :1] * cosines[0] + first[:, 1:2] * sines[0]
        y = first[:, 1:2] * cosines[0] - first[:, :1] * sines[0]
        z = np.broadcast_to(first[:, 2:], (3, count))
        p = np.broadcast_to(self._first[:3, 3:], (3, count))
        for i in range(n):
            if i:
                cos, sin, a, d = self._elements[i]
                if a:
                    p = p + a * x
                y, z = _turned(y, z, cos, sin)
                if d:
                    p = p + d * z
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
        return Frames(rotation, np.ascontiguousarray(p), axes, points)

    def jacobian(self, frames: Frames, length: float | None) -> Array:
        """Jacobians of the tool point in the base frame.

        Args:
            frames: of N postures.
            length: the rotation rows are multiplied by this [m]; None leaves them out.

        Returns:
            (6,n,N), rows [ω; v], or (3,n,N), rows v.
        """
        axes = frames.axes
        levers = frames.position[:, None] - frames.points
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


def _elements(origin: Array) -> tuple[float, float, float, float]:
    """Cos α, sin α, a and d of the pose Rx(α) Tx(a) Rz(θ) Tz(d)."""
    cos, sin = origin[2, 2], -origin[1, 2]
    elements = (cos, sin, origin[0, 3], cos * origin[2, 3] - sin * origin[1, 3])
    cos, sin, a, d = (0.0 if abs(e) < ROUNDING else float(e) for e in elements)
    return cos, sin, a, d


def _turn(origin: Array) -> float:
    """θ of the pose Rx(α) Tx(a) Rz(θ) Tz(d) [rad]."""
    return float(np.arctan2(-origin[0, 1], origin[0, 0]))


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
