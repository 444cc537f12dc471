"""A straight leg of a way of the joints, looked at posture by posture."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.clear_step import LOSS
from fikm_drake.control.clearance import Clearance


class ClearLeg:
    """Tells whether a leg is clear, by one look at a posture in a call.

    It is looked at as finely as the joints move along it. Where the nearest obstacle is so far off that
    the arm's points cannot come to it in some of these steps, they are left out: they are clear. The end
    is looked at first, and then from the start on.

    What it remembers is a record that the caller keeps, with `fields`.

    Args:
        clearance: tells what is clear.
        pace: largest joint motion between two postures [rad or m].
    """

    def __init__(self, clearance: Clearance, pace: float) -> None:
        self._clearance, self._pace = clearance, pace
        joints = (clearance.num_joints,)
        self.fields: list[tuple] = [
            ("leg_start", "f8", joints),
            ("leg_end", "f8", joints),
            ("reach", "f8", joints),  # of the joints, see `joint_reach`
            ("count", "f8"),  # of the leg's postures, without its start
            ("low", "f8"),  # up to this posture all are clear
            ("high", "f8"),  # from this one on all are
        ]

    def start(self, memory: np.void, a: Array, b: Array) -> None:
        """Begin to look at the leg from a (n,), which is clear, to b (n,)."""
        memory["leg_start"], memory["leg_end"] = a, b
        count = max(1.0, float(np.ceil(np.abs(b - a).max() / self._pace)))
        memory["count"], memory["low"], memory["high"] = count, 0.0, count + 1.0

    def end_is_clear(self, memory: np.void) -> bool:
        """True if the end has been looked at and is clear."""
        return bool(memory["high"] <= memory["count"])

    def look(self, memory: np.void, others: Array | None = None) -> bool | None:
        """True if all of the leg is clear, False if not, None if it takes more looks.

        Args:
            memory: what is changed.
            others: where obstacles are (p,), see `Clearance`.
        """
        a, b = memory["leg_start"], memory["leg_end"]
        count, low = float(memory["count"]), float(memory["low"])
        ends = not self.end_is_clear(memory)
        k = count if ends else low + 1.0
        room = self._clearance.room(a + k / count * (b - a), others)
        if not room >= -LOSS:
            return False
        way = float(np.abs(b - a).dot(memory["reach"]))
        free = min(count, float(np.floor(room * count / way))) if way > 0.0 else count
        if ends:
            memory["high"] = count - max(0.0, free)
        else:
            memory["low"] = k + max(0.0, free)
        return True if memory["low"] + 1.0 >= memory["high"] else None
