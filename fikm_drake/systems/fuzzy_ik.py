"""The differential-IK block: a task error in, a joint step out."""

from math import inf

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.kinematics.task import Task
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.law import Law
from fikm_drake.laws.safe_step import safe_step
from fikm_drake.laws.steps import all_finite
from fikm_drake.systems.checks import check_not_negative, check_positive
from fikm_drake.systems.tool_pose_kinematics import make_tool_kinematics
from fikm_drake.systems.valid_port import declare_valid_port


class FuzzyIk(LeafSystem):
    """Differential inverse kinematics by the fuzzy mapping.

    .. pydrake_system::

        name: FuzzyIk
        input_ports:
        - task_error
        - position
        - guard
        output_ports:
        - joint_step
        - valid

    - **task_error** (m) [m]: as of `TaskError`, amplified and filtered as the user likes.
    - **position** (n) [rad or m]: the joints.
    - **guard**, only if `guarded`: the target, as of `TaskError`, which must be finite too; else the
      filters before `task_error` would let the arm coast after the target is lost.
    - **joint_step** (n) [rad or m]: dθ of this cycle; zeros while an input is not finite.
    - **valid** (1): 1 while every input is finite, else 0.

    Args:
        plant: a finalized plant; it is not copied.
        law: the mapping (J, dr) to a joint step; by default the paper's.
        frame: name of the tool's frame.
        task: the coordinates that count, see `Task`.
        guarded: whether there is the port `guard`.
        longest_step: a longer joint step is shortened to this length [rad or m].
        side_step: largest joint motion of the step that leaves a dead point, see `laws.side_step`
            [rad or m]; 0: the arm stays there.

    Raises:
        ValueError: see `ToolKinematics` and `Task`.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        law: Law | None = None,
        frame: str = "tool",
        task: str | Task = "position",
        guarded: bool = False,
        longest_step: float = inf,
        side_step: float = 0.0,
    ) -> None:
        super().__init__()
        self._kinematics = make_tool_kinematics(plant, frame, task)
        self._law = law or FuzzyMapping()
        self._longest_step = check_positive("longest_step", longest_step)
        self._side_step = check_not_negative("side_step", side_step)
        n = self._kinematics.num_joints
        self._hold = np.zeros(n)
        m = self._kinematics.task.size
        self._error = self.DeclareVectorInputPort("task_error", m).Eval
        self._position = self.DeclareVectorInputPort("position", n).Eval
        self._guard = None
        if guarded:
            self._guard = self._kinematics.declare_desired(self, "guard").Eval
        self.DeclareVectorOutputPort(
            "joint_step",
            n,
            self._calc_step,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )
        declare_valid_port(self)

    def _calc_step(self, context: Context, output: BasicVector) -> None:
        error = self._error(context)
        lost = self._guard is not None and not self._kinematics.is_finite(self._guard(context))
        if lost or not all_finite(error):
            output.set_value(self._hold)
            return
        q, jacobian = self._position(context), self._kinematics.jacobian
        output.set_value(
            safe_step(
                self._law, jacobian, q, jacobian(q), error, self._longest_step, self._side_step
            )
        )
