"""The block that keeps a redundant planar arm in the middle of what its limits leave."""

from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.redundancy.resolution import ResolutionStatus
from fikm_drake.systems.checks import check_period
from fikm_drake.systems.joint_integrator import check_position


class RedundancyIk(LeafSystem):
    """Joint positions of a planar 3R arm for a desired point, in the middle of the feasible region.

    .. pydrake_system::

        name: RedundancyIk
        input_ports:
        - desired_position
        output_ports:
        - commanded_position
        - bounds
        - status

    - **desired_position** (2) [m]: x and y of the tool in the arm's base frame, read once a period.
    - **commanded_position** (3) [rad]: inside the limits, from the state.
    - **bounds** (2) [rad]: lower and upper bound of joint 1 at the last good point, from the state.
    - **status** (1): `ResolutionStatus` of the last period, from the state.

    While the point is infeasible or not finite, position and bounds stay those of the last good point, and
    `status` says so. The arm may then have some way to go to the first good point: a block that
    limits speed belongs behind this one where that happens.

    Args:
        resolver: of the arm.
        period: how often the input is read [s].
        initial_position: (3,) [rad] until the first good point; by default the nearest to zero inside the
            limits.

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        resolver: RedundancyResolver,
        *,
        period: float,
        initial_position: ArrayLike | None = None,
    ) -> None:
        super().__init__()
        self._resolver = resolver
        arm = resolver.arm
        start = arm.default_position if initial_position is None else initial_position
        start = check_position(start, arm.lower, arm.upper)
        self._point = self.DeclareVectorInputPort("desired_position", 2).Eval
        self.DeclareStateOutputPort("commanded_position", self.DeclareDiscreteState(start))
        self.DeclareStateOutputPort("bounds", self.DeclareDiscreteState([start[0], start[0]]))
        status = self.DeclareDiscreteState([float(ResolutionStatus.RESOLVED)])
        self.DeclareStateOutputPort("status", status)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        found = self._resolver.resolve(self._point(context)[None])
        discrete_state.set_value(2, found.status.astype(float))
        if found.success[0]:
            discrete_state.set_value(0, found.q[0])
            discrete_state.set_value(1, [found.lower[0], found.upper[0]])
