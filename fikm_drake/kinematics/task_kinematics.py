"""What a task is: an object that knows its error and its Jacobian."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import InputPort, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.kinematics.native.native_task import NativeTask, native_task
from fikm_drake.kinematics.plant_arm import PlantArm

CHECKED_AT = (0.1, -0.23)
"""Postures where the kernel's Jacobian is compared with the plant's [rad or m]."""
SAME = 1e-9
"""Of entries, over the reach: what is still rounding [-]."""


@runtime_checkable
class TaskKinematics(Protocol):
    """What blocks and factories ask of a task; `PlantTask` is the easy way to a new one.

    A *target* is whatever the task's input port carries: a vector, or a pose. All rows of the error
    are in metres (a turn counts as an arc of a characteristic length), so that they can be added.
    Where `q` or the target is not finite the error is NaN; nothing raises.

    Attributes:
        arm: the joints that the task moves, with their limits.
        size: m, the number of rows.
        num_coordinates: c, the number of a target's coordinates.
    """

    arm: PlantArm
    size: int

    @property
    def num_coordinates(self) -> int:
        """The number of a target's coordinates, c."""

    def error(self, target: Any, q: Array) -> Array:
        """Desired minus actual (m,) [m] at joint positions `q` (n,)."""

    def jacobian(self, q: Array) -> Array:
        """The task Jacobian (m,n): the error falls by J dθ for a small joint step dθ."""

    def error_and_jacobian(self, target: Any, q: Array) -> tuple[Array, Array]:
        """Both at once, cheaper than one after the other."""

    def target_coordinates(self, target: Any) -> Array:
        """A target as a vector (c,): two targets are as far apart as theirs are, as the error is [m]."""

    def is_finite(self, target: Any) -> bool:
        """True if no number of a target is NaN or infinite."""

    def declare_target(self, system: LeafSystem, name: str | None = None) -> InputPort:
        """Declare a block's input port for the target; by default under the task's usual name."""


class PlantTask(ABC):
    """A task of a `PlantArm`: a subclass says its error and Jacobian in a Context, no more.

    Args:
        arm: the joints and the tool's frame.

    Example:
        A task that holds the tool at a height:

        >>> import numpy as np, fikm_drake as fd
        >>> class Height(fd.PlantTask):
        ...     size, port = 1, "desired_height"
        ...     def target_error(self, context, target):
        ...         return target - self.arm.pose(context).translation()[2:]
        ...     def target_jacobian(self, context):
        ...         return self.arm.translational_jacobian(context)[2:]
        >>> height = Height(fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("panda"))))
        >>> height.error(np.array([0.5]), height.arm.default_position).shape
        (1,)
    """

    size: int
    """m, the number of rows."""
    port: str
    """Usual name of the target's port."""
    target_size: int | None = None
    """Size of the target's vector; None: m."""
    native: NativeTask | None = None
    """Error and Jacobian by the native kernel, for tasks that it knows; see `native_task_of`."""

    def __init__(self, arm: PlantArm) -> None:
        self.arm = arm

    @property
    def num_coordinates(self) -> int:
        """The number of a target's coordinates, c."""
        return self.size if self.target_size is None else self.target_size

    @abstractmethod
    def target_error(self, context: Any, target: Any) -> Array:
        """Desired minus actual (m,) [m] in a Context of the plant."""

    @abstractmethod
    def target_jacobian(self, context: Any) -> Array:
        """The task Jacobian (m,n) in a Context of the plant."""

    def error(self, target: Any, q: Array) -> Array:
        """Desired minus actual (m,) [m] at `q` (n,); NaN where `q` is not finite."""
        if self.native:
            return self.native.error(self.target_numbers(target), q)
        if not all_finite(q):
            return np.full(self.size, np.nan)
        return self.target_error(self.arm.context_at(q), target)

    def jacobian(self, q: Array) -> Array:
        """The task Jacobian (m,n) at `q` (n,); NaN where `q` is not finite."""
        if self.native:
            return self.native.jacobian(q)
        if not all_finite(q):
            return np.full((self.size, self.arm.num_joints), np.nan)
        return self.target_jacobian(self.arm.context_at(q))

    def error_and_jacobian(self, target: Any, q: Array) -> tuple[Array, Array]:
        """Both at once, cheaper than one after the other."""
        if self.native:
            return self.native.error_and_jacobian(self.target_numbers(target), q)
        if not all_finite(q):
            return np.full(self.size, np.nan), np.full((self.size, self.arm.num_joints), np.nan)
        context = self.arm.context_at(q)
        return self.target_error(context, target), self.target_jacobian(context)

    def target_coordinates(self, target: Any) -> Array:
        """The target as a vector (c,); two targets are as far apart as theirs are [m]."""
        return target

    def target_numbers(self, target: Any) -> Array:
        """The target as the native kernel takes it: the vector, or a pose (3,4)."""
        return target

    def is_finite(self, target: Any) -> bool:
        """True if no number of a target is NaN or infinite."""
        return all_finite(target)

    def declare_target(self, system: LeafSystem, name: str | None = None) -> InputPort:
        """Declare the input port for a target, a vector."""
        return system.DeclareVectorInputPort(name or self.port, self.num_coordinates)


class PoseTargetTask(PlantTask):
    """A task whose target is a RigidTransform X_WE."""

    port = "desired_pose"

    def target_numbers(self, target: RigidTransform) -> Array:
        """The pose (3,4)."""
        return target.GetAsMatrix34()

    def is_finite(self, target: RigidTransform) -> bool:
        """True if no number of a target is NaN or infinite."""
        return all_finite(target.GetAsMatrix34().ravel())

    def declare_target(self, system: LeafSystem, name: str | None = None) -> InputPort:
        """Declare the input port for a target: a RigidTransform X_WE."""
        return system.DeclareAbstractInputPort(name or self.port, Value(RigidTransform()))


def native_task_of(task: PlantTask, rows: Sequence[int], length: float = 0.0) -> NativeTask | None:
    """The kernel's error and Jacobian of a task of the tool's place, if its chain moves as the plant does.

    Args:
        task: with its arm.
        rows: which of the six rows [ω; v] count (m,).
        length: of a turn of 1 rad, for a task whose target is a pose [m].
    """
    arm = task.arm
    native = native_task(arm.chain.packed(), arm.num_joints, rows, length)
    if native is None:
        return None
    for fraction in CHECKED_AT:
        q = arm.default_position + fraction * np.arange(1.0, arm.num_joints + 1.0)
        J, seen = native.jacobian(q), task.target_jacobian(arm.context_at(q))
        if not np.allclose(J, seen, rtol=0.0, atol=SAME * max(1.0, arm.chain.reach)):
            return None
    return native
