"""The step that keeps clear by the native kernel."""

import ctypes
import itertools
import threading
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.planning import RobotClearance

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel, address

NEAR_PAIRS, TASK_ROWS = 96, 6
ROWS = 2 * NEAR_PAIRS + 2 * MOST_JOINTS
CLEARED, WANT_BOUNDS, WANT_LOOK, TO_NUMPY = range(4)
"""What a call answers."""
TAKE, BEGIN, GO_ON, LOOKED, FINISH = range(5)
"""What a call is asked for."""
_MARKS = itertools.count(1)
"""Of what was taken up, each once in all threads."""
_Pointer, _Int, _Double = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double


class ClearFields(ctypes.Structure):
    """`Clear` of clearance.h, field by field."""

    _fields_ = [
        *[(name, _Pointer) for name in ("first", "second", "rates")],
        *[(name, _Int) for name in ("first_knots", "second_knots", "n", "positions")],
        ("columns", _Int * MOST_JOINTS),
        *[(name, _Double) for name in ("safe", "zone", "period", "retreat", "tolerance")],
        *[(name, _Double) for name in ("least_share", "loss", "free", "soft", "tiny", "unfelt")],
        *[(name, _Double) for name in ("blocking", "nothing", "something")],
        ("reach", _Double * MOST_JOINTS),
        *[(name, _Int) for name in ("m", "k", "bounded", "moves", "padded", "correct")],
        *[(name, _Double * MOST_JOINTS) for name in ("step", "low", "high")],
        ("J", _Double * (TASK_ROWS * MOST_JOINTS)),
        ("raw_distances", _Double * NEAR_PAIRS),
        ("raw", _Double * (NEAR_PAIRS * MOST_JOINTS)),
        ("moved", _Double * NEAR_PAIRS),
        ("taken", _Double * MOST_JOINTS),
        ("distance", _Double),
        *[(name, _Int) for name in ("blocked", "row", "near", "looked")],
        ("felt", _Int * NEAR_PAIRS),
        ("distances", _Double * (2 * NEAR_PAIRS)),
        *[(name, _Double * (2 * NEAR_PAIRS * MOST_JOINTS)) for name in ("rows", "ways")],
        ("least", _Double * ROWS),
        ("M", _Double * MOST_JOINTS**2),
        ("pushes", _Double * ROWS),
        ("asked", _Double * MOST_JOINTS),
    ]


class NativeAnswer(NamedTuple):
    """A step that keeps clear, see `control.clear_step.Cleared`."""

    step: Array
    distance: float
    blocked: bool
    row: int


