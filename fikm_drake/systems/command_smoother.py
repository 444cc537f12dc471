"""The block that keeps limits of jerk."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array
from fikm_drake.checks import check_period, check_position
from fikm_drake.control.jerk_limit import JerkLimit
from fikm_drake.systems.start import declare_start, mark_placed


class CommandSmoother(LeafSystem):
    """Sends out the mean of the last joint commands, which keeps a limit of jerk; see `JerkLimit`.

    .. pydrake_system::

        name: CommandSmoother
        input_ports:
        - command
        - estimated_position
        output_ports:
        - position
        - velocity

    - **command** (n) [rad or m]: of `JointIntegrator`, inside its limits.
    - **estimated_position** (n) [rad or m], may stay unconnected: the robot's joints, where what goes out
      starts in the initialization event. Without it the start is that of `SetPositions`.
    - **position** (n) [rad or m]: the mean of `command` and the ones before.
    - **velocity** (n) [rad/s or m/s]: its last change over the period.

    The command must be finite, as that of `JointIntegrator` is.

    Args:
        limit: see `JerkLimit`.
        period: of the control cycle [s].
        initial_position: (n,) [rad or m]; `SetPositions` changes it in a Context.

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> import fikm_drake as fd
        >>> limit = fd.JerkLimit(
        ...     500.0, period=0.01, velocity_limits=2.0, acceleration_limits=5.0, num_joints=2
        ... )
        >>> block = fd.CommandSmoother(limit, period=0.01, initial_position=[0.0, 0.0])
        >>> limit.cycles, block.GetOutputPort("position").size()
        (2, 2)
    """

    def __init__(self, limit: JerkLimit, *, period: float, initial_position: ArrayLike) -> None:
        super().__init__()
        n = len(limit.accelerations)
        free = np.full(n, np.inf)
        start = check_position(initial_position, -free, free, name="initial_position")
        self._limit, self._shape, self._free = limit, (limit.cycles, n), free
        command = self.DeclareVectorInputPort("command", n)
        self._command = command.Eval
        estimated = self.DeclareVectorInputPort("estimated_position", n)
        self.DeclareDiscreteState(limit.start(start).ravel())
        declare_start(self, estimated, self._start, warns=False)  # the integrator does
        prerequisites = {command.ticket(), self.xd_ticket()}
        for name, calc in (("position", self._calc_position), ("velocity", self._calc_velocity)):
            self.DeclareVectorOutputPort(name, n, calc, prerequisites_of_calc=prerequisites)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set what goes out (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: it is not n finite numbers.
            RuntimeError: the context is another system's.
        """
        position = check_position(position, -self._free, self._free)
        self.ValidateContext(context)
        context.SetDiscreteState(self._limit.start(position).ravel())
        mark_placed(context)

    def _start(self, discrete_state: DiscreteValues, position: Array) -> None:
        discrete_state.set_value(self._limit.start(position).ravel())

    def _memory(self, context: Context) -> Array:
        return context.get_discrete_state_vector().value().reshape(self._shape)

    def _calc_position(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._limit.command(self._memory(context), self._command(context)))

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._limit.velocity(self._memory(context), self._command(context)))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory = discrete_state.get_mutable_value().reshape(self._shape)  # a view
        self._limit.remember(memory, self._command(context))
