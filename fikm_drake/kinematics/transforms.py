"""Homogeneous transforms of the Denavit-Hartenberg elements, vectorised over leading axes."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array

TURN_OVER = np.diag([1.0, -1.0, -1.0, 1.0])
"""Half a turn about x: a joint between two of these acts about −z."""


def rotation_x(angle: ArrayLike) -> Array:
    """Rotation about x by `angle` (…) [rad], as (…,4,4)."""
    return _rotation(angle, 1, 2)


def rotation_z(angle: ArrayLike) -> Array:
    """Rotation about z by `angle` (…) [rad], as (…,4,4)."""
    return _rotation(angle, 0, 1)


def translation(x: ArrayLike = 0.0, y: ArrayLike = 0.0, z: ArrayLike = 0.0) -> Array:
    """Translation by (x, y, z), each (…) [m], as (…,4,4)."""
    x, y, z = np.broadcast_arrays(x, y, z)
    X = _identity(x.shape)
    X[..., 0, 3], X[..., 1, 3], X[..., 2, 3] = x, y, z
    return X


def joint_motion(turns: bool, q: ArrayLike) -> Array:
    """What a joint at `q` (…) does, as (…,4,4): a turn about z, or a shift along it."""
    return rotation_z(q) if turns else translation(z=q)


def _rotation(angle: ArrayLike, row: int, column: int) -> Array:
    angle = np.asarray(angle, dtype=float)
    X = _identity(angle.shape)
    X[..., row, row] = X[..., column, column] = np.cos(angle)
    X[..., column, row] = np.sin(angle)
    X[..., row, column] = -np.sin(angle)
    return X


def _identity(shape: tuple[int, ...]) -> Array:
    return np.broadcast_to(np.eye(4), (*shape, 4, 4)).copy()
