"""The block that chooses the gain and sees oscillation."""

from collections.abc import Callable
from math import inf

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts, check_period
from fikm_drake.control.gain_supervision import GainSupervision
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.steps import length
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.systems.valid_port import declare_valid_port


class GainSupervisor(LeafSystem):
    """Fuzzy gain and detection of oscillation (Xu & Nechyba 1993, section 2.7, Table I).

    .. pydrake_system::

        name: GainSupervisor
        input_ports:
        - task_error
        - joint_step
        - target
        - deviation
        output_ports:
        - gain
        - oscillating
        - oscillating_joint
        - calm
        - calmed
        - damping
        - valid

    - **task_error** (m) [m]: the error of this cycle.
    - **joint_step** (n) [rad or m]: the joint step of this cycle as it is done, less what limits take
      away; it enters the state at the cycle's end, so `gain` does not feed through from it.
    - **target**: as the task takes it, without one a vector (m) [m], so that the block knows what of the
      error's jitter is the target's; unconnected it counts as a target that rests.
    - **deviation** (n) [rad or m], may stay unconnected: of the measured joints from their command, where
      they are in the loop.
    - **gain** (1) [-]: K of Table I by the error over its average of the last cycles and by the
      sign changes of the last joint steps; that of a big error while `task_error` is not finite.
      Multiplied by `calm`.
    - **oscillating** (1): 1 while the steps of a joint change sign too often and are not tiny, else 0.
    - **oscillating_joint** (1): the joint that oscillates, or did before the arm was calmed; −1: none.
    - **calm** (1) [-]: factor of the gain, 1 until a joint oscillates, see `GainSupervision`.
    - **calmed** (1): 1 while the arm rests because the gain is calmed, else 0.
    - **damping** (1) [-]: for a law that takes it, 0 while `calm` is 1.
    - **valid** (1): 1 while every input is finite, else 0. What is not finite is not remembered.

    Args:
        num_rows: m.
        num_joints: n.
        period: of the control cycle [s].
        config: the constants of section 2.7.
        task: of the error, for the target's port; None: the target is a vector (m).
        error_limit: a longer error counts as this long [m].
        tolerance: within this an error needs no calm [m].
        damped: the law takes the damping, which then comes before the gain.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        num_rows: int,
        num_joints: int,
        *,
        period: float,
        config: GainSupervisorConfig | None = None,
        task: TaskKinematics | None = None,
        error_limit: float = inf,
        tolerance: float = 0.0,
        damped: bool = False,
    ) -> None:
        super().__init__()
        check_counts(num_rows=num_rows, num_joints=num_joints)
        num_coordinates = num_rows if task is None else task.num_coordinates
        self._supervision = GainSupervision(
            num_rows,
            num_joints,
            config,
            num_coordinates=num_coordinates,
            error_limit=error_limit,
            tolerance=tolerance,
            damped=damped,
        )
        error = self.DeclareVectorInputPort("task_error", num_rows)
        step = self.DeclareVectorInputPort("joint_step", num_joints)
        if task is None:
            self._target = self.DeclareVectorInputPort("target", num_rows)
        else:
            self._target = task.declare_target(self, "target")
        self._coordinates = task.target_coordinates if task else np.asarray
        self._deviation = self.DeclareVectorInputPort("deviation", num_joints)
        self._error, self._step = error.Eval, step.Eval
        self.DeclareDiscreteState(self._supervision.initial_memory())
        # From the state, which costs nothing: the law asks in every cycle.
        damping = self.DeclareDiscreteState(1)
        self.DeclareVectorOutputPort(
            "gain",
            1,
            self._calc_gain,
            prerequisites_of_calc={error.ticket(), self.xd_ticket()},
        )
        supervision = self._supervision
        self._declare("oscillating", supervision.oscillating)
        self._declare("oscillating_joint", supervision.oscillating_joint)
        self._declare("calm", supervision.calm)
        self._declare("calmed", supervision.calmed)
        self.DeclareStateOutputPort("damping", damping)
        declare_valid_port(self)
        self._unknown = np.zeros(num_coordinates)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def _calc_gain(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(0).value()
        output[0] = self._supervision.gain(memory, length(self._error(context)))

    def _declare(self, name: str, read: Callable[[Array], float]) -> None:
        """An output that is read from the memory."""

        def calc(context: Context, output: BasicVector) -> None:
            output[0] = read(context.get_discrete_state(0).value())

        self.DeclareVectorOutputPort(name, 1, calc, prerequisites_of_calc={self.xd_ticket()})

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory = discrete_state.get_mutable_value(0)  # holds the present state until it is written
        error = self._error(context)
        watched = self._supervision.remember_turns(memory, error, self._step(context))
        if not watched:
            return
        port = self._target
        target = self._unknown
        if port.HasValue(context):
            target = self._coordinates(port.Eval(context))
        port = self._deviation
        deviation = port.Eval(context) if port.HasValue(context) else None
        self._supervision.remember_motion(memory, watched, error, target, deviation)
        discrete_state.get_mutable_value(1)[0] = self._supervision.damping(memory)