class NativeClearStep(threading.local):
    """Does what `control.clear_step.ClearStep` does, from what a checker answers.

    A thread has buffers of its own, of about half a megabyte.

    Args:
        loaded: the kernel.
        columns: where the arm's joints stand in the checker's positions (n,).
        positions: how many the checker has.
        reach: see `ClearStep` (n,).
        table: knots of the rules' two inputs and rates: (a,), (b,), (a,b).
        numbers: the fields of `ClearFields` from `safe` to `something` by name.
    """

    def __init__(
        self,
        loaded: Kernel,
        columns: NDArray[np.int64],
        positions: int,
        reach: Array,
        table: tuple[Array, Array, Array],
        numbers: dict[str, float],
    ) -> None:
        self._run = loaded.clear
        self._table = tuple(np.array(part, dtype=float, order="C") for part in table)
        self._fields = fields = ClearFields()
        fields.first, fields.second, fields.rates = map(address, self._table)
        fields.first_knots, fields.second_knots = self._table[2].shape
        self._n, self._positions = fields.n, fields.positions = len(columns), positions
        fields.columns[: len(columns)] = columns.tolist()
        fields.reach[: len(columns)] = reach.tolist()
        for name, value in numbers.items():
            setattr(fields, name, value)
        self.at, n = ctypes.addressof(fields), len(columns)
        """Address of the fields."""
        self.taken = 0
        """The mark of what was taken up last; unlike a reference it keeps nothing alive."""
        self._step, self._low, self._high, self._taken, self._J = (
            np.ctypeslib.as_array(part)
            for part in (fields.step, fields.low, fields.high, fields.taken, fields.J)
        )
        self._step, self._low, self._high = self._step[:n], self._low[:n], self._high[:n]
        self._taken = self._taken[:n]
        self._distances, self._raw, self._moved = (
            np.ctypeslib.as_array(part) for part in (fields.raw_distances, fields.raw, fields.moved)
        )

    def __call__(
        self,
        step: Array,
        found: RobotClearance,
        look: Callable[[Array], RobotClearance],
        looks: int,
        *,
        taken: int,
        J: Array | None,
        low: Array | None,
        high: Array | None,
        bounds: Callable[[], tuple[Array, Array]] | None,
        moved: Array | None,
    ) -> NativeAnswer | None:
        """The step that keeps clear; None: numpy has to do it. The arguments are those of `ClearStep`.

        Args:
            step: what is asked for (n,), finite [rad or m].
            found: what the checker says before it.
            look: what it says after a step.
            looks: how often that may be asked.
            taken: mark of `found` if it was taken up, see `take`; if it was the last, it is not read again.
            J: the task Jacobian (m,n).
            low: least step (n,).
            high: greatest step (n,).
            bounds: tells both where the step is inside them.
            moved: what others did to the distances of `found` (k,) [m].
        """
        fields = self._fields
        if taken != self.taken and self.take(found, bool(fields.padded)) < 0:
            return None
        self._move(moved)
        self._step[:] = step
        fields.m = 0
        if J is not None:
            fields.m = len(J)
            if fields.m > TASK_ROWS:
                return None
            self._J[: J.size] = J.ravel()
        fields.bounded = 2 if bounds is not None else 0
        if low is not None and high is not None:
            fields.bounded, self._low[:], self._high[:] = 1, low, high
        answer = self._run(self.at, BEGIN)
        if answer == WANT_BOUNDS and bounds is not None:
            self._low[:], self._high[:] = bounds()
            answer = self._run(self.at, GO_ON)
        if answer == WANT_LOOK:
            answer = self.look(look, looks)
        return self.answer() if answer == CLEARED else None

    def answer(self) -> NativeAnswer:
        """What was found, after the kernel has answered `CLEARED`."""
        fields = self._fields
        return NativeAnswer(
            self._taken.copy(), fields.distance, bool(fields.blocked), int(fields.row)
        )

    def take(self, found: RobotClearance, padded: bool) -> int:
        """How many pairs the arm's joints move of what a checker says; −1: numpy has to count.

        Args:
            found: what it says; `taken` is then its mark. Who keeps it beyond the cycle pays for it: Drake
                sets aside room for all pairs, and two such rooms are not found in the cache.
            padded: the checker has paddings.
        """
        if not self.read(found, padded) or self._run(self.at, TAKE) != CLEARED:
            return -1
        return self._fields.near

    @property
    def distance(self) -> float:
        """Of the nearest pair that was taken up [m]; inf: there is none."""
        return self._fields.distance

    def read(self, found: RobotClearance, padded: bool, moved: Array | None = None) -> bool:
        """Copy what a checker says, for the kernel to take up; False if it is too much.

        Args:
            found: what it says.
            padded: the checker has paddings.
            moved: see a call.
        """
        self._fields.padded = padded
        self.taken = next(_MARKS)
        if not self._read(found):
            return False
        self._move(moved)
        return True

    def _move(self, moved: Array | None) -> None:
        self._fields.moves = moved is not None
        if moved is not None:
            self._moved[: len(moved)] = moved

    def look(self, look: Callable[[Array], RobotClearance], looks: int) -> int:
        """Look at the end of the step: it is corrected, then halved, then given up; the kernel's answer."""
        self.taken = next(_MARKS)
        for i in range(looks):
            if not self._read(look(self._taken)):
                return TO_NUMPY
            self._fields.correct = i + 2 < looks
            answer = self._run(self.at, LOOKED)
            if answer != WANT_LOOK:
                return answer
            if i + 2 >= looks:
                self._taken *= 0.5
        self._taken[:] = 0.0
        return self._run(self.at, FINISH)

    def _read(self, found: RobotClearance) -> bool:
        """Copy what a checker says; False if it is too much."""
        self._fields.k = k = found.size()
        if k:
            if k > NEAR_PAIRS or self._positions > MOST_JOINTS:
                return False
            self._distances[:k] = found.distances()
            self._raw[: k * self._positions] = found.jacobians().ravel("F")
        return True
