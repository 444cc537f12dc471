"""The block that makes a way of a joint command that jumps."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import check_period, check_position, check_positive
from fikm_drake.control.follower import straight_toward
from fikm_drake.systems.start import declare_start, mark_placed


class SpeedLimiter(LeafSystem):
    """Goes straight toward a joint command, no joint faster than its limit; behind blocks that may jump.

    .. pydrake_system::

        name: SpeedLimiter
        input_ports:
        - commanded_position
        - estimated_position
        output_ports:
        - commanded_position
        - limited

    - **commanded_position** (n) in [rad or m]: such as of `RedundancyIk`, `LabVoltIk` or
      `IntegerFuzzyIkSystem`, read once a period.
    - **estimated_position** (n) [rad or m], may stay unconnected: the robot's joints, where the output
      starts in the initialization event. Without it the start is that of `SetPositions`.
    - **commanded_position** (n) out [rad or m]: from the state; the input of a period ago where the limits
      leave it, else on the straight line of joint space there. While the input is not finite it stays.
    - **limited** (1): 1 while it is still on the way there, or the input is not finite, else 0; from the
      state.

    Args:
        velocity_limits: (n,) [rad/s or m/s]; inf for none.
        period: how often the command is read [s].
        initial_position: (n,) [rad or m]; zeros by default.

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> import fikm_drake as fd
        >>> fd.SpeedLimiter([1.0, 2.0], period=0.01).GetOutputPort("commanded_position").size()
        2
    """

    def __init__(
        self,
        velocity_limits: ArrayLike,
        *,
        period: float,
        initial_position: ArrayLike | None = None,
    ) -> None:
        super().__init__()
        limits = np.atleast_1d(np.asarray(velocity_limits, dtype=float))
        if limits.ndim != 1 or limits.size == 0:
            raise ValueError(f"velocity_limits must be a vector (n), got {limits.tolist()}")
        for limit in limits.tolist():
            check_positive("velocity_limits", limit)
        self._most = check_period(period) * limits
        self._free = np.full(len(limits), np.inf)
        start = np.zeros(len(limits)) if initial_position is None else initial_position
        start = check_position(start, -self._free, self._free, name="initial_position")
        self._command = self.DeclareVectorInputPort("commanded_position", len(limits)).Eval
        estimated = self.DeclareVectorInputPort("estimated_position", len(limits))
        position = self.DeclareDiscreteState(start)
        limited = self.DeclareDiscreteState([0.0])
        self.DeclareStateOutputPort("commanded_position", position)
        self.DeclareStateOutputPort("limited", limited)
        declare_start(self, estimated, self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the output (n,) [rad or m] in this block's context.

        Raises:
            ValueError: it is not n finite numbers.
            RuntimeError: the context is another system's.
        """
        position = check_position(position, -self._free, self._free)
        self.ValidateContext(context)
        context.SetDiscreteState(0, position)
        mark_placed(context)

    def _start(self, discrete_state: DiscreteValues, position: Array) -> None:
        discrete_state.set_value(0, position)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        command = self._command(context)
        if not all_finite(command):
            discrete_state.set_value(1, [1.0])
            return
        position = context.get_discrete_state(0).value()
        after = straight_toward(position, command, self._most)
        discrete_state.set_value(0, after)
        discrete_state.set_value(1, [float(not np.array_equal(after, command))])
