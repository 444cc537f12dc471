"""The block between a sampled position command and a faster inner loop."""

from functools import partial
from math import floor

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import (
    check_counts,
    check_period,
    check_position,
    check_positive,
    check_positive_finite,
)
from fikm_drake.control.follower import follow
from fikm_drake.control.jerk_limit import JerkLimit
from fikm_drake.systems.start import declare_start, mark_placed


class JointReference(LeafSystem):
    """Makes a sampled joint command one that an arm can follow, for an inner loop at a higher rate.

    .. pydrake_system::

        name: JointReference
        input_ports:
        - commanded_position
        - commanded_velocity
        - estimated_position
        output_ports:
        - desired_state

    - **commanded_position** (n) [rad or m]: new at the start of each period.
    - **commanded_velocity** (n) [rad/s or m/s]: the last change of the command over the period.
    - **estimated_position** (n) [rad or m], may stay unconnected: the robot's joints, where the
      reference starts in the initialization event. Without it the start is that of `SetPositions`.
    - **desired_state** (2n) [q; v]: follows, within the limits of velocity and acceleration, the
      straight line that reaches the commanded position at the end of the period with the commanded
      velocity (a first-order hold); from the state. While an input is not finite it comes to rest.

    So the inner loop sees no steps of position, and nobody differentiates. Its state is written
    half a time step before each of the inner loop's, so that it does not matter which of two events
    at the same time comes first.

    Args:
        num_joints: n.
        period: of the position command [s].
        time_step: of the inner loop [s].
        velocity_limits: (n,) [rad/s or m/s]; inf for none.
        acceleration_limits: of every joint, finite [rad/s² or m/s²].
        jerk_limits: (n,) [rad/s³ or m/s³], inf for none; what goes out is then the mean of the last states,
            see `JerkLimit`.
        initial_position: (n,) [rad or m]; zeros by default.

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> import fikm_drake as fd
        >>> block = fd.JointReference(
        ...     2, period=0.02, time_step=1e-3, velocity_limits=[2, 2], acceleration_limits=20
        ... )
        >>> block.GetOutputPort("desired_state").size()
        4
    """

    def __init__(
        self,
        num_joints: int,
        *,
        period: float,
        time_step: float,
        velocity_limits: ArrayLike,
        acceleration_limits: float,
        jerk_limits: ArrayLike = np.inf,
        initial_position: ArrayLike | None = None,
    ) -> None:
        super().__init__()
        check_counts(num_joints=num_joints)
        self._period = check_period(period)
        self._time_step = check_positive("time_step", time_step)
        if self._time_step > self._period:
            raise ValueError(f"time_step must be at most the period {period} s, got {time_step!r}")
        speed = np.array(velocity_limits, dtype=float)
        if speed.shape != (num_joints,) or not (speed > 0.0).all():
            raise ValueError(
                f"velocity_limits must be {num_joints} positive numbers, got {speed.tolist()}"
            )
        check_positive_finite("acceleration_limits", acceleration_limits, "rad/s² or m/s²")
        self._n = num_joints
        acceleration: float | Array = float(acceleration_limits)
        self._jerk_limit = None
        if np.isfinite(jerk_limits).any():
            self._jerk_limit = JerkLimit(
                jerk_limits,
                period=self._time_step,
                velocity_limits=speed,
                acceleration_limits=acceleration_limits,
                num_joints=num_joints,
            )
            acceleration = self._jerk_limit.accelerations
        self._follow = partial(follow, step=self._time_step, speed=speed, acceleration=acceleration)
        position = self.DeclareVectorInputPort("commanded_position", num_joints)
        velocity = self.DeclareVectorInputPort("commanded_velocity", num_joints)
        self._position, self._velocity = position.Eval, velocity.Eval
        start = np.zeros(num_joints) if initial_position is None else initial_position
        free = np.full(num_joints, np.inf)
        start = check_position(start, -free, free, name="initial_position")
        state = self.DeclareDiscreteState(np.concatenate([start, np.zeros(num_joints)]))
        if self._jerk_limit:
            self.DeclareDiscreteState(self._jerk_limit.start(start).ravel())
        estimated = self.DeclareVectorInputPort("estimated_position", num_joints)
        declare_start(self, estimated, self._start)
        if self._jerk_limit:
            self.DeclareVectorOutputPort(
                "desired_state",
                2 * num_joints,
                self._calc_smooth,
                prerequisites_of_calc={self.xd_ticket()},
            )
        else:
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
        context.SetDiscreteState(0, np.concatenate([position, np.zeros(self._n)]))
        if self._jerk_limit:
            context.SetDiscreteState(1, self._jerk_limit.start(position).ravel())
        mark_placed(context)

    def _start(self, discrete_state: DiscreteValues, position: Array) -> None:
        discrete_state.set_value(0, np.concatenate([position, np.zeros(self._n)]))
        if self._jerk_limit:
            discrete_state.set_value(1, self._jerk_limit.start(position).ravel())

    def _calc_smooth(self, context: Context, output: BasicVector) -> None:
        limit, n = self._jerk_limit, self._n
        if limit is not None:
            newest = context.get_discrete_state(0).value()[:n]
            memory = context.get_discrete_state(1).value().reshape(-1, n)
            output.get_mutable_value()[:n] = limit.command(memory, newest)
            output.get_mutable_value()[n:] = limit.velocity(memory, newest)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        n = self._n
        position, velocity = self._position(context), self._velocity(context)
        state = discrete_state.get_mutable_value(0)  # holds the present state until it is written
        if self._jerk_limit:
            memory = discrete_state.get_mutable_value(1).reshape(-1, n)  # a view
            self._jerk_limit.remember(memory, state[:n])
        if all_finite(position) and all_finite(velocity):
            time = context.get_time()
            end = (floor(time / self._period) + 1.0) * self._period
            rest = max(end - time - 0.5 * self._time_step, 0.0)  # from the inner loop's next step
            target, target_velocity = position - rest * velocity, velocity
        else:
            target, target_velocity = state[:n].copy(), np.zeros(n)
        state[:n], state[n:] = self._follow(state[:n], state[n:], target, target_velocity)
