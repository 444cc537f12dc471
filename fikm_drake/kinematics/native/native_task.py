"""Error and Jacobian of a task by the native kernel."""

import threading
from collections.abc import Sequence

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel, address, kernel


class NativeTask(threading.local):
    """What a task of turns and offsets of a chain's tool says of a posture.

    The buffers are one set for each thread.

    Args:
        loaded: the kernel.
        packed: the chain, from `SerialChain.packed`.
        num_joints: n.
        rows: which of the six rows [ω; v] count (m,).
        length: of a turn of 1 rad [m]; 0: the target is a vector of the rows' coordinates, else a pose.
    """

    def __init__(
        self, loaded: Kernel, packed: Array, num_joints: int, rows: Sequence[int], length: float
    ) -> None:
        self._made_of = packed, num_joints, tuple(rows), length
        self.options = np.zeros(9)
        self.options[:3] = length > 0.0, length, len(rows)
        self.options[3 : 3 + len(rows)] = rows
        self.packed = packed
        m, n = len(rows), num_joints
        self._target = np.zeros((3, 4) if length else m)
        self._q, self._error, self._J = np.zeros(n), np.zeros(m), np.zeros((m, n))
        self._run = loaded.task
        self._at = tuple(map(address, (self._target, self._q, self._error, self._J)))
        self._chain = address(self.packed), n, address(self.options)

    def __reduce__(self) -> tuple:
        """Pickled as what it was made of: addresses hold in one process only."""
        return native_task, self._made_of

    def error(self, target: Array, q: Array) -> Array:
        """(m,), NaN where an input is not finite; target (3,4) of a pose, or (m,)."""
        self._target[:], self._q[:] = target, q
        at_target, at_q, at_error, _ = self._at
        self._run(*self._chain, at_target, at_q, at_error, None)
        return self._error.copy()

    def jacobian(self, q: Array) -> Array:
        """(m,n), NaN where `q` (n,) is not finite."""
        self._q[:] = q
        at_target, at_q, _, at_J = self._at
        self._run(*self._chain, at_target, at_q, None, at_J)
        return self._J.copy()

    def error_and_jacobian(self, target: Array, q: Array) -> tuple[Array, Array]:
        """Both at once."""
        self._target[:], self._q[:] = target, q
        self._run(*self._chain, *self._at)
        return self._error.copy(), self._J.copy()


def native_task(
    packed: Array, num_joints: int, rows: Sequence[int], length: float
) -> NativeTask | None:
    """The kernel's error and Jacobian, or None: Drake's."""
    loaded = kernel()
    if loaded is None or num_joints > MOST_JOINTS:
        return None
    return NativeTask(loaded, packed, num_joints, rows, length)
