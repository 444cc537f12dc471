"""Targets that are given in a frame that moves."""

import threading
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.kinematics.plant_frames import as_frame


class TargetInFrame(LeafSystem):
    """Brings a target from a moving frame F into the world W: a place on a conveyor, a hand's palm.

    .. pydrake_system::

        name: TargetInFrame
        input_ports:
        - desired_pose
        - reference_pose
        output_ports:
        - target

    - **desired_pose**: RigidTransform X_FE; for `task="position"` **desired_position** (3) [m] in F.
    - **reference_pose**: RigidTransform X_WF; with a plant **plant_state** (nq + nv) in its place.
    - **target**: RigidTransform X_WE, or (3) [m] in W, for a controller's first port; NaN, which is no
      target for a controller, while an input is not finite.

    A frame that stands still, or that the controller's own joints move, needs no such block: see
    `reference_frame=` of `AddFuzzyIkController`.

    Args:
        task: `pose` or `position`.
        plant: a finalized plant that has F; None: F's pose comes by a port.
        frame: F, or its name, with a plant.

    Raises:
        ValueError: naming the bad value and the valid ones; a plant without a frame, or the reverse.

    Example:
        >>> import fikm_drake as fd
        >>> fd.TargetInFrame("position").GetInputPort("desired_position").size()
        3
    """

    def __init__(
        self,
        task: str = "pose",
        *,
        plant: MultibodyPlant | None = None,
        frame: str | Frame | None = None,
    ) -> None:
        super().__init__()
        if task not in ("pose", "position"):
            raise ValueError(f"task must be one of ('pose', 'position'), got {task!r}")
        if (plant is None) != (frame is None):
            raise ValueError("TargetInFrame needs a plant and a frame of it, or neither")
        self._plant = plant
        pose = Value(RigidTransform())
        if task == "pose":
            desired = self.DeclareAbstractInputPort("desired_pose", pose)
        else:
            desired = self.DeclareVectorInputPort("desired_position", 3)
        if plant is None:
            reference = self.DeclareAbstractInputPort("reference_pose", pose)
        else:
            self._frame, self._scratch = as_frame(plant, frame), _Scratch(plant)
            reference = self.DeclareVectorInputPort("plant_state", plant.num_multibody_states())
        self._desired, self._reference = desired.Eval, reference.Eval
        inputs = {self.all_input_ports_ticket()}
        if task == "pose":
            self.DeclareAbstractOutputPort(
                "target", pose.Clone, self._calc_pose, prerequisites_of_calc=inputs
            )
        else:
            self.DeclareVectorOutputPort(
                "target", 3, self._calc_position, prerequisites_of_calc=inputs
            )

    def _reference_pose(self, context: Context) -> RigidTransform:
        reference: Any = self._reference(context)
        if self._plant is None:
            return reference
        if not all_finite(reference):
            return RigidTransform(np.full(3, np.nan))
        own = self._scratch.context
        self._plant.SetPositionsAndVelocities(own, reference)
        return self._frame.CalcPoseInWorld(own)

    def _calc_pose(self, context: Context, output: AbstractValue) -> None:
        X_WF, X_FE = self._reference_pose(context), self._desired(context)
        rotation = X_WF.rotation().matrix() @ X_FE.rotation().matrix()
        point = X_WF.rotation().matrix() @ X_FE.translation() + X_WF.translation()
        if not (np.isfinite(rotation).all() and np.isfinite(point).all()):
            rotation, point = np.eye(3), np.full(3, np.nan)
        output.set_value(RigidTransform(RotationMatrix.ProjectToRotationMatrix(rotation), point))

    def _calc_position(self, context: Context, output: BasicVector) -> None:
        X_WF = self._reference_pose(context).GetAsMatrix34()
        output.set_value(X_WF[:, :3] @ self._desired(context) + X_WF[:, 3])


class _Scratch(threading.local):
    """A plant Context for each thread; each use writes all of it that it reads."""

    def __init__(self, plant: MultibodyPlant) -> None:
        self.context = plant.CreateDefaultContext()
