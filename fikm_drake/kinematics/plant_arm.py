"""The arm that a controller moves, as Drake's MultibodyPlant has it."""

import threading
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from fikm_drake.arrays import Array
from fikm_drake.kinematics.plant_frames import check_plant, frame_by_name
from fikm_drake.kinematics.plant_jacobian_range import plant_jacobian_range

_VELOCITY = JacobianWrtVariable.kV
_ORIGIN = np.zeros((3, 1))  # of this shape it is passed on without a copy


class PlantArm:
    """The joints of a plant and the tool's frame E: poses and Jacobians in the world W, and limits.

    Every function depends on its arguments only, from any thread: the plant's Context, which Drake
    needs as scratch, is one for each thread, and its positions are set before each use.

    Args:
        plant: a finalized plant whose velocities are the rates of its positions; it is not copied.
        frame: name of E; `instance::name` where several model instances have such a frame.

    Attributes:
        plant: the plant.
        num_joints: n.

    Raises:
        ValueError: the plant is not finalized, has positions with q̇ ≠ v or no joint, or has no or
            more than one frame of this name; the message lists the frames.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("planar2")), frame="tool")
        >>> arm.pose(arm.context_at(np.zeros(2))).translation().round(3).tolist()
        [2.0, 0.0, 0.0]
    """

    def __init__(self, plant: MultibodyPlant, frame: str = "tool") -> None:
        check_plant(plant)
        self.plant = plant
        self.num_joints = plant.num_positions()
        self._frame = frame_by_name(plant, frame)
        self._world = plant.world_frame()
        self._scratch = _Scratch(plant)
        # Bound methods, looked up once.
        self._set_positions = plant.SetPositions
        self._calc_pose = self._frame.CalcPoseInWorld
        self._calc_spatial = plant.CalcJacobianSpatialVelocity
        self._calc_translational = plant.CalcJacobianTranslationalVelocity

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

    def context_at(self, q: Array) -> Any:
        """This thread's scratch Context of the plant with the joints at `q` (n,), which is finite.

        It holds until the next call in this thread. A plant ends the process if it is given
        positions that are not finite: see `PlantTask`, which answers those with NaN.
        """
        context = self._scratch.context
        self._set_positions(context, q)
        return context

    def pose(self, context: Any) -> RigidTransform:
        """X_WE in a Context of `context_at`."""
        return self._calc_pose(context)

    def spatial_jacobian(self, context: Any) -> Array:
        """The Jacobian of E's spatial velocity [ω; v] in W (6,n), in a Context of `context_at`."""
        world = self._world
        return self._calc_spatial(context, _VELOCITY, self._frame, _ORIGIN, world, world)

    def translational_jacobian(self, context: Any) -> Array:
        """The Jacobian of E's translational velocity in W (3,n), in a Context of `context_at`."""
        world = self._world
        return self._calc_translational(context, _VELOCITY, self._frame, _ORIGIN, world, world)

    def jacobian_range(self) -> Array:
        """Bounds of |J_ij| of the spatial Jacobian (6,n) over all joint positions."""
        return plant_jacobian_range(self.plant, self._frame)


class _Scratch(threading.local):
    """A plant Context for each thread; each use writes all of it that it reads."""

    def __init__(self, plant: MultibodyPlant) -> None:
        self.context = plant.CreateDefaultContext()
