"""Targets of many solutions at once, as a structure of arrays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.frames import Frames

TASKS = ("position", "pose")
SHAPES = {"position": (3,), "pose": (4, 4)}
ORTHONORMAL = 1e-5
"""How far a rotation matrix may be from orthonormal, by its elements [-]."""
FARTHEST = 1e100
"""Coordinates beyond this are as good as infinite: their squares would be [m]."""
NEARLY_HALF_TURN = -0.99
"""Below this cosine (172°) the sine no longer gives a precise axis."""
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
    def from_array(cls, targets: Array, scale: float = 1.0) -> "BatchTargets":
        """From positions (N,3) [m] or poses (N,4,4); lengths are divided by the scale [m]."""
        if targets.ndim == 2:
            return cls(np.ascontiguousarray(targets.T) * (1.0 / scale), None)
        rotation = np.ascontiguousarray(targets[:, :3, :3].transpose(2, 1, 0))
        return cls(np.ascontiguousarray(targets[:, :3, 3].T) * (1.0 / scale), rotation)

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
    array = shaped_targets(targets, task)
    return array, are_valid(array)


def shaped_targets(targets: ArrayLike, task: str) -> Array:
    """The targets as an array, (N,3) or (N,4,4).

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
    return array


def are_valid(targets: Array) -> Bools:
    """Which targets (N,3) or (N,4,4) are finite, and poses (N,)."""
    valid = np.empty(len(targets), dtype=bool)
    for start in range(0, len(targets), ROWS):
        rows = slice(start, start + ROWS)
        valid[rows] = (_are_finite if targets.ndim == 2 else _are_poses)(targets[rows])
    return valid


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


def rotation_error(rotation: Array, target: Array) -> tuple[Array, Array]:
    """The turns that carry frames to their targets, correct through 180°.

    Args:
        rotation: (3,3,N), rotation[k] is axis k of the frame in the base frame.
        target: (3,3,N), the same of the target.

    Returns:
        Rotation vectors (3,N) [rad] in the base frame, and their lengths (N,) in [0, π]. At 180° one
        of the two opposite axes.
    """
    sine_axis = np.empty(rotation.shape[1:])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        np.sum(
            rotation[:, j] * target[:, k] - rotation[:, k] * target[:, j], axis=0, out=sine_axis[i]
        )
    sine_axis *= 0.5
    sine = np.sqrt(np.sum(sine_axis * sine_axis, axis=0))
    cosine = 0.5 * (np.sum(np.sum(rotation * target, axis=0), axis=0) - 1.0)
    angle = np.arctan2(sine, cosine)
    error = sine_axis * np.divide(angle, sine, out=np.ones_like(sine), where=sine > 1e-9)
    lanes = np.flatnonzero(cosine < NEARLY_HALF_TURN)
    if lanes.size:
        axis = _axis(rotation[..., lanes], target[..., lanes], cosine[lanes], sine_axis[:, lanes])
        error[:, lanes] = angle[lanes] * axis
    return error, angle


def _axis(rotation: Array, target: Array, cosine: Array, sine_axis: Array) -> Array:
    """Unit axes (3,N) of turns near 180°, from E + Eᵀ = 2 cos θ I + 2 (1 − cos θ) a aᵀ."""
    E = np.sum(target[:, :, None] * rotation[:, None], axis=0)
    outer = 0.5 * (E + E.swapaxes(0, 1)) - cosine * np.eye(3)[..., None]
    largest = np.argmax(np.einsum("iin->in", outer), axis=0)
    axis = outer[:, largest, np.arange(largest.size)]
    axis = axis / np.sqrt(np.sum(axis * axis, axis=0))
    return np.where(np.sum(axis * sine_axis, axis=0) < 0.0, -axis, axis)
