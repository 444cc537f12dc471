"""Position and Jacobian of a tool point by Drake's MultibodyPlant, for the blocks."""

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.framework import CacheEntry, Context, LeafSystem, ValueProducer

from fikm_drake.kinematics.task import Task

Array = NDArray[np.float64]


class ToolKinematics:
    """Task coordinates and task Jacobian of the origin of a frame E, in the world frame.

    The plant's Context, which Drake needs as scratch, is not kept here: a block declares it as a
    cache entry of its own (`declare_scratch`) and passes it in, so that its Contexts stay apart.

    Args:
        plant: a finalized plant whose velocities are the rates of its positions.
        frame: name of E.
        task: the coordinates that count.

    Raises:
        ValueError: the plant is not finalized, has positions with q̇ ≠ v or no joint, or has no or
            more than one frame of this name.
    """

    def __init__(self, plant: MultibodyPlant, frame: str, task: Task) -> None:
        if not plant.is_finalized():
            raise ValueError("the plant must be finalized: call plant.Finalize() first")
        if plant.num_positions() == 0 or not plant.IsVelocityEqualToQDot():
            raise ValueError(
                "the plant must have joints, and only such whose velocities are the rates of their "
                "positions; weld its base (a free base has a quaternion)"
            )
        self.plant = plant
        self.num_joints = plant.num_positions()
        self.task = task
        self._frame = _frame_by_name(plant, frame)
        self._world = plant.world_frame()
        self._origin = np.zeros(3)
        first, last = min(task.coordinates), max(task.coordinates)
        step = max(last - first, 1) if task.size == 2 else 1
        self._coordinates = slice(first, last + 1, step)
        self._rows = slice(3 + first, 3 + last + 1, step)

    @property
    def lower(self) -> Array:
        """Lower limits (n,) [rad or m], −inf where there is none."""
        return np.array(self.plant.GetPositionLowerLimits())

    @property
    def upper(self) -> Array:
        """Upper limits (n,) [rad or m], inf where there is none."""
        return np.array(self.plant.GetPositionUpperLimits())

    @property
    def default_position(self) -> Array:
        """The plant's default positions (n,) [rad or m]."""
        return np.array(self.plant.GetPositions(self.plant.CreateDefaultContext()))

    def declare_scratch(self, system: LeafSystem) -> CacheEntry:
        """A cache entry of `system` that holds a plant Context; `Eval` it and pass it in below."""
        return system.DeclareCacheEntry(
            description="plant context",
            value_producer=ValueProducer(
                allocate=lambda: Value[object](self.plant.CreateDefaultContext()),
                calc=ValueProducer.NoopCalc,
            ),
            prerequisites_of_calc={system.nothing_ticket()},
        )

    def position(self, scratch: Context, q: Array) -> list[float]:
        """The task coordinates (m) [m] of E's origin at `q` (n,)."""
        self.plant.SetPositions(scratch, q)
        return self._position(scratch)

    def jacobian(self, scratch: Context, q: Array) -> Array:
        """The task Jacobian (m,n) of E's origin at `q` (n,)."""
        self.plant.SetPositions(scratch, q)
        return self._jacobian(scratch)

    def position_and_jacobian(self, scratch: Context, q: Array) -> tuple[list[float], Array]:
        """Both at once, cheaper than one after the other."""
        self.plant.SetPositions(scratch, q)
        return self._position(scratch), self._jacobian(scratch)

    def _position(self, scratch: Context) -> list[float]:
        pose = self._frame.CalcPoseInWorld(scratch)
        return pose.translation()[self._coordinates].tolist()

    def _jacobian(self, scratch: Context) -> Array:
        world = self._world
        J = self.plant.CalcJacobianSpatialVelocity(
            scratch, JacobianWrtVariable.kV, self._frame, self._origin, world, world
        )
        return J[self._rows]


def _frame_by_name(plant: MultibodyPlant, name: str):
    try:
        return plant.GetFrameByName(name)
    except RuntimeError:
        names = [plant.get_frame(i).name() for i in plant.GetFrameIndices()]
        raise ValueError(
            f"frame must name exactly one frame of the plant, got {name!r}; there are: "
            + ", ".join(names)
        ) from None
