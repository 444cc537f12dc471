"""The block that chooses the gain and sees oscillation."""

from collections.abc import Callable
from math import inf

from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts, check_period
from fikm_drake.control.gain_supervision import MAX_JOINTS, GainSupervision
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.steps import length
from fikm_drake.systems.valid_port import declare_valid_port


class GainSupervisor(LeafSystem):
    """Fuzzy gain and detection of oscillation (Xu & Nechyba 1993, section 2.7, Table I).

    .. pydrake_system::

        name: GainSupervisor
        input_ports:
        - task_error
        - joint_step
        output_ports:
        - gain
        - oscillating
        - calm
        - damping
        - valid

    - **task_error** (m) [m]: the error of this cycle; only its length counts.
    - **joint_step** (n) [rad or m]: the joint step of this cycle; it enters the state at the cycle's
      end, so `gain` does not feed through from it.
    - **gain** (1) [-]: K of Table I by the error over its average of the last cycles and by the
      sign changes of the last joint steps; that of a big error while `task_error` is not finite.
      Multiplied by `calm`.
    - **oscillating** (1): 1 while the steps of a joint change sign too often, else 0.
    - **calm** (1) [-]: factor of the gain, 1 until a joint oscillates, see `GainSupervision`.
    - **damping** (1) [-]: for a law that takes it, 0 while `calm` is 1.
    - **valid** (1): 1 while every input is finite, else 0. What is not finite is not remembered.

    Args:
        num_rows: m.
        num_joints: n.
        period: of the control cycle [s].
        config: the constants of section 2.7.
        error_limit: a longer error counts as this long [m].

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
        error_limit: float = inf,
    ) -> None:
        super().__init__()
        check_counts(num_rows=num_rows, num_joints=num_joints)
        if num_joints > MAX_JOINTS:
            raise ValueError(f"num_joints must be at most {MAX_JOINTS}, got {num_joints}")
        self._supervision = GainSupervision(config, error_limit=error_limit)
        error = self.DeclareVectorInputPort("task_error", num_rows)
        step = self.DeclareVectorInputPort("joint_step", num_joints)
        self._error, self._step = error.Eval, step.Eval
        self.DeclareDiscreteState(self._supervision.initial_memory())
        self.DeclareVectorOutputPort(
            "gain",
            1,
            self._calc_gain,
            prerequisites_of_calc={error.ticket(), self.xd_ticket()},
        )
        supervision = self._supervision
        self._declare("oscillating", supervision.oscillating)
        self._declare("calm", supervision.calm)
        self._declare("damping", supervision.damping)
        declare_valid_port(self)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def _calc_gain(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state_vector().value()
        output[0] = self._supervision.gain(memory, length(self._error(context)))

    def _declare(self, name: str, read: Callable[[Array], float]) -> None:
        """An output that is read from the memory."""

        def calc(context: Context, output: BasicVector) -> None:
            output[0] = read(context.get_discrete_state_vector().value())

        self.DeclareVectorOutputPort(name, 1, calc, prerequisites_of_calc={self.xd_ticket()})

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory = discrete_state.get_mutable_value()  # holds the present state until it is written
        self._supervision.remember(memory, length(self._error(context)), self._step(context))
