"""What a loop did lately: how far joints, error and target went, and how much of it to and fro."""

from collections.abc import Sequence
from math import inf, prod, sqrt
from typing import NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts

DOMINANT = 0.05
"""A change of sign counts if the joint's step is above this fraction of the largest of late [-]."""

FADING = 0.9
"""The largest step of late fades by this factor a cycle [-]."""

CYCLES, LARGEST, LAST_SIZE, MOST_CHANGES = range(4)
"""Where the first numbers of the memory are: cycles so far, the largest joint step of late, the last error's
length (negative: there is none), changes of sign of the joint that has most in the slow window."""


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

    The memory is a vector that the caller keeps; `fields` says of what.

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
        self._row_size = self._lengths.stop
        self._rows = window - 1
        self._block = max(1, (slow_window - 1) // self._rows)
        self.fields: list[tuple] = [
            ("cycles", "f8"),
            ("largest", "f8"),
            ("last_size", "f8"),
            ("most_changes", "f8"),
            ("last_error", "f8", (num_rows,)),
            ("last_target", "f8", (num_coordinates,)),
            ("last_deviation", "f8", (num_joints,)),
            ("rings", "f8", (2, self._rows, self._row_size)),
        ]
        """Name, type and shape of what is remembered."""
        place = places(self.fields)
        self._last_error, self._last_target = place["last_error"], place["last_target"]
        self._last_deviation, self._rings = place["last_deviation"], place["rings"]
        self._fast = self._rings.start
        self._slow = self._fast + self._rows * self._row_size
        # Of the fast window's cycles, how far the joints went.
        self._steps = slice(self._fast + self._lengths.start, self._slow, self._row_size)

    def start(self, memory: Array) -> None:
        """Begin with empty windows."""
        memory[self._rings] = 0.0
        memory[: MOST_CHANGES + 1] = 0.0, 0.0, -1.0, 0.0

    def forget_turns(self, memory: Array) -> None:
        """Count changes of sign anew; what was gone and how stays known."""
        self._both(memory)[:, :, self._flips] = memory[MOST_CHANGES] = 0.0

    def last(self, memory: Array) -> tuple[float, Array, Array]:
        """Of the last cycle the error's length [m], the error and the target: views."""
        return float(memory[LAST_SIZE]), memory[self._last_error], memory[self._last_target]

    def cycles(self, memory: Array) -> int:
        """How many there were since the start."""
        return int(memory[CYCLES])

    def add(
        self,
        memory: Array,
        size: float,
        error: Array,
        target: Array,
        step: Array,
        length: float,
        turned: Sequence[int] = (),
        deviation: Array | None = None,
    ) -> float:
        """Write a cycle: error of length `size`, target, joint step, its length, and who turned round.

        `deviation` (n) is of the measured joints from their command, where they are measured.

        Returns:
            how far the target moved in it [m].
        """
        known, largest, last_size = memory[:MOST_CHANGES].tolist()
        last_error, last_target = memory[self._last_error], memory[self._last_target]
        if last_size < 0.0:  # nothing to compare with
            last_error[:], last_target[:] = error, target
            memory[self._last_deviation] = 0.0 if deviation is None else deviation
            last_size = size
        strayed = 0.0
        if deviation is not None:
            change = deviation - memory[self._last_deviation]
            strayed = sqrt(change.dot(change))
            memory[self._last_deviation] = deviation
        cycle, steps = int(known), step.tolist()
        row = self._row(memory, self._fast, cycle)
        row[self._step] = step
        moved, shifted = row[self._error], row[self._target]
        np.subtract(error, last_error, moved)
        np.subtract(target, last_target, shifted)
        last_error[:], last_target[:] = error, target
        largest = max(max(steps), -min(steps), FADING * largest)
        row[self._flips] = 0.0
        for joint in turned:
            row[self._flips.start + joint] = abs(steps[joint]) > DOMINANT * largest
        fall, path, shift = last_size - size, sqrt(moved.dot(moved)), sqrt(shifted.dot(shifted))
        row[self._lengths] = length, path, shift, max(size, 0.0), fall, abs(fall), strayed
        block = self._row(memory, self._slow, cycle // self._block)
        begins = cycle % self._block == 0
        if begins:
            block[:] = row
        else:
            block += row
        memory[CYCLES], memory[LARGEST], memory[LAST_SIZE] = known + 1.0, largest, size
        if begins or turned:
            flips = self._both(memory)[1, :, self._flips]
            memory[MOST_CHANGES] = max(np.add.reduce(flips).tolist())
        return shift

    def path_step(self, memory: Array) -> float:
        """How far the joints went in the fast window [rad or m]."""
        return sum(memory[self._steps].tolist())

    def most_changes(self, memory: Array) -> float:
        """Changes of sign of the joint that has most in the slow window, of which the fast one is a part."""
        return float(memory[MOST_CHANGES])

    def motions(self, memory: Array) -> tuple[Motion, Motion]:
        """The motions of the fast and of the slow window."""
        sums = np.add.reduce(self._both(memory), axis=1)
        nets = sums[:, self._nets]
        nets = np.sqrt(np.add.reduceat(nets * nets, self._starts, axis=1)).tolist()
        cycles = self.cycles(memory)
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

    def _row(self, memory: Array, ring: int, count: int) -> Array:
        """The row of a ring for this count of cycles or blocks, a view."""
        first = ring + count % self._rows * self._row_size
        return memory[first : first + self._row_size]

    def _both(self, memory: Array) -> Array:
        """Both rings, a view."""
        return memory[self._rings].reshape(2, self._rows, self._row_size)


def places(fields: list[tuple]) -> dict[str, slice]:
    """Where each of these fields is, in a vector of their numbers."""
    found, end = {}, 0
    for name, _, *shape in fields:
        first, end = end, end + (prod(shape[0]) if shape else 1)
        found[name] = slice(first, end)
    return found
