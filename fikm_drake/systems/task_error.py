"""The block that compares where the tool is with where it should be."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.control.steps import all_finite
from fikm_drake.kinematics.task import Task
from fikm_drake.systems.tool_pose_kinematics import make_tool_kinematics
from fikm_drake.systems.valid_port import declare_valid_port


class TaskError(LeafSystem):
    """Desired minus actual task coordinates of a tool.

    .. pydrake_system::

        name: TaskError
        input_ports:
        - desired_position
        - position
        output_ports:
        - task_error
        - target
        - valid

    - **desired_position** (m) [m]: target of the tool's origin, in the world frame. For tasks with
      orientation **desired_pose** is in its place, a RigidTransform X_WE.
    - **position** (n) [rad or m]: the joints.
    - **task_error** (m) [m]: desired minus actual, in the world frame, rows [ω; v], a rotation as
      angle times axis times the characteristic length; zeros while an input is not finite.
    - **target** (c) [m]: the target's coordinates, as `GainSupervisor` takes them: the position, or
      the numbers of the pose, a rotation matrix times the characteristic length over √2; zeros while
      they are not finite.
    - **valid** (1): 1 while every input is finite, else 0.

    Args:
        plant: a finalized plant; it is not copied.
        frame: name of the tool's frame.
        task: the coordinates that count, see `Task`.

    Raises:
        ValueError: see `ToolKinematics` and `Task`.
    """

    def __init__(
        self, plant: MultibodyPlant, *, frame: str = "tool", task: str | Task = "position"
    ) -> None:
        super().__init__()
        self._kinematics = make_tool_kinematics(plant, frame, task)
        self.num_coordinates = self._kinematics.num_coordinates
        m = self._kinematics.task.size
        self._zeros = np.zeros(m)
        desired = self._kinematics.declare_desired(self)
        position = self.DeclareVectorInputPort("position", self._kinematics.num_joints)
        self._desired, self._position = desired.Eval, position.Eval
        self.DeclareVectorOutputPort(
            "task_error",
            m,
            self._calc_error,
            prerequisites_of_calc={desired.ticket(), position.ticket()},
        )
        self.DeclareVectorOutputPort(
            "target",
            self._kinematics.num_coordinates,
            self._calc_target,
            prerequisites_of_calc={desired.ticket()},
        )
        declare_valid_port(self)

    def _calc_error(self, context: Context, output: BasicVector) -> None:
        error = self._kinematics.error(self._desired(context), self._position(context))
        output.set_value(error if all_finite(error) else self._zeros)

    def _calc_target(self, context: Context, output: BasicVector) -> None:
        target = self._kinematics.target_coordinates(self._desired(context))
        output.set_value(target if all_finite(target) else np.zeros(len(target)))
