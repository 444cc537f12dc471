"""What a loop did lately: how far joints, error and target went, and how much of it to and fro."""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts

DOMINANT = 0.05
"""A change of sign counts if the joint's step is above this fraction of the largest of late [-]."""

FADING = 0.9
"""The largest step of late fades by this factor a cycle [-]."""


class Motion(NamedTuple):
    """Sums over a window of cycles. Net: where a motion ended; path: what it took."""

    net_step: float
    """Net motion of the joints [rad or m]."""
    path_step: float
    path_error: float
    """Path of the task error [m]."""
    net_error: float
    net_target: float
    """Net motion of the target [m]."""
    path_target: float
    changes: float
    """Changes of sign of the joint that has most of them, as far as they count [-]."""
    joint: int
    """That joint."""
    mean_error: float
    """Mean of the length of the task error [m]."""
    fall: float
    """By how much that length fell [m]; negative: it rose."""
    rough: float
    """The path of that length [m]."""
    path_deviation: float
    """Path deviation of the measured joints beside their command [rad or m]."""
    cycles: int
    """Cycles that were summed (-)."""

    @property
    def cancelled(self) -> float:
        """The fraction of the joints' path that leads nowhere: 0 straight on, 1 to and fro [-]."""
        return 1.0 - self.net_step / self.path_step if self.path_step > 0.0 else 0.0


class MotionWindows:
    """Two windows of cycles, a fast and a slow one, as sums that cost the same each cycle.

    Each is a ring of rows: of single cycles, and of as many blocks of cycles, so that the slow one
    forgets a block at a time. A row holds what is summed: joint step, changes of error and target, changes
    of sign, and lengths.

    The memory is a vector with named fields that the caller keeps: `MotionWindows.fields`.

    Args:
        num_rows: m, of the task error.
        num_joints: n.
        num_coordinates: c, of the target.
        window: cycles of the fast window [-].
        slow_window: cycles of the slow one, at most; a multiple of `window` − 1 is best used [-].
    """

    def __init__(
        self, num_rows: int, num_joints: int, num_coordinates: int, *, window: int, slow_window: int
    ) -> None:
        check_counts(num_rows=num_rows, num_joints=num_joints, num_coordinates=num_coordinates)
        ends = np.cumsum([num_joints, num_rows, num_coordinates, num_joints]).tolist()
        self._step, self._error, self._target, self._flips = (
            slice(a, b) for a, b in zip([0, *ends], ends)
        )
        self._lengths = slice(ends[-1], ends[-1] + 7)
        self._starts = [0, *ends[:2]]
        self._nets = slice(0, ends[2])
        self._size = self._lengths.stop
        self._rows = window - 1
        self._block = max(1, (slow_window - 1) // self._rows)

    @property
    def fields(self) -> list[tuple]:
        """Name, type and shape of what is remembered."""
        return [
            ("cycles", "f8"),
            ("largest", "f8"),
            ("last_size", "f8"),
            ("last_error", "f8", (self._error.stop - self._error.start,)),
            ("last_target", "f8", (self._target.stop - self._target.start,)),
            ("last_deviation", "f8", (self._step.stop,)),
            ("rings", "f8", (2, self._rows, self._size)),
        ]

    def start(self, memory: np.void) -> None:
        """Begin with empty windows."""
        memory["rings"] = 0.0
        memory["cycles"] = memory["largest"] = 0.0
        memory["last_size"] = -1.0

    def forget_turns(self, memory: np.void) -> None:
        """Count changes of sign anew; what was gone and how stays known."""
        memory["rings"][:, :, self._flips] = 0.0

    def add(
        self,
        memory: np.void,
        size: float,
        error: Array,
        target: Array,
        step: Array,
        length: float,
        flips: NDArray[np.bool_] | None,
        deviation: Array | None = None,
    ) -> float:
        """Write a cycle: error of length `size`, target, joint step and which joints turned round.

        `deviation` (n) is of the measured joints from their command, where they are measured.

        Returns:
            how far the target moved in it [m].
        """
        cycles, last_size = int(memory["cycles"]), float(memory["last_size"])
        if last_size < 0.0:  # nothing to compare with
            memory["last_error"], memory["last_target"] = error, target
            memory["last_deviation"] = 0.0 if deviation is None else deviation
            last_size = size
        strayed = 0.0
        if deviation is not None:
            change = deviation - memory["last_deviation"]
            strayed = float(change.dot(change)) ** 0.5
            memory["last_deviation"] = deviation
        fast, slow = memory["rings"]
        row = fast[cycles % self._rows]
        row[self._step] = step
        moved = error - memory["last_error"]
        shifted = target - memory["last_target"]
        row[self._error], row[self._target] = moved, shifted
        sizes = np.abs(step)
        largest = max(float(np.maximum.reduce(sizes)), FADING * float(memory["largest"]))
        row[self._flips] = 0.0 if flips is None else flips * (sizes > DOMINANT * largest)
        fall = last_size - size
        shift = float(shifted.dot(shifted)) ** 0.5
        row[self._lengths] = (
            length,
            float(moved.dot(moved)) ** 0.5,
            shift,
            max(size, 0.0),
            fall,
            abs(fall),
            strayed,
        )
        block = slow[cycles // self._block % self._rows]
        if cycles % self._block:
            block += row
        else:
            block[:] = row
        memory["cycles"], memory["largest"], memory["last_size"] = cycles + 1, largest, size
        memory["last_error"], memory["last_target"] = error, target
        return shift

    def motions(self, memory: np.void) -> tuple[Motion, Motion]:
        """The motions of the fast and of the slow window."""
        sums = np.add.reduce(memory["rings"], axis=1)
        nets = sums[:, self._nets]
        nets = np.sqrt(np.add.reduceat(nets * nets, self._starts, axis=1)).tolist()
        cycles = int(memory["cycles"])
        late = (cycles - 1) % self._block + 1
        known = (min(cycles, self._rows), min(cycles, (self._rows - 1) * self._block + late))
        motions = []
        for (step, error, target), lengths, flips, count in zip(
            nets, sums[:, self._lengths].tolist(), sums[:, self._flips].tolist(), known
        ):
            most = max(flips)
            path_step, path_error, path_target, total, fall, rough, strayed = lengths
            mean = total / count if count else inf
            paths = (step, path_step, path_error, error, target, path_target)
            most_of = flips.index(most)
            motions.append(Motion(*paths, most, most_of, mean, fall, rough, strayed, count))
        return motions[0], motions[1]
