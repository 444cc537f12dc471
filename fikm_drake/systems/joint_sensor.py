"""The block between a robot's joints and what a controller gets to know of them."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, LeafSystem, State

from fikm_drake.checks import check_counts, check_finites, check_not_negative, check_period


class JointSensor(LeafSystem):
    """Measures joints with noise, late, at a rate of its own.

    .. pydrake_system::

        name: JointSensor
        input_ports:
        - position
        output_ports:
        - estimated_position

    - **position** (n) [rad or m]: of the robot.
    - **estimated_position** (n), same unit: the newest sample that has arrived, from the state. Before the
      first has, what `SetPositions` said.

    A sample is taken each period; its noise is a function of the seed and of the sample's number, so that
    a run can be repeated.

    Args:
        num_joints: n.
        period: between samples [s].
        delay: until a sample arrives, rounded to whole periods [s].
        noise: standard deviation of each joint's samples, one number or (n,) [rad or m].
        seed: of the noise.

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        num_joints: int,
        *,
        period: float,
        delay: float = 0.0,
        noise: ArrayLike = 0.0,
        seed: int = 0,
    ) -> None:
        super().__init__()
        check_counts(num_joints=num_joints)
        check_counts(least=0, seed=seed)
        self._n, self._period, self._seed = num_joints, check_period(period), int(seed)
        self._noise = np.broadcast_to(np.array(noise, dtype=float), num_joints)
        for value in np.unique(self._noise):
            check_not_negative("noise", float(value))
        self._late = round(check_not_negative("delay", delay) / self._period)
        self._position = self.DeclareVectorInputPort("position", num_joints).Eval
        self.DeclareDiscreteState((self._late + 1) * num_joints)
        self.DeclareVectorOutputPort(
            "estimated_position",
            num_joints,
            lambda context, output: output.set_value(
                context.get_discrete_state_vector().value()[: self._n]
            ),
            {self.xd_ticket()},
        )
        # Unrestricted updates come before discrete ones: a controller's cycle sees the sample of its time.
        self.DeclarePeriodicUnrestrictedUpdateEvent(self._period, 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set what is measured until the first sample arrives (n,) [rad or m].

        Raises:
            ValueError: it is not n finite numbers.
            RuntimeError: the context is another system's.
        """
        self.ValidateContext(context)
        position = check_finites("position", position, self._n, "rad or m")
        context.SetDiscreteState(np.tile(position, self._late + 1))

    def _update(self, context: Context, state: State) -> None:
        sample = self._position(context)
        if self._noise.any():
            number = round(context.get_time() / self._period)
            random = np.random.default_rng([self._seed, number])
            sample = sample + self._noise * random.standard_normal(self._n)
        samples = state.get_mutable_discrete_state().get_mutable_value()
        samples[:] = np.concatenate([samples[self._n :], sample])
