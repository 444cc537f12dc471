"""Random postures to start from, the nearest to a target first."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.solvers.batch.batch_targets import BatchTargets

SIZE = 256
"""Postures: more of them are nearer to a target, and to look for the nearest takes longer."""
STREAM = 0x66696B6D
"""Sets the pool's random numbers apart from those of `default_rng(seed)`, with which targets are drawn."""
DISTANCES = 2**14
"""Between targets and postures, looked at together: in the cache, and too few for BLAS to wake its
threads, which cost more than they bring."""


class PosturePool:
    """Seeded random postures inside the joints' limits, found by what their tool frames are near to.

    A start that is near its target needs half the cycles of a random one, and a joint limit or a
    local minimum is less often in the way. Joints without a limit are drawn within a turn (revolute) or
    twice the arm's reach (prismatic) of the limit they have, or around zero.

    Args:
        arm: the arm.
        length: the characteristic length that multiplies rotations [m].
        seed: of the random numbers.
        size: number of postures.
    """

    def __init__(self, arm: SerialChain, length: float, seed: int, size: int = SIZE) -> None:
        lower, upper = start_range(arm)
        uniform = np.random.default_rng((STREAM, seed)).random((size, arm.num_joints))
        self.q = np.ascontiguousarray((lower + (upper - lower) * uniform).T)
        self._arm = arm
        # |A − B|² of rotation matrices is 4 (1 − cos θ), about 2 θ².
        self._scale = length / np.sqrt(2.0)

    @cached_property
    def features(self) -> tuple[Array, Array]:
        """Features of the postures' tool frames: positions (3,size) and scaled axes (9,size) [m]."""
        frames = self._arm.frames(self.q)
        return frames.position, self._scale * frames.rotation.reshape(9, -1)

    def nearest(self, targets: BatchTargets, count: int, skip: int = 0) -> NDArray[np.intp]:
        """Indices (N,count) of the nearest postures to each target, after the `skip` nearest ones.

        Args:
            targets: N targets.
            count: how many for each.
            skip: how many to leave out; skip + count is at most the pool's size.
        """
        (F, rotation), G = self.features, targets.position
        if targets.rotation is not None:
            F = np.concatenate([F, rotation])
            G = np.concatenate([G, self._scale * targets.rotation.reshape(9, -1)])
        squares = np.sum(F * F, axis=0)
        found = np.empty((G.shape[1], count), dtype=np.intp)
        step = max(1, DISTANCES // squares.size)
        for start in range(0, G.shape[1], step):
            rows = slice(start, start + step)
            distance = squares - (2.0 * G[:, rows].T) @ F
            if skip + count == 1:
                found[rows, 0] = np.argmin(distance, axis=1)
                continue
            last = min(skip + count, squares.size - 1)
            few = np.argpartition(distance, last, axis=1)[:, : skip + count]
            order = np.argsort(np.take_along_axis(distance, few, axis=1), axis=1, kind="stable")
            found[rows] = np.take_along_axis(few, order, axis=1)[:, skip:]
        return found


def start_range(arm: SerialChain) -> tuple[Array, Array]:
    """Limits (n,) and (n,) that are finite for every joint [rad or m]; see `PosturePool`."""
    span = np.where(arm.revolute, 2.0 * np.pi, 2.0 * arm.reach)
    lower, upper = arm.lower, arm.upper
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - span, -span / 2))
    return low, np.where(np.isfinite(upper), upper, low + span)
