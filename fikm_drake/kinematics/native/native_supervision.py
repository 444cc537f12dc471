"""The gain supervisor by the native kernel."""

import threading

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import (
    MOST_JOINTS,
    Kernel,
    address,
    kernel,
    writable_address,
)

MOST_COORDINATES, MOST_ROWS = 12, 6


class NativeSupervision(threading.local):
    """The gain and the memory of `control.GainSupervision`; arguments and results are its.

    The buffers are one set for each thread.

    Args:
        loaded: the kernel.
        options: as `supervision.h` lists them; rows, joints and coordinates first.
        size: of the memory.
    """

    def __init__(self, loaded: Kernel, options: Array, size: int) -> None:
        self.options = options
        m, n, c = map(int, options[:3])
        self._size = size
        self._memory = np.zeros(size)
        self._error, self._step = np.zeros(m), np.zeros(n)
        self._target, self._deviation = np.zeros(c), np.zeros(n)
        self._seen = np.zeros(3 + 2 * n)
        self._gain = loaded.gain
        self._turns, self._motion = loaded.remember_turns, loaded.remember_motion
        self._at_options, self._at_memory = address(options), address(self._memory)
        inputs = self._seen, self._error, self._step, self._target, self._deviation
        self._at = tuple(map(address, inputs))

    def __reduce__(self) -> tuple:
        """Pickled as what it was made of: addresses hold in one process only."""
        return native_supervision, (self.options, self._size)

    def gain(self, memory: Array, error: float) -> float:
        """Of an error of this length [m]."""
        self._memory[:] = memory  # which may be read-only
        return self._gain(self._at_memory, self._at_options, error)

    def remember_turns(self, memory: Array, error: Array, joint_step: Array) -> bool:
        """True if `remember_motion` is to follow, at once and in this thread."""
        self._error[:], self._step[:] = error, joint_step
        seen, at_error, at_step, _, _ = self._at
        return bool(
            self._turns(writable_address(memory), self._at_options, at_error, at_step, seen)
        )

    def remember_motion(
        self, memory: Array, error: Array, target: Array, deviation: Array | None
    ) -> None:
        """After `remember_turns`."""
        self._error[:], self._target[:] = error, target
        seen, at_error, _, at_target, at_deviation = self._at
        if deviation is not None:
            self._deviation[:] = deviation
        self._motion(
            *(writable_address(memory), self._at_options, seen, at_error, at_target),
            None if deviation is None else at_deviation,
        )


def native_supervision(options: Array, size: int) -> NativeSupervision | None:
    """The kernel's supervisor, or None: numpy's."""
    loaded = kernel()
    rows, joints, coordinates = options[:3].tolist()
    fits = rows <= MOST_ROWS and joints <= MOST_JOINTS and coordinates <= MOST_COORDINATES
    return NativeSupervision(loaded, options, size) if loaded and fits else None
