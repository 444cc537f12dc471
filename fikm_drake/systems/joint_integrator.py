"""The block that adds up joint steps to a joint command."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.laws.steps import integrate, is_limited
from fikm_drake.systems.checks import check_period
from fikm_drake.systems.valid_port import declare_valid_port


class JointIntegrator(LeafSystem):
    """Adds a joint step to the commanded joint position each cycle, inside the joint limits.

    .. pydrake_system::

        name: JointIntegrator
        input_ports:
        - joint_step
        output_ports:
        - position
        - velocity
        - valid
        - limited

    - **joint_step** (n) [rad or m]: of this cycle.
    - **position** (n) [rad or m]: the command, from the state.
    - **velocity** (n) [rad/s or m/s]: the last change of the command over the period, from the state.
    - **valid** (1): 1 while the input is finite, else 0. An input that is not finite changes nothing.
    - **limited** (1): 1 while a joint limit takes away a part of `joint_step`, else 0.

    Args:
        lower: lower limits (n,) [rad or m]; −inf for none.
        upper: upper limits (n,) [rad or m]; inf for none.
        period: of the control cycle [s].
        initial_position: (n,) [rad or m]; `SetPositions` changes it in a Context.

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        lower: ArrayLike,
        upper: ArrayLike,
        *,
        period: float,
        initial_position: ArrayLike,
    ) -> None:
        super().__init__()
        self._lower, self._upper = check_limits(lower, upper)
        n = len(self._lower)
        self._rate = 1.0 / check_period(period)
        self._step = self.DeclareVectorInputPort("joint_step", n)
        position = self.DeclareDiscreteState(check_position(initial_position, n))
        velocity = self.DeclareDiscreteState(n)
        self.DeclareStateOutputPort("position", position)
        self.DeclareStateOutputPort("velocity", velocity)
        declare_valid_port(self)
        self.DeclareVectorOutputPort(
            "limited",
            1,
            self._calc_limited,
            prerequisites_of_calc={self._step.ticket(), self.xd_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this block's context, at rest.

        Raises:
            ValueError: naming the bad value.
        """
        n = len(self._lower)
        context.SetDiscreteState(0, check_position(position, n))
        context.SetDiscreteState(1, np.zeros(n))

    def _calc_limited(self, context: Context, output: BasicVector) -> None:
        q = context.get_discrete_state(0).value().tolist()
        output[0] = is_limited(q, self._step.Eval(context).tolist(), self._lower, self._upper)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        position = discrete_state.get_mutable_value(0)  # holds q until we write it
        q = position.tolist()
        after = integrate(q, self._step.Eval(context).tolist(), self._lower, self._upper)
        rate = self._rate
        position[:] = after
        discrete_state.get_mutable_value(1)[:] = [(b - a) * rate for a, b in zip(q, after)]


def check_limits(lower: ArrayLike, upper: ArrayLike) -> tuple[list[float], list[float]]:
    """Lower and upper limits as lists; ValueError unless they are vectors with lower < upper."""
    lower, upper = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    if lower.ndim != 1 or lower.shape != upper.shape or not lower.size:
        raise ValueError(f"lower and upper must be (n,), got {lower.shape} and {upper.shape}")
    if not (lower < upper).all():
        raise ValueError(f"lower must be less than upper, got {lower.tolist()}, {upper.tolist()}")
    return lower.tolist(), upper.tolist()


def check_position(position: ArrayLike, num_joints: int) -> np.ndarray:
    """The joint position (n,); ValueError unless it has n finite numbers."""
    position = np.asarray(position, dtype=float)
    if position.shape != (num_joints,) or not np.isfinite(position).all():
        raise ValueError(
            f"joint position must be {num_joints} finite numbers, got {position.tolist()}"
        )
    return position
