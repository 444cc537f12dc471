"""The block of fuzzy inverse kinematics in integers: a position on a workplane in, joint positions out."""

import copy
from enum import IntEnum
from math import inf

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.checks import check_not_negative, check_period, check_position
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk
from fikm_drake.solvers.workplane.workplane import Workplane

FAR = 1e6
"""Coordinates are held to ± this before they become integers [m]."""


class IntegerFuzzyIkStatus(IntEnum):
    """Value of the `status` port of `IntegerFuzzyIkSystem`."""

    INVALID_INPUT = 0
    """The desired position is NaN or infinite: the last good command holds."""
    INSIDE = 1
    """The command is of the desired position, rounded to whole millimetres."""
    OUTSIDE = 2
    """Beside the rules' rectangle or off the workplane: the command is of the nearest point."""


class IntegerFuzzyIkSystem(LeafSystem):
    """Fuzzy inverse kinematics in integers, sampled like a small processor samples it.

    .. pydrake_system::

        name: IntegerFuzzyIkSystem
        input_ports:
        - desired_position
        output_ports:
        - commanded_position
        - status

    - **desired_position** (3) [m]: x, y, z in the world.
    - **commanded_position** (n) [rad]: the joint command, from the state. While the input is NaN or
      infinite, the last good command. It jumps as the target does; a `SpeedLimiter` makes a way of it.
    - **status** (1): an `IntegerFuzzyIkStatus` of that command, from the state.

    Args:
        ik: the inverse kinematics, in the coordinates of `workplane`.
        workplane: where the workplane lies in the world; it is copied.
        period: of the samples [s].
        height_tolerance: farther than this over or under the workplane counts as outside [m].

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        ik: IntegerFuzzyIk,
        workplane: Workplane,
        *,
        period: float = 0.02,
        height_tolerance: float = 1e-3,
    ) -> None:
        super().__init__()
        workplane.validate()
        self._ik = ik
        self._from_world = copy.deepcopy(workplane).from_world
        self._height_tolerance = 1000 * check_not_negative("height_tolerance", height_tolerance)
        x, y = ik.rules.first, ik.rules.second
        middle, _ = ik.solve((x.low + x.high) // 2, (y.low + y.high) // 2)
        self._desired = self.DeclareVectorInputPort("desired_position", 3).Eval
        position = self.DeclareDiscreteState(ik.to_radians(middle))
        status = self.DeclareDiscreteState([float(IntegerFuzzyIkStatus.INSIDE)])
        self.DeclareStateOutputPort("commanded_position", position)
        self.DeclareStateOutputPort("status", status)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the command (n,) [rad] in this block's context; by default that of the rules' middle.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        self.ValidateContext(context)
        free = np.full(self._ik.num_joints, inf)
        context.SetDiscreteState(0, check_position(position, -free, free))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        desired = self._desired(context)
        if not all_finite(desired):
            discrete_state.set_value(1, [float(IntegerFuzzyIkStatus.INVALID_INPUT)])
            return
        x, y, height = self._from_world(np.clip(desired, -FAR, FAR)).tolist()
        angles, outside = self._ik.solve(round(x), round(y))
        outside = outside or abs(height) > self._height_tolerance
        status = IntegerFuzzyIkStatus.OUTSIDE if outside else IntegerFuzzyIkStatus.INSIDE
        discrete_state.set_value(0, self._ik.to_radians(angles))
        discrete_state.set_value(1, [float(status)])
