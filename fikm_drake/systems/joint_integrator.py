"""The block that adds up joint steps to a joint command."""

from math import inf

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import check_limits, check_period, check_position
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.status import follows
from fikm_drake.systems.start import declare_start, mark_placed
from fikm_drake.systems.valid_port import declare_valid_port


class JointIntegrator(LeafSystem):
    """Adds a joint step to the commanded joint position each cycle, inside the joint limits.

    .. pydrake_system::

        name: JointIntegrator
        input_ports:
        - joint_step
        - estimated_position
        output_ports:
        - position
        - velocity
        - valid
        - following
        - limited
        - deviation

    - **joint_step** (n) [rad or m]: of this cycle.
    - **estimated_position** (n) [rad or m], may stay unconnected: the robot's joints, where the command
      starts in the initialization event. Without it the start is that of `SetPositions`; without
      that `initial_position`, with a warning.
    - **position** (n) [rad or m]: the command, from the state.
    - **velocity** (n) [rad/s or m/s]: the last change of the command over the period, from the state.
    - **valid** (1): 1 while `joint_step` is finite, else 0. A step that is not finite counts as zeros.
    - **limited** (1): 1 while a limit of position, speed or acceleration takes away a part of
      `joint_step`, else 0.
    - **following** (1): 1 while `estimated_position` is within `following_distance` of the command or
      unconnected, else 0.
    - **deviation** (n) [rad or m]: `estimated_position` less the command; zeros where it is unconnected or
      not finite.

    Args:
        lower: lower limits (n,) [rad or m]; −inf for none.
        upper: upper limits (n,) [rad or m]; inf for none.
        period: of the control cycle [s].
        initial_position: (n,) [rad or m]; `SetPositions` changes it in a Context.
        velocity_limits: largest speed, one for all joints or (n,) [rad/s or m/s].
        acceleration_limits: largest acceleration, one for all joints or (n,) [rad/s² or m/s²]; the
            command then brakes before the position limits and before its own end.
        following_distance: how far a joint (n,) that follows can be from its command [rad or m].

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> import fikm_drake as fd
        >>> block = fd.JointIntegrator([-1, -1], [1, 1], period=0.02, initial_position=[0, 0])
        >>> block.GetInputPort("joint_step").size()
        2
    """

    def __init__(
        self,
        lower: ArrayLike,
        upper: ArrayLike,
        *,
        period: float,
        initial_position: ArrayLike,
        velocity_limits: ArrayLike = inf,
        acceleration_limits: ArrayLike = inf,
        following_distance: ArrayLike = inf,
    ) -> None:
        super().__init__()
        self._lower, self._upper = check_limits(lower, upper)
        start = check_position(initial_position, self._lower, self._upper)
        n = len(start)
        self._rate = 1.0 / check_period(period)
        self._limits = JointLimits(
            self._lower,
            self._upper,
            period=period,
            velocity_limits=velocity_limits,
            acceleration_limits=acceleration_limits,
        )
        step = self.DeclareVectorInputPort("joint_step", n)
        self._step = step.Eval
        position = self.DeclareDiscreteState(start)
        velocity = self.DeclareDiscreteState(n)
        self.DeclareStateOutputPort("position", position)
        self.DeclareStateOutputPort("velocity", velocity)
        declare_valid_port(self)
        estimated = self.DeclareVectorInputPort("estimated_position", n)
        self._estimated = estimated
        self._distance = np.broadcast_to(np.asarray(following_distance, dtype=float), (n,))
        declare_start(self, estimated, _start)
        self.DeclareVectorOutputPort(
            "following",
            1,
            self._calc_following,
            prerequisites_of_calc={estimated.ticket(), self.xd_ticket()},
        )
        self.DeclareVectorOutputPort(
            "limited",
            1,
            self._calc_limited,
            prerequisites_of_calc={step.ticket(), self.xd_ticket()},
        )
        self.DeclareVectorOutputPort(
            "deviation",
            n,
            self._calc_deviation,
            prerequisites_of_calc={estimated.ticket(), self.xd_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        set_command(self, context, check_position(position, self._lower, self._upper))

    def _calc_limited(self, context: Context, output: BasicVector) -> None:
        q, velocity = (context.get_discrete_state(i).value() for i in (0, 1))
        step = self._step(context)
        output[0] = all_finite(step) and self._limits.limits(q, step, velocity)

    def _calc_following(self, context: Context, output: BasicVector) -> None:
        command = context.get_discrete_state(0).value()
        known = self._estimated.HasValue(context)
        output[0] = not known or follows(command, self._estimated.Eval(context), self._distance)

    def _calc_deviation(self, context: Context, output: BasicVector) -> None:
        command = context.get_discrete_state(0).value()
        estimated = self._estimated.Eval(context) if self._estimated.HasValue(context) else command
        output.set_value(estimated - command if all_finite(estimated) else np.zeros(len(command)))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        position = discrete_state.get_mutable_value(0)  # holds q until it is written
        velocity = discrete_state.get_mutable_value(1)
        step = self._step(context)
        if not all_finite(step):
            step = np.zeros_like(step)
        after = self._limits.integrate(position, step, velocity)
        velocity[:] = (after - position) * self._rate
        position[:] = after


def set_command(system: LeafSystem, context: Context, position: Array) -> None:
    """Set a block's command, which is the first of its discrete states, at rest: the second.

    Raises:
        RuntimeError: the context is another system's.
    """
    system.ValidateContext(context)
    context.SetDiscreteState(0, position)
    context.SetDiscreteState(1, np.zeros(len(position)))
    mark_placed(context)


def _start(discrete_state: DiscreteValues, position: Array) -> None:
    discrete_state.set_value(0, position)
    discrete_state.set_value(1, np.zeros(len(position)))
