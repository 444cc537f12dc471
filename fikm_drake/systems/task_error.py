"""The block that compares where the tool is with where it should be."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task


class TaskError(LeafSystem):
    """Desired minus actual task coordinates of a tool.

    .. pydrake_system::

        name: TaskError
        input_ports:
        - desired_position
        - position
        output_ports:
        - task_error
        - valid

    - **desired_position** (m) [m]: target of the tool's origin, in the world frame. Other tasks have
      another port in its place: **desired_pose**, a RigidTransform X_WE, for those with orientation,
      **desired_pointing** (6) for `PointingTask`, or whatever a task of one's own declares.
    - **position** (n) [rad or m]: the joints.
    - **task_error** (m) [m]: desired minus actual, see the task; zeros while it is not finite.
    - **valid** (1): 1 while the error is finite, else 0.

    Args:
        plant: a finalized plant; it is not copied.
        frame: name of the tool's frame.
        task: a name, see `FuzzyIkConfig.task`, or an object, see `TaskKinematics`.

    Raises:
        ValueError: see `PlantArm` and `TaskKinematics`.

    Example:
        >>> import fikm_drake as fd
        >>> plant = fd.MakeDhArmPlant(fd.load_arm("planar4"))
        >>> fd.TaskError(plant, task="xy").GetOutputPort("task_error").size()
        2
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        frame: str = "tool",
        task: str | TaskKinematics = "position",
    ) -> None:
        super().__init__()
        self._task = as_task(plant, frame, task)
        self._zeros = np.zeros(self._task.size)
        desired = self._task.declare_target(self)
        position = self.DeclareVectorInputPort("position", self._task.arm.num_joints)
        self._desired, self._position = desired.Eval, position.Eval
        inputs = {desired.ticket(), position.ticket()}
        self.DeclareVectorOutputPort(
            "task_error", self._task.size, self._calc_error, prerequisites_of_calc=inputs
        )
        self.DeclareVectorOutputPort("valid", 1, self._calc_valid, prerequisites_of_calc=inputs)

    def _calc_error(self, context: Context, output: BasicVector) -> None:
        error = self._task.error(self._desired(context), self._position(context))
        output.set_value(error if all_finite(error) else self._zeros)

    def _calc_valid(self, context: Context, output: BasicVector) -> None:
        output[0] = all_finite(self._task.error(self._desired(context), self._position(context)))
