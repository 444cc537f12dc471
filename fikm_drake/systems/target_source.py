"""The block that says where the tool shall be."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import Array


class TargetSource(LeafSystem):
    """A target as a function of time, a position or a pose.

    .. pydrake_system::

        name: TargetSource
        input_ports: []
        output_ports:
        - desired_position

    - **desired_position** (m) [m]: of the time; for a function of poses **desired_pose** is in its place, a
      RigidTransform X_WE.

    The function is called at the times that Drake asks for, also between control cycles.

        source = fd.TargetSource(lambda t: np.array([0.4, 0.1 * np.sin(t), 0.5]))

    Args:
        target: of the time [s]: (m,) [m], or a RigidTransform.

    Raises:
        ValueError: the target at 0 s is neither.
    """

    def __init__(self, target: Callable[[float], ArrayLike | RigidTransform]) -> None:
        super().__init__()
        first = target(0.0)
        self._target = target
        needs = {self.time_ticket()}
        if isinstance(first, RigidTransform):
            self.DeclareAbstractOutputPort(
                "desired_pose", lambda: Value(RigidTransform()), self._calc_pose, needs
            )
            return
        size = np.shape(first)
        if len(size) != 1 or not size[0]:
            raise ValueError(f"a target must be (m,) or a RigidTransform, at 0 s it is {first!r}")
        self.DeclareVectorOutputPort("desired_position", size[0], self._calc, needs)

    def _calc(self, context: Context, output: BasicVector) -> None:
        values: Array = np.asarray(self._target(context.get_time()), dtype=float)
        output.set_value(values)

    def _calc_pose(self, context: Context, output: Value) -> None:
        output.set_value(self._target(context.get_time()))
