"""Orientation of the tool, alone or with its position."""

from typing import Any

import numpy as np
from pydrake.math import RigidTransform

from fikm_drake.arrays import LARGEST, Array
from fikm_drake.checks import check_positive_finite
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.pose_error import pose_error
from fikm_drake.kinematics.task import CHARACTERISTIC_LENGTH
from fikm_drake.kinematics.task_kinematics import PoseTargetTask, native_task_of


class OrientationTask(PoseTargetTask):
    """The tool has the orientation of a RigidTransform X_WE.

    The error is the rotation vector (angle times axis, in the world frame) that turns E to its
    target the short way, correct through 180°; times the characteristic length it is in metres.

    Args:
        arm: the joints and the tool's frame.
        characteristic_length: a turn of 1 rad counts as this much [m].

    Raises:
        ValueError: the length is not positive and finite.

    Example:
        >>> import fikm_drake as fd
        >>> fd.OrientationTask(fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("panda")))).port
        'desired_pose'
    """

    size = 3

    def __init__(self, arm: PlantArm, characteristic_length: float = CHARACTERISTIC_LENGTH) -> None:
        super().__init__(arm)
        self.characteristic_length = check_positive_finite(
            "characteristic_length", characteristic_length, "m"
        )
        # As large as the Jacobian and in its order: half the time of a column of six.
        self._row_scale = np.ones((6, arm.num_joints), order="F")
        self._row_scale[:3] = self.characteristic_length
        # A turn by φ changes the rotation matrix by 2√2 sin(φ/2), in the Frobenius norm.
        scale = [self.characteristic_length / np.sqrt(2.0)] * 3 + [1.0]
        self._scale = np.tile(scale[: self.num_coordinates // 3], 3)
        if type(self) in (OrientationTask, PoseTask):
            self.native = native_task_of(self, range(self.size), self.characteristic_length)

    def target_error(self, context: Any, target: RigidTransform) -> Array:
        """The scaled rotation vector (3,) [m]; NaN if the position is not finite, though it is free."""
        p = target.translation()
        if not p.dot(p) < LARGEST**2:
            return np.full(3, np.nan)
        return np.array(pose_error(self.arm.pose(context), target, self.characteristic_length)[:3])

    def target_jacobian(self, context: Any) -> Array:
        """Rows ω of the Jacobian, scaled (3,n)."""
        return self._spatial_jacobian(context)[:3]

    @property
    def num_coordinates(self) -> int:
        """Those of the rotation matrix and, if it counts, of the position."""
        return 9 if self.size == 3 else 12

    def target_coordinates(self, target: RigidTransform) -> Array:
        """The numbers of a pose (c,) in metres: for small turns as far apart as the error is long."""
        numbers = target.GetAsMatrix34()
        return (numbers if self.size == 6 else numbers[:, :3]).ravel() * self._scale

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's |J_ij| (m,n) over all joint positions."""
        scale = np.array([self.characteristic_length] * 3 + [1.0] * (self.size - 3))
        return self.arm.jacobian_range()[: self.size] * scale[:, None]

    def _spatial_jacobian(self, context: Any) -> Array:
        J = self.arm.spatial_jacobian(context)
        J *= self._row_scale
        return J


class PoseTask(OrientationTask):
    """The tool is at a pose X_WE: rows [ω; v], the orientation's as of `OrientationTask`.

    Args:
        arm: the joints and the tool's frame.
        characteristic_length: a turn of 1 rad counts as this much [m].

    Raises:
        ValueError: the length is not positive and finite.

    Example:
        >>> import fikm_drake as fd
        >>> fd.PoseTask(fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("panda")))).size
        6
    """

    size = 6

    def target_error(self, context: Any, target: RigidTransform) -> Array:
        """The scaled rotation vector, then desired minus actual position (6,) [m]."""
        return np.array(pose_error(self.arm.pose(context), target, self.characteristic_length))

    def target_jacobian(self, context: Any) -> Array:
        """The spatial Jacobian (6,n), rows ω scaled."""
        return self._spatial_jacobian(context)
