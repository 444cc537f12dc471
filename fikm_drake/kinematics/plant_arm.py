"""The arm that a controller moves, as Drake's MultibodyPlant has it."""

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable, ModelInstanceIndex
from pydrake.systems.framework import Context as PlantContext

from fikm_drake.arrays import Array
from fikm_drake.kinematics.chain_limits import ChainLimits
from fikm_drake.kinematics.chain_of_plant import held_positions
from fikm_drake.kinematics.jacobian_range import jacobian_range
from fikm_drake.kinematics.plant_frames import as_frame
from fikm_drake.kinematics.serial_chain import SerialChain

_VELOCITY = JacobianWrtVariable.kV
_ORIGIN = np.zeros((3, 1))  # of this shape it is passed on without a copy


class PlantArm(ChainLimits):
    """Joints of a plant and the tool's frame E: poses and Jacobians in a frame A, and limits.

    The joints are those of a `SerialChain`; the plant may hold whatever else, which stays where it is:
    free bodies, grippers, other arms. Every function depends on its arguments only, from any thread:
    the plant's Context, which Drake needs as scratch, is one for each thread, and its positions are
    set before each use.

    Args:
        plant: a finalized plant; it is not copied.
        frame: E, or its name; `instance::name` where several model instances have one.
        joints: which joints on the way to E move: names, or a model instance; None: all that can.
        reference_frame: A, or its name; None: the world. A frame that the joints move will do.
        context: of the plant: where other joints stand, and which are locked; None: the default.

    Attributes:
        plant: the plant.
        chain: the joints, from A to E.

    Raises:
        ValueError: the plant is not finalized; no or more than one such frame or joint; no joint moves
            E; the message lists what there is.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("planar2")), frame="tool")
        >>> arm.pose(arm.context_at(np.zeros(2))).translation().round(3).tolist()
        [2.0, 0.0, 0.0]
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        frame: str | Frame = "tool",
        *,
        joints: Sequence[str] | ModelInstanceIndex | None = None,
        reference_frame: str | Frame | None = None,
        context: PlantContext | None = None,
    ) -> None:
        self.chain = SerialChain.from_plant(
            plant, frame, joints=joints, base=reference_frame, context=context
        )
        self.plant = plant
        tool, base = as_frame(plant, frame), as_frame(plant, reference_frame)
        self._base, self._tool = base, tool
        self._in_world = base.is_world_frame()
        template = plant.CreateDefaultContext() if context is None else context.Clone()
        self._scratch = _Scratch(template, held_positions(plant, template))
        positions, velocities = self.chain.position_indices, self.chain.velocity_indices
        assert positions is not None and velocities is not None
        everything = np.arange(plant.num_positions())
        self._positions = None if np.array_equal(positions, everything) else positions
        everything = np.arange(plant.num_velocities())
        self._columns = None if np.array_equal(velocities, everything) else velocities
        # Bound methods, looked up once.
        self._set_positions = plant.SetPositions
        self._calc_pose = tool.CalcPoseInWorld
        self._calc_spatial = plant.CalcJacobianSpatialVelocity
        self._calc_translational = plant.CalcJacobianTranslationalVelocity

    def context_at(self, q: Array) -> Any:
        """This thread's scratch Context of the plant with the joints at `q` (n,), which is finite.

        It holds until the next call in this thread. A plant ends the process if it is given
        positions that are not finite: see `PlantTask`, which answers those with NaN.
        """
        context = self._scratch.context
        if self._positions is not None:
            full = self._scratch.positions
            full[self._positions] = q
            q = full
        self._set_positions(context, q)
        return context

    def pose(self, context: Any) -> RigidTransform:
        """X_AE in a Context of `context_at`."""
        if self._in_world:  # the same, cheaper
            return self._calc_pose(context)
        return self._tool.CalcPose(context, self._base)

    def spatial_jacobian(self, context: Any) -> Array:
        """The Jacobian of E's spatial velocity [ω; v] in A (6,n), in a Context of `context_at`."""
        base = self._base
        J = self._calc_spatial(context, _VELOCITY, self._tool, _ORIGIN, base, base)
        return J if self._columns is None else J[:, self._columns]

    def translational_jacobian(self, context: Any) -> Array:
        """The Jacobian of E's translational velocity in A (3,n), in a Context of `context_at`."""
        base = self._base
        J = self._calc_translational(context, _VELOCITY, self._tool, _ORIGIN, base, base)
        return J if self._columns is None else J[:, self._columns]

    def jacobian_range(self) -> Array:
        """Bounds of |J_ij| of the spatial Jacobian (6,n) over all joint positions."""
        return jacobian_range(self.chain)


class _Scratch(threading.local):
    """A plant Context for each thread; each use writes all of it that it reads."""

    def __init__(self, context: PlantContext, positions: Array) -> None:
        self.context = context.Clone()
        self.positions = positions.copy()
