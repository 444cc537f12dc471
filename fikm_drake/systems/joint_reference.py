"""The block between a sampled position command and a faster inner loop."""

from math import floor

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from fikm_drake.laws.steps import all_finite
from fikm_drake.systems.checks import check_period, check_positive, check_sizes
from fikm_drake.systems.joint_integrator import check_position


class JointReference(LeafSystem):
    """First-order hold of a sampled joint command, for an inner loop at a higher rate.

    .. pydrake_system::

        name: JointReference
        input_ports:
        - commanded_position
        - commanded_velocity
        output_ports:
        - desired_state

    - **commanded_position** (n) [rad or m]: new at the start of each period.
    - **commanded_velocity** (n) [rad/s or m/s]: the last change of the command over the period.
    - **desired_state** (2n) [q; v]: on the straight line that reaches the commanded position at the
      end of the period with the commanded velocity; from the state. While an input is not finite the
      position holds and the velocity is zero.

    So the inner loop sees no steps of position, and nobody differentiates. Its state is written
    half a time step before each of the inner loop's, so that it does not matter which of two events
    at the same time comes first.

    Args:
        num_joints: n.
        period: of the position command [s].
        time_step: of the inner loop [s].

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(self, num_joints: int, *, period: float, time_step: float) -> None:
        super().__init__()
        check_sizes(num_joints=num_joints)
        self._period = check_period(period)
        self._time_step = check_positive("time_step", time_step)
        if self._time_step > self._period:
            raise ValueError(f"time_step must be at most the period {period} s, got {time_step!r}")
        self._n = num_joints
        position = self.DeclareVectorInputPort("commanded_position", num_joints)
        velocity = self.DeclareVectorInputPort("commanded_velocity", num_joints)
        self._position, self._velocity = position.Eval, velocity.Eval
        state = self.DeclareDiscreteState(2 * num_joints)
        self.DeclareStateOutputPort("desired_state", state)
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.5 * time_step, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the desired joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: it is not n finite numbers.
            RuntimeError: the context is another system's.
        """
        free = np.full(self._n, np.inf)
        position = check_position(position, -free, free)
        self.ValidateContext(context)
        context.SetDiscreteState(np.concatenate([position, np.zeros(self._n)]))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        position, velocity = self._position(context), self._velocity(context)
        state = discrete_state.get_mutable_value()  # holds the present state until it is written
        if not (all_finite(position) and all_finite(velocity)):
            state[self._n :] = 0.0
            return
        time = context.get_time()
        end = (floor(time / self._period) + 1.0) * self._period
        rest = max(end - time - 0.5 * self._time_step, 0.0)  # from the inner loop's next step
        state[: self._n] = position - rest * velocity
        state[self._n :] = velocity
