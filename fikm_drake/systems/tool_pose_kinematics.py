"""Task error and Jacobian of a tool's orientation or pose."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import InputPort, LeafSystem

from fikm_drake.arrays import Array
from fikm_drake.kinematics.plant_jacobian_range import plant_jacobian_range
from fikm_drake.kinematics.task import Task
from fikm_drake.systems.tool_kinematics import ORIGIN, VELOCITY, ToolKinematics
from fikm_drake.systems.valid_port import is_finite


class ToolPoseKinematics(ToolKinematics):
    """As `ToolKinematics`, for tasks with orientation; targets are RigidTransforms X_WE.

    The error of orientation is the rotation vector (angle times axis, in the world frame) that
    turns E to its target the short way, correct through 180°; times the task's characteristic
    length it is in metres, as is the error of position.
    """

    def __init__(self, plant: MultibodyPlant, frame: str, task: Task) -> None:
        super().__init__(plant, frame, task)
        self._calc_jacobian = plant.CalcJacobianSpatialVelocity
        self._size = task.size
        self._length = task.characteristic_length
        self._scale = np.array([self._length] * 3 + [1.0] * (task.size - 3))
        # A turn by φ changes the rotation matrix by 2√2 sin(φ/2), in the Frobenius norm.
        self._coordinates = np.array([self._length / np.sqrt(2.0)] * 3 + [1.0] * (task.size > 3))

    def declare_desired(self, system: LeafSystem, name: str = "desired_pose") -> InputPort:
        """Declare the input port for a target: a RigidTransform X_WE."""
        return system.DeclareAbstractInputPort(name, Value(RigidTransform()))

    @property
    def num_coordinates(self) -> int:
        """Those of the rotation matrix and, if it counts, of the position."""
        return 3 * len(self._coordinates)

    def target_coordinates(self, desired: RigidTransform) -> Array:
        """The numbers of a pose (c,) in metres: for small turns as far apart as the error is long."""
        columns = len(self._coordinates)
        return (desired.GetAsMatrix34()[:, :columns] * self._coordinates).ravel()

    def is_finite(self, desired: RigidTransform) -> bool:
        """True if no number of a target is NaN or infinite."""
        return is_finite(desired)

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's |J_ij| (m,n) over all joint positions."""
        return plant_jacobian_range(self.plant, self._frame)[: self._size] * self._scale[:, None]

    def _error(self, context: Any, desired: RigidTransform) -> Array:
        X_WE = self._calc_pose(context)
        turn = desired.rotation().multiply(X_WE.rotation().inverse()).ToAngleAxis()
        rotation = turn.axis()
        rotation *= self._length * turn.angle()
        if self._size == 3:
            return rotation
        return np.concatenate((rotation, desired.translation() - X_WE.translation()))

    def _jacobian(self, context: Any) -> Array:
        world = self._world
        J = self._calc_jacobian(context, VELOCITY, self._frame, ORIGIN, world, world)
        J[:3] *= self._length
        return J[: self._size]


def make_tool_kinematics(plant: MultibodyPlant, frame: str, task: str | Task) -> ToolKinematics:
    """The kinematics for a task.

    Args:
        plant: a finalized plant.
        frame: name of the tool's frame.
        task: the task, or its name with the usual characteristic length.

    Raises:
        ValueError: see `Task` and `ToolKinematics`.
    """
    task = task if isinstance(task, Task) else Task(task)
    return (ToolPoseKinematics if task.turns else ToolKinematics)(plant, frame, task)
