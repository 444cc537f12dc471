"""The fuzzy mapping's step of one Jacobian by the native kernel."""

import threading

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel, address

MOST_ROWS = 6


class NativeStep(threading.local):
    """A step into buffers whose addresses are known: to ask for one takes as long as the step.

    A thread has buffers of its own.

    Args:
        loaded: the kernel.
    """

    def __init__(self, loaded: Kernel) -> None:
        self._step = loaded.step
        self._buffers: dict[tuple[int, int], tuple] = {}

    def __call__(
        self,
        J: Array,
        dr: Array,
        row_floor: float,
        column_floor: float,
        zero_threshold: float,
        damping: float,
        error_damping: float,
        extra: float,
        growth: float,
    ) -> Array | None:
        """The paper's law, or with a `growth` the direct solve as far as y grows no more than that.

        `extra` is the supervisor's damping; in the paper's law a floor of the rows.

        Returns:
            (n,), or None: numpy has to do it.
        """
        m, n = J.shape
        if m > MOST_ROWS or n > MOST_JOINTS:
            return None
        if (m, n) not in self._buffers:
            arrays = np.zeros((m, n)), np.zeros(m), np.zeros(n)
            self._buffers[m, n] = (*arrays, *map(address, arrays))
        rows, error, step, at_rows, at_error, at_step = self._buffers[m, n]
        rows[:], error[:] = J, dr
        failed = self._step(
            *(m, n, at_rows, at_error),
            *(row_floor, column_floor, zero_threshold, damping, error_damping),
            *(extra, growth, at_step),
        )
        return None if failed else step.copy()
