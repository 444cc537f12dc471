"""Targets of a tool as poses, and how far postures are from them."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.batch.batch_targets import FARTHEST, checked_targets, rotation_error


def checked_points(points: ArrayLike, task: Task) -> tuple[Array, Bools]:
    """The points as an array, and which of them are valid (N,).

    Args:
        points: (N,m), the coordinates that the task counts [m]; poses (N,4,4) where it turns the tool.
        task: what they fix.

    Raises:
        ValueError: they have another shape.
    """
    array = np.asarray(points, dtype=float)
    if task.turns:
        return checked_targets(array, "pose")
    size = len(task.coordinates)
    if array.ndim != 2 or array.shape[1] != size:
        raise ValueError(f"points must have shape (N, {size}), got {array.shape}")
    return array, (np.abs(array) < FARTHEST).all(axis=1)


def as_poses(points: Array, task: Task) -> Array:
    """Valid points as poses (N,4,4) with true rotations; what the task does not count is zero."""
    poses = np.tile(np.eye(4), (len(points), 1, 1))
    if task.turns:
        left, _, right = np.linalg.svd(points[:, :3, :3])
        poses[:, :3, :3] = left @ right
        poses[:, :3, 3] = points[:, :3, 3]
    else:
        poses[:, task.coordinates, 3] = points
    return poses


def tool_errors(
    arm: DhArm | SerialChain, task: Task, q: Array, poses: Array
) -> tuple[Array, Array]:
    """Distances (N,) [m] and turns (N,) [rad] from the tool to poses (N,4,4), by forward kinematics.

    Only what the task counts; zeros where that is no position, or no orientation.
    """
    tool = arm.forward_kinematics(q)
    away = (tool - poses)[:, task.coordinates, 3]
    distance = np.sqrt(np.sum(away * away, axis=1))
    if not task.turns:
        return distance, np.zeros(len(q))
    axes = (X[:, :3, :3].transpose(2, 1, 0) for X in (tool, poses))
    return distance, rotation_error(*axes)[1]
