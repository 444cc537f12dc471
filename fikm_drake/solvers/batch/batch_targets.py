"""Targets of many solutions at once, as a structure of arrays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.frames import Frames
from fikm_drake.solvers.batch.rotation_error import rotation_error

TASKS = ("position", "pose")
SHAPES = {"position": (3,), "pose": (4, 4)}
ORTHONORMAL = 1e-5
"""How far a rotation matrix may be from orthonormal, by its elements [-]."""
FARTHEST = 1e100
"""Coordinates beyond this are as good as infinite: their squares would be [m]."""
ROWS = 65536
"""Targets that are looked at together, so that a million of them take little memory."""


@dataclass(frozen=True)
class BatchTargets:
    """Desired tool points and, for poses, orientations in the base frame."""

    position: Array
    """(3,N) [m]."""
    rotation: Array | None
    """(3,3,N), rotation[k] is axis k of the tool frame; None: any."""

    @classmethod
    def from_array(cls, targets: Array) -> "BatchTargets":
        """Of positions (N,3) [m] or poses (N,4,4)."""
        if targets.ndim == 2:
            return cls(np.ascontiguousarray(targets.T), None)
        rotation = np.ascontiguousarray(targets[:, :3, :3].transpose(2, 1, 0))
        return cls(np.ascontiguousarray(targets[:, :3, 3].T), rotation)

    def take(self, lanes: NDArray[np.intp]) -> "BatchTargets":
        """Some of the targets, in this order; the same one may come more than once."""
        rotation = None if self.rotation is None else self.rotation.take(lanes, axis=-1)
        return BatchTargets(self.position.take(lanes, axis=-1), rotation)

    def length(self, length: float) -> float | None:
        """The characteristic length where orientations count, else None."""
        return None if self.rotation is None else length

    def error(self, frames: Frames, length: float) -> tuple[Array, Array, Array]:
        """Task errors of postures, one a target.

        Args:
            frames: of the N postures.
            length: the characteristic length that multiplies rotations [m].

        Returns:
            (m,N) [m], rows of the Jacobian; position errors (N,) [m]; rotation errors (N,) [rad],
            zeros for positions.
        """
        offset = self.position - frames.position
        distance = np.sqrt(np.sum(offset * offset, axis=0))
        if self.rotation is None:
            return offset, distance, np.zeros_like(distance)
        turn, angle = rotation_error(frames.rotation, self.rotation)
        turn *= length
        return np.concatenate([turn, offset]), distance, angle


def checked_targets(targets: ArrayLike, task: str) -> tuple[Array, Bools]:
    """The targets as an array, (N,3) or (N,4,4), and which of them are valid (N,).

    Raises:
        ValueError: an unknown task, or a shape that does not fit it.
    """
    if task not in TASKS:
        raise ValueError(f"task must be one of {TASKS}, got {task!r}")
    array = np.asarray(targets, dtype=float)
    if array.size == 0 and array.shape[:1] in ((), (0,)):
        array = np.empty((0, *SHAPES[task]))
    if array.shape[1:] != SHAPES[task]:
        numbers = ", ".join(["N", *map(str, SHAPES[task])])
        raise ValueError(f"targets of task {task!r} must have shape ({numbers}), got {array.shape}")
    valid = np.empty(len(array), dtype=bool)
    for start in range(0, len(array), ROWS):
        rows = slice(start, start + ROWS)
        valid[rows] = _are_poses(array[rows]) if task == "pose" else _are_finite(array[rows])
    return array, valid


def _are_finite(targets: Array) -> Bools:
    # NaN compares false.
    near = np.abs(targets) < FARTHEST
    return np.logical_and.reduce(near, axis=tuple(range(1, targets.ndim)))


def _are_poses(X: Array) -> Bools:
    finite = _are_finite(X)
    X = np.where(finite[:, None, None], X, np.eye(4))
    R = X[:, :3, :3]
    products = np.abs(R @ R.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2))
    last_row = np.abs(X[:, 3] - [0.0, 0.0, 0.0, 1.0]).max(axis=1)
    right_handed = np.linalg.det(R) > 0.0
    return finite & right_handed & (products <= ORTHONORMAL) & (last_row <= ORTHONORMAL)
