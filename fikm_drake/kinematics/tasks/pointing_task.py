"""Position of the tool, with one of its axes along a direction: drilling, welding, pointing."""

from collections.abc import Sequence
from math import atan2, hypot, sqrt
from typing import Any

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finites, check_positive_finite
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task import CHARACTERISTIC_LENGTH
from fikm_drake.kinematics.task_kinematics import PlantTask

LEAST_SQUARE = 1e-24
"""A direction shorter than the root of this points nowhere."""


class PointingTask(PlantTask):
    """The tool's origin is at a position and one of its axes points along a direction; it may spin.

    The target is a vector (6): the position [m], then the direction (any length), both in the world
    frame. The error has five rows: the turn that brings the axis to the direction the short way, in
    the two directions of E across the axis, times the characteristic length; then desired minus
    actual position in the world frame [m].

    Args:
        arm: the joints and the tool's frame E.
        axis: the axis in E, of any length but zero.
        characteristic_length: a turn of 1 rad counts as this much [m].

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> drill = fd.PointingTask(fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("iiwa14"))))
        >>> down = np.array([0.5, 0.0, 0.3, 0.0, 0.0, -1.0])
        >>> drill.error(down, np.zeros(7)).round(2).tolist()
        [-0.94, 0.0, 0.5, 0.0, -1.01]
    """

    size, port, target_size = 5, "desired_pointing", 6

    def __init__(
        self,
        arm: PlantArm,
        axis: Sequence[float] = (0.0, 0.0, 1.0),
        characteristic_length: float = CHARACTERISTIC_LENGTH,
    ) -> None:
        super().__init__(arm)
        self.characteristic_length = check_positive_finite(
            "characteristic_length", characteristic_length, "m"
        )
        direction = np.array(check_finites("axis", axis, 3, "-"))
        if not direction.dot(direction) > LEAST_SQUARE:
            raise ValueError(f"axis must not be zero, got {axis!r}")
        direction /= np.linalg.norm(direction)
        # Across the axis: from the unit vector that is least along it.
        first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
        first /= np.linalg.norm(first)
        self._basis = np.stack([first, np.cross(direction, first), direction], axis=1)

    def target_error(self, context: Any, target: Array) -> Array:
        """Turn across the axis, then desired minus actual position (5,) [m]."""
        X_WE = self.arm.pose(context)
        if not self.is_finite(target):
            return np.full(5, np.nan)
        direction = target[3:]
        # The direction along the basis (x, y, axis) of E: the axis turns by the angle toward (x, y).
        x, y, along = ((X_WE.rotation().matrix() @ self._basis).T @ direction).tolist()
        across = hypot(x, y)
        turn = self.characteristic_length * atan2(across, along)
        x, y = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
        return np.concatenate(((-y * turn, x * turn), target[:3] - X_WE.translation()))

    def target_jacobian(self, context: Any) -> Array:
        """Two rows ω across the axis, scaled, then the rows v (5,n)."""
        J = self.arm.spatial_jacobian(context)
        across = (self.arm.pose(context).rotation().matrix() @ self._basis)[:, :2]
        return np.concatenate((self.characteristic_length * (across.T @ J[:3]), J[3:]))

    def target_coordinates(self, target: Array) -> Array:
        """Position and direction (6,), the latter as long as the characteristic length [m]."""
        direction = target[3:]
        size = max(sqrt(direction.dot(direction)), 1e-12)
        return np.concatenate((target[:3], direction * (self.characteristic_length / size)))

    def is_finite(self, target: Array) -> bool:
        """True if the target is finite and its direction is not zero."""
        return super().is_finite(target) and bool(target[3:].dot(target[3:]) > LEAST_SQUARE)

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's |J_ij| (5,n) over all joint positions."""
        bounds = self.arm.jacobian_range()
        turns = self.characteristic_length * np.linalg.norm(bounds[:3], axis=0).clip(max=1.0)
        return np.concatenate((turns[None], turns[None], bounds[3:]))
