"""When a pose counts as reached."""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from fikm_drake.arrays import Array

TOLERANCE = (1e-3, 0.01)
"""Tolerance of position [m] and rotation [rad]."""


def as_pose(T: Array) -> RigidTransform:
    """A homogeneous matrix (4,4) as Drake's pose."""
    return RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])


def is_near(X: RigidTransform, Y: RigidTransform) -> bool:
    """True if two poses differ by less than `TOLERANCE`."""
    distance = np.linalg.norm(X.translation() - Y.translation())
    turn = (X.rotation().inverse() @ Y.rotation()).ToAngleAxis().angle()
    return bool(distance < TOLERANCE[0] and turn < TOLERANCE[1])
