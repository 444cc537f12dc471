"""Newton's method on curves of self-motion by the native kernel."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import Kernel, address

MOST = 256
"""Points that are walked at once."""


class CurveOptions(NamedTuple):
    """The constants of `curve.h`, in its order."""

    iterations: int
    converged: float
    least_cosine: float
    least_step: float
    rounding: float
    search_steps: int
    longest: float
    found: float
    damping: float


class Stride(NamedTuple):
    """Points of a walk."""

    q: Array
    """(K,k)."""
    tangents: Array
    """(K,k)."""
    step: float
    """The next one."""


class NativeCurve:
    """The curve of postures of a chain that hold its tool at a target.

    Args:
        loaded: the kernel.
        packed: the chain, from `SerialChain.packed`.
        q: (n,) positions; those of joints that do not move stay.
        moving: (k,) indices of the joints that move.
        rows: (k−1,6) the task, of rotations [rad] and offsets [m].
        target: (4,4) pose of the tool [m].
        options: constants.
    """

    def __init__(
        self,
        loaded: Kernel,
        packed: Array,
        q: Array,
        moving: NDArray[np.intp],
        rows: Array,
        target: Array,
        options: CurveOptions,
    ) -> None:
        self._kernel, self._k = loaded, len(moving)
        goal = np.concatenate([target[:3, :3].T.ravel(), target[:3, 3]])
        # The kernel keeps their addresses.
        self._arrays = [np.ascontiguousarray(a, dtype=float) for a in (packed, rows, goal, options)]
        self._q, self._moving = np.array(q, dtype=float), np.array(moving, dtype=np.int64)
        chain, *addresses, constants = map(address, self._arrays)
        turns = int(np.any(rows[:, :3]))
        joints = (len(q), address(self._moving), self._k, turns)
        self._curve = (chain, *joints, *addresses, address(self._q), constants)
        self._point, self._tangent = np.empty(self._k), np.empty(self._k)
        self._at = address(self._point), address(self._tangent)

    def newton(self, q: Array, row: Array, value: float) -> tuple[Array, Array, int] | None:
        """The point near `q` with row · q = value, its tangent and orientation; None: no success."""
        self._point[:], row = q, np.ascontiguousarray(row)
        found = self._kernel.newton(*self._curve, self._at[0], address(row), value, self._at[1])
        return (self._point.copy(), self._tangent.copy(), found) if found else None

    def arrive(self, q: Array) -> Array | None:
        """Where damped steps from `q` arrive near the curve, if they do."""
        self._point[:] = q
        return self._point.copy() if self._kernel.arrive(*self._curve, self._at[0]) else None

    def stride(
        self,
        before: tuple[Array, Array],
        here: tuple[Array, Array],
        orientation: int,
        walls: Array,
        start: Array,
        longest: float,
        step: float,
    ) -> Stride:
        """Walk on as long as no limit is met, no joint turns near one, and the start is not passed.

        Args:
            before: a point and its tangent, (k,) and (k,).
            here: the next; the walk goes on from it.
            orientation: of both.
            walls: (3,k) lower and upper limits, and whether whole turns lead to the same posture.
            start: (k,) where the walk began.
            longest: step.
            step: to begin with.
        """
        points, tangents = np.empty((MOST, self._k)), np.empty((MOST, self._k))
        for row, point in enumerate((before, here)):
            points[row], tangents[row] = point
        length = np.array([step])
        known = self._kernel.stride(
            *(*self._curve, MOST, address(walls), address(start), orientation, longest),
            *(address(length), address(points), address(tangents)),
        )
        return Stride(points[2:known], tangents[2:known], float(length[0]))
