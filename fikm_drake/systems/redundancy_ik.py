"""The block that keeps a redundant arm in the middle of what its limits leave."""

from numpy.typing import ArrayLike
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from fikm_drake.checks import check_period, check_position
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.redundancy.resolution import ResolutionStatus


class RedundancyIk(LeafSystem):
    """Joint positions of a redundant arm for a desired point or pose, in the middle of the feasible region.

    .. pydrake_system::

        name: RedundancyIk
        input_ports:
        - desired_position
        output_ports:
        - commanded_position
        - bounds
        - status

    - **desired_position** (m) [m]: the coordinates of the tool that the resolver's task counts (x and y
      of a planar 3R), in the arm's base frame, read once a period. For tasks with orientation
      **desired_pose** is in its place, a RigidTransform of the tool in the base frame.
    - **commanded_position** (n) [rad or m]: inside the limits, from the state.
    - **bounds** (2) [rad or m]: lower and upper bound of the resolver's joint at the last good point,
      from the state.
    - **status** (1): `ResolutionStatus` of the last period, from the state.

    While the point is infeasible or not finite, position and bounds stay those of the last good point, and
    `status` says so. The arm may then have some way to go to the first good point: put a
    `SpeedLimiter` behind this block where that happens. Without learned bounds each period traces
    a self-motion, which takes 20 ms and more: for simulation, not for control.

    Args:
        resolver: of the arm.
        period: how often the input is read [s].
        initial_position: (n,) [rad or m] until the first good point; by default the nearest to zero
            inside the limits.

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
        task = resolver.task
        self._turns = task.turns
        if self._turns:
            port = self.DeclareAbstractInputPort("desired_pose", Value(RigidTransform()))
        else:
            port = self.DeclareVectorInputPort("desired_position", len(task.coordinates))
        self._desired = port.Eval
        at = start[resolver.joint]
        self.DeclareStateOutputPort("commanded_position", self.DeclareDiscreteState(start))
        self.DeclareStateOutputPort("bounds", self.DeclareDiscreteState([at, at]))
        status = self.DeclareDiscreteState([float(ResolutionStatus.SOLVED)])
        self.DeclareStateOutputPort("status", status)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        desired = self._desired(context)
        point = desired.GetAsMatrix4() if self._turns else desired
        found = self._resolver.resolve(point[None])
        discrete_state.set_value(2, found.status.astype(float))
        if found.success[0]:
            discrete_state.set_value(0, found.q[0])
            discrete_state.set_value(1, [found.lower[0], found.upper[0]])
