"""The block that leaves dead points and local minima."""

from math import isfinite

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.restart_search import make_restart_search
from fikm_drake.control.steps import length
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.systems.valid_port import declare_valid_port


class RestartPlanner(LeafSystem):
    """Takes the joints to another posture where a law rests before its target, see `RestartSearch`.

    .. pydrake_system::

        name: RestartPlanner
        input_ports:
        - desired_position
        - position
        - law_step
        output_ports:
        - joint_step
        - restart_search
        - valid

    - **desired_position** (m) [m]: as of `TaskError`; for tasks with orientation **desired_pose**.
    - **position** (n) [rad or m]: the joints.
    - **law_step** (n) [rad or m]: the law's joint step of this cycle, as of `DifferentialIk`.
    - **obstacle_position** (p): as of `ClearanceFilter`; exists with a `clearance` only.
    - **joint_step** (n) [rad or m]: that step, or on a restart search the one to the posture that was found;
      zeros while an input is not finite.
    - **restart_search** (1): a `RestartState`, from the state.
    - **valid** (1): 1 while every input is finite, else 0; then the restart search is given up.

    Args:
        plant: a finalized plant; it is not copied.
        period: of the control cycle [s].
        frame: name of the tool's frame.
        task: a name, see `FuzzyIkConfig.task`, or an object, see `TaskKinematics`.
        tolerance: a task error up to this is no reason for a restart search [m].
        speed: of the fastest joint on a restart search [rad/s or m/s].
        limits: of the joints, kept on the way as well; None: none.
        clearance: what the way keeps clear of; None: nothing.

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        period: float,
        frame: str = "tool",
        task: str | TaskKinematics = "position",
        tolerance: float = 1e-3,
        speed: float = 1.5,
        limits: JointLimits | None = None,
        clearance: Clearance | None = None,
    ) -> None:
        super().__init__()
        self._task = as_task(plant, frame, task)
        self._restart = make_restart_search(
            self._task,
            tolerance=tolerance,
            speed=speed,
            period=period,
            limits=limits,
            clearance=clearance,
        )
        n = self._task.arm.num_joints
        self._hold = np.zeros(n)
        self._desired = self._task.declare_target(self).Eval
        self._position = self.DeclareVectorInputPort("position", n).Eval
        self._step = self.DeclareVectorInputPort("law_step", n).Eval
        self._others = None
        if clearance is not None and len(clearance.default_others):
            count = len(clearance.default_others)
            self._others = self.DeclareVectorInputPort("obstacle_position", count)
        self.DeclareDiscreteState(self._restart.initial_memory())
        self.DeclareVectorOutputPort(
            "joint_step",
            n,
            self._calc_step,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclareVectorOutputPort(
            "restart_search", 1, self._calc_restart, prerequisites_of_calc={self.xd_ticket()}
        )
        declare_valid_port(self)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_step(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state_vector().value()
        q, step = self._position(context), self._step(context)
        finite = all_finite(q) and all_finite(step)
        if finite and self._task.is_finite(self._desired(context)):
            output.set_value(self._restart.step(memory, q, step))
        else:
            output.set_value(self._hold)

    def _calc_restart(self, context: Context, output: BasicVector) -> None:
        output[0] = self._restart.state(context.get_discrete_state_vector().value())

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory = discrete_state.get_mutable_value()  # holds the present state until it is written
        desired, q, step = self._desired(context), self._position(context), self._step(context)
        error = length(self._task.error(desired, q))
        if isfinite(error) and all_finite(step):
            seen = self._others is not None and self._others.HasValue(context)
            others = self._others.Eval(context) if self._others is not None and seen else None
            self._restart.remember(memory, desired, q, error, others)
        else:
            memory[:] = self._restart.initial_memory()
