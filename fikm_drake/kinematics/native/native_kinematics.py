"""Forward kinematics and Jacobians by the native kernel."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel, address, kernel


class NativeKinematics:
    """Poses and Jacobians of a chain.

    Args:
        loaded: the kernel.
        packed: the chain, from `FramesOfPostures.packed`.
        num_joints: n.
    """

    def __init__(self, loaded: Kernel, packed: Array, num_joints: int) -> None:
        self._run, self._n = loaded.kinematics, num_joints
        self._packed = np.concatenate([packed, np.zeros(3 * num_joints)])
        self._chain = address(self._packed)

    def __reduce__(self) -> tuple:
        """Pickled as what it was made of: addresses hold in one process only."""
        return native_kinematics, (self._packed[: -3 * self._n], self._n)

    def poses(self, q: Array) -> Array:
        """(…,4,4) at `q` (…,n), contiguous."""
        X = np.empty((*q.shape[:-1], 4, 4))
        self._run(self._chain, self._n, q.size // self._n, address(q), address(X), None)
        return X

    def jacobians(self, q: Array) -> Array:
        """(…,6,n), rows [ω; v], at `q` (…,n), contiguous."""
        J = np.empty((*q.shape[:-1], 6, self._n))
        self._run(self._chain, self._n, q.size // self._n, address(q), None, address(J))
        return J


def native_kinematics(packed: Array, num_joints: int) -> NativeKinematics | None:
    """The kernel's kinematics of a chain, or None: numpy's."""
    loaded = kernel()
    if loaded is None or num_joints > MOST_JOINTS:
        return None
    return NativeKinematics(loaded, packed, num_joints)
