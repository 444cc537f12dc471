"""Task error and Jacobian of a tool by Drake's MultibodyPlant, for the blocks."""

import threading
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.framework import InputPort, LeafSystem

from fikm_drake.arrays import Array
from fikm_drake.control.steps import all_finite
from fikm_drake.kinematics.plant_frames import check_plant, frame_by_name
from fikm_drake.kinematics.plant_jacobian_range import plant_jacobian_range
from fikm_drake.kinematics.task import Task

VELOCITY = JacobianWrtVariable.kV
ORIGIN = np.zeros((3, 1))  # of this shape it is passed on without a copy


class ToolKinematics:
    """Error and Jacobian of the position of a frame E, in the world frame.

    Every function depends on its arguments only, from any thread: the plant's Context, which Drake
    needs as scratch, is one for each thread, and its positions are set before each use. Where `q`
    is not finite the answer is NaN: a plant ends the process if it is given such positions.

    Args:
        plant: a finalized plant whose velocities are the rates of its positions.
        frame: name of E; `instance::name` where several model instances have such a frame.
        task: the coordinates that count; `ToolPoseKinematics` is for those with orientation.

    Raises:
        ValueError: the plant is not finalized, has positions with q̇ ≠ v or no joint, or has no or
            more than one frame of this name; the message lists the frames.
    """

    def __init__(self, plant: MultibodyPlant, frame: str, task: Task) -> None:
        check_plant(plant)
        self.plant = plant
        self.num_joints = plant.num_positions()
        self.task = task
        self._frame = frame_by_name(plant, frame)
        self._world = plant.world_frame()
        self._scratch = _Scratch(plant)
        self._no_error = np.full(task.size, np.nan)
        self._no_jacobian = np.full((task.size, self.num_joints), np.nan)
        # Bound methods, looked up once.
        self._set_positions = plant.SetPositions
        self._calc_pose = self._frame.CalcPoseInWorld
        self._calc_jacobian = plant.CalcJacobianTranslationalVelocity
        self._axes = _as_slice(task.coordinates)

    @property
    def lower(self) -> Array:
        """Lower limits (n,) [rad or m], −inf where there is none."""
        return np.array(self.plant.GetPositionLowerLimits())

    @property
    def upper(self) -> Array:
        """Upper limits (n,) [rad or m], inf where there is none."""
        return np.array(self.plant.GetPositionUpperLimits())

    @property
    def velocity_limits(self) -> Array:
        """Largest speed (n,) [rad/s or m/s], inf where there is no limit."""
        plant = self.plant
        return np.minimum(plant.GetVelocityUpperLimits(), -plant.GetVelocityLowerLimits())

    @property
    def acceleration_limits(self) -> Array:
        """Largest acceleration (n,) [rad/s² or m/s²], inf where there is no limit."""
        plant = self.plant
        return np.minimum(plant.GetAccelerationUpperLimits(), -plant.GetAccelerationLowerLimits())

    @property
    def default_position(self) -> Array:
        """The plant's default positions, moved inside the limits (n,) [rad or m]."""
        q = self.plant.GetPositions(self.plant.CreateDefaultContext())
        return np.clip(q, self.lower, self.upper)

    def declare_desired(self, system: LeafSystem, name: str = "desired_position") -> InputPort:
        """Declare the input port for a target: a position (m) [m]."""
        return system.DeclareVectorInputPort(name, self.task.size)

    @property
    def num_coordinates(self) -> int:
        """The number of a target's coordinates, c."""
        return self.task.size

    def target_coordinates(self, desired: Any) -> Array:
        """A target's coordinates (c,): two targets are as far apart as theirs are [m]."""
        return desired

    def is_finite(self, desired: Any) -> bool:
        """True if no number of a target is NaN or infinite."""
        return all_finite(desired)

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's |J_ij| (m,n) over all joint positions."""
        return plant_jacobian_range(self.plant, self._frame)[3:][self._axes]

    def error(self, desired: Any, q: Array) -> Array:
        """Desired minus actual (m,) [m] at `q` (n,); `desired` as from the port."""
        if not all_finite(q):
            return self._no_error
        context = self._scratch.context
        self._set_positions(context, q)
        return self._error(context, desired)

    def jacobian(self, q: Array) -> Array:
        """The task Jacobian (m,n) at `q` (n,)."""
        if not all_finite(q):
            return self._no_jacobian
        context = self._scratch.context
        self._set_positions(context, q)
        return self._jacobian(context)

    def error_and_jacobian(self, desired: Any, q: Array) -> tuple[Array, Array]:
        """Both at once, cheaper than one after the other."""
        if not all_finite(q):
            return self._no_error, self._no_jacobian
        context = self._scratch.context
        self._set_positions(context, q)
        return self._error(context, desired), self._jacobian(context)

    def _error(self, context: Any, desired: Array) -> Array:
        return desired - self._calc_pose(context).translation()[self._axes]

    def _jacobian(self, context: Any) -> Array:
        world = self._world
        J = self._calc_jacobian(context, VELOCITY, self._frame, ORIGIN, world, world)
        return J[self._axes]


class _Scratch(threading.local):
    """A plant Context for each thread; each use writes all of it that it reads."""

    def __init__(self, plant: MultibodyPlant) -> None:
        self.context = plant.CreateDefaultContext()


def _as_slice(axes: list[int]) -> slice:
    """The axes as a slice, which costs a step less than a list."""
    stride = axes[1] - axes[0] if len(axes) > 1 else 1
    return slice(axes[0], axes[-1] + 1, stride) if axes else slice(0)
