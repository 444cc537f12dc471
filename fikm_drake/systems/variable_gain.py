"""The block that multiplies an error by a gain that varies."""

from math import inf, isfinite

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import LARGEST
from fikm_drake.checks import check_counts, check_positive
from fikm_drake.control.steps import amplify, length
from fikm_drake.systems.valid_port import declare_valid_port


class VariableGain(LeafSystem):
    """A vector times a gain from a port, the vector first shortened to a limit.

    .. pydrake_system::

        name: VariableGain
        input_ports:
        - gain
        - task_error
        output_ports:
        - amplified_error
        - valid

    - **gain** (1) [-].
    - **task_error** (m) [m].
    - **amplified_error** (m) [m]: gain times the error, the error first shortened to the length
      `limit` in its own direction; zeros while an input is not finite.
    - **valid** (1): 1 while every input is finite, else 0.

    Args:
        size: m.
        limit: the largest length of an error that is passed on [m].

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(self, size: int, *, limit: float = inf) -> None:
        super().__init__()
        check_counts(size=size)
        self._limit = check_positive("limit", limit)
        self._zeros = np.zeros(size)
        gain = self.DeclareVectorInputPort("gain", 1)
        error = self.DeclareVectorInputPort("task_error", size)
        self._gain, self._error = gain.Eval, error.Eval
        self.DeclareVectorOutputPort(
            "amplified_error",
            size,
            self._calc,
            prerequisites_of_calc={gain.ticket(), error.ticket()},
        )
        declare_valid_port(self)

    def _calc(self, context: Context, output: BasicVector) -> None:
        gain, error = self._gain(context).item(), self._error(context)
        size = length(error)
        if abs(gain) < LARGEST and isfinite(size):
            output.set_value(amplify(gain, error, size, self._limit))
        else:
            output.set_value(self._zeros)
