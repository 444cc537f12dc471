"""The block that adds what the task leaves free of a motion."""

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.checks import check_period
from fikm_drake.control.null_space import null_space_step
from fikm_drake.kinematics.task_kinematics import TaskKinematics


class NullSpaceFilter(LeafSystem):
    """Adds to a law's joint step what the task leaves free of a joint velocity that is wished for.

    .. pydrake_system::

        name: NullSpaceFilter
        input_ports:
        - law_step
        - position
        - null_space_motion
        - valid
        output_ports:
        - joint_step

    - **law_step** (n) [rad or m]: as of `DifferentialIk`.
    - **position** (n) [rad or m]: the joints.
    - **null_space_motion** (n) [rad/s or m/s]: as of `NullSpaceMotion`; unconnected or not finite: none.
    - **valid** (1), may stay unconnected: of `TaskError`; while it is 0 the motion counts as none, since
      without a target nobody knows what it leaves free.
    - **joint_step** (n) [rad or m]: the law's step and the free part of the motion times the period,
      see `control.null_space`.

    Args:
        task: what counts.
        period: of the control cycle [s].

    Raises:
        ValueError: the period is not positive and finite.
    """

    def __init__(self, task: TaskKinematics, *, period: float) -> None:
        super().__init__()
        n = task.arm.num_joints
        self._task, self._period = task, check_period(period)
        self._step = self.DeclareVectorInputPort("law_step", n).Eval
        self._position = self.DeclareVectorInputPort("position", n).Eval
        self._motion = self.DeclareVectorInputPort("null_space_motion", n)
        self._valid = self.DeclareVectorInputPort("valid", 1)
        self.DeclareVectorOutputPort(
            "joint_step", n, self._calc, prerequisites_of_calc={self.all_input_ports_ticket()}
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        step = self._step(context)
        valid = not self._valid.HasValue(context) or self._valid.Eval(context)[0] == 1.0
        if valid and self._motion.HasValue(context):
            q = self._position(context)
            if all_finite(q):
                motion = self._period * self._motion.Eval(context)
                step = step + null_space_step(self._task.jacobian(q), motion)
        output.set_value(step)
