"""A way of the joints that is clear, looked for bit by bit."""

from enum import IntEnum

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.clear_leg import ClearLeg
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.joint_trees import GOAL, NODES, START, JointTrees

CHECKS = 6
"""Postures that are looked at in a look [-]."""
GROWTHS = 40
"""Times that the trees grow before another posture is waited for [-]."""


class Phase(IntEnum):
    """What a search of a way does."""

    FRESH = 0
    """Nothing yet."""
    STRAIGHT = 1
    """It looks at the straight way."""
    GROW = 2
    """A tree grows by a leg toward a sample."""
    MEET = 3
    """The other one grows toward the new posture as far as it can."""
    SHORTEN = 4
    """The trees have met; bends are left out."""
    FOUND = 5
    """There is a way."""
    GIVEN_UP = 6
    """There is none to this posture, for now."""


class ClearWay:
    """Finds a clear way of the joints to one of the postures that it is told one after the other.

    First it looks at the straight way to a posture. Then two trees grow toward each other
    (`JointTrees`), one from the joints and one from all postures so far, and what was found is shortened.
    All of a way is looked at as finely as the joints move along it (`ClearLeg`). `CHECKS` postures are
    looked at in a call, and the search is the same each time.

    What it remembers is a vector that the caller keeps; `fields` names what is in it.

    Args:
        clearance: tells what is clear.
        pace: largest joint motion between two postures [rad or m].
        lower: lower joint limits (n,) [rad or m].
        upper: upper joint limits (n,) [rad or m].
    """

    def __init__(self, clearance: Clearance, *, pace: float, lower: Array, upper: Array) -> None:
        self._clearance = clearance
        self._leg, self._trees = ClearLeg(clearance, pace), JointTrees(lower, upper)
        self.fields = np.dtype(
            [
                ("phase", "f8"),
                ("growths", "f8"),
                ("most_growths", "f8"),
                ("tree", "f8"),  # that grew last
                ("grown", "f8"),  # its new posture
                ("base", "f8"),  # the posture from which the leg goes that is looked at
                ("length", "f8"),  # postures of the way, which then stands where the trees were
                (
                    "at",
                    "f8",
                ),  # on the way the posture to which the joints go; while it is shortened...
                ("to", "f8"),  # ...a leg goes from there to here
                ("posture", "f8", (len(lower),)),  # the last that was told...
                ("goal", "f8", (len(lower),)),  # ...and the last that is clear
                *self._leg.fields,
                *self._trees.fields,
            ]
        )

    def initial_memory(self) -> Array:
        """The memory before a search."""
        return np.zeros(self.fields.itemsize // 8)

    def via(self, memory: Array) -> Array | None:
        """The posture in between (n,) to which the joints are to go first; None: none."""
        way = self._named(memory)
        at = int(way["at"])
        return _postures(way)[at] if at < way["length"] - 1 else None

    def pass_via(self, memory: Array) -> None:
        """The joints are at the posture in between."""
        self._named(memory)["at"] += 1.0

    def end(self, memory: Array) -> Array:
        """The end (n,) of the way that was found."""
        way = self._named(memory)
        end: Array = _postures(way)[int(way["length"]) - 1].copy()
        return end

    def goal(self, memory: Array) -> Array | None:
        """The last clear posture (n,) so far, with which the trees go on to grow; None: there is none."""
        way = self._named(memory)
        return way["goal"].copy() if way["sizes"][GOAL] else None

    def legs(self, memory: Array, q: Array) -> list[tuple[Array, Array]]:
        """What is left of the way from q (n,)."""
        way = self._named(memory)
        postures = [q, *_postures(way)[int(way["at"]) : int(way["length"])]]
        return list(zip(postures, postures[1:]))

    def look(
        self, memory: Array, q: Array, posture: Array, others: Array | None = None
    ) -> bool | None:
        """True if a way was found, False if there is none for now, None if it takes more looks.

        Args:
            memory: zeros at first; what is changed.
            q: where the joints are (n,) [rad or m].
            posture: where they may go (n,) [rad or m], beside those of earlier calls.
            others: where obstacles are (p,), see `Clearance`.
        """
        way = self._named(memory)
        if way["phase"] in (Phase.FRESH, Phase.GIVEN_UP) or (way["posture"] != posture).any():
            self._begin(way, q, posture)
        for _ in range(CHECKS):
            clear = self._leg.look(way, others)
            if clear is not None:
                self._next(way, q, clear)
            if way["phase"] >= Phase.FOUND:
                return bool(way["phase"] == Phase.FOUND)
        return None

    def _begin(self, way: np.void, q: Array, posture: Array) -> None:
        """A new posture to go to."""
        if not way["sizes"][START]:
            self._trees.add(way, START, q)
            way["reach"] = self._clearance.reach()
        way["posture"], way["most_growths"] = posture, way["growths"] + GROWTHS
        if way["sizes"][GOAL] and (posture == way["goal"]).all():
            self._grow(way)
        else:
            way["phase"] = Phase.STRAIGHT
            self._leg.start(way, q, posture)

    def _next(self, way: np.void, q: Array, clear: bool) -> None:
        """What follows from a leg that is clear or is not."""
        phase = way["phase"]
        if phase == Phase.STRAIGHT:
            if clear:
                self._found(way, np.array([q, way["posture"]]))
                way["phase"] = Phase.FOUND
            elif self._leg.end_is_clear(way):
                way["goal"] = way["posture"]
                if self._trees.full(way):
                    self._trees.cut(way, way["goal"])
                else:
                    self._trees.add(way, GOAL, way["goal"])
                self._grow(way)
            else:
                way["phase"] = Phase.GIVEN_UP
        elif phase == Phase.GROW and clear:
            tree = int(way["tree"])
            way["grown"] = self._trees.add(way, tree, way["leg_end"], int(way["base"]))
            grown = self._trees.node(way, tree, int(way["grown"]))
            way["base"], way["phase"] = self._trees.nearest(way, 1 - tree, grown), Phase.MEET
            self._meet(way)
        elif phase == Phase.MEET and clear:
            self._met(way, q)
        elif phase == Phase.SHORTEN:
            at, to = int(way["at"]), int(way["to"])
            if clear:
                to = self._leave_out(way, at, to)
            elif at == 0 and to == 1:  # the joints have come where they cannot go back: all anew
                way["phase"], way["sizes"] = Phase.GIVEN_UP, 0.0
                return
            self._shorten(way, to - 1)
        else:
            self._grow(way)

    def _grow(self, way: np.void) -> None:
        """Look at the leg by which a tree may grow next; the trees take turns."""
        trees, number = self._trees, int(way["growths"])
        if number >= way["most_growths"]:
            way["phase"] = Phase.GIVEN_UP
            return
        if trees.full(way):
            trees.cut(way, way["goal"])
        sample, tree = trees.sample(way, number), number % 2
        base = trees.nearest(way, tree, sample)
        way["growths"], way["tree"], way["base"] = number + 1, tree, base
        way["phase"] = Phase.GROW
        start = trees.node(way, tree, base)
        self._leg.start(way, start, trees.toward(start, sample))

    def _meet(self, way: np.void) -> None:
        """Look at the leg by which the other tree comes nearer to the new posture."""
        tree = int(way["tree"])
        start = self._trees.node(way, 1 - tree, int(way["base"]))
        grown = self._trees.node(way, tree, int(way["grown"]))
        self._leg.start(way, start, self._trees.toward(start, grown))

    def _met(self, way: np.void, q: Array) -> None:
        """The other tree has come nearer: on, or both are one."""
        tree, grown, base = int(way["tree"]), int(way["grown"]), int(way["base"])
        if (way["leg_end"] != self._trees.node(way, tree, grown)).any():
            if self._trees.full(way):
                self._grow(way)
            else:
                way["base"] = self._trees.add(way, 1 - tree, way["leg_end"], base)
                self._meet(way)
            return
        postures = self._trees.way(way, (grown, base) if tree == START else (base, grown))
        if (q != postures[0]).any():  # the joints have strayed from where the search began
            postures = np.vstack([q, postures])
        self._found(way, postures)
        way["phase"], way["at"] = Phase.SHORTEN, 0.0
        self._shorten(way, len(postures) - 1)

    def _found(self, way: np.void, postures: Array) -> None:
        """Write a way (k,n) to where the trees were."""
        way["length"], way["at"], way["sizes"] = len(postures), 1.0, 0.0
        _postures(way)[: len(postures)] = postures

    def _leave_out(self, way: np.void, at: int, to: int) -> int:
        """Leave out the postures between two; the number of the last one after that, and one more."""
        length = int(way["length"])
        kept = _postures(way)[to:length].copy()
        _postures(way)[at + 1 : at + 1 + len(kept)] = kept
        way["length"], way["at"] = at + 1 + len(kept), at + 1
        return int(way["length"])

    def _shorten(self, way: np.void, to: int) -> None:
        """Look at the next leg that would leave out bends: from each posture to the farthest first.

        Legs of the trees are known to be clear, but from where the joints are none is.
        """
        at, last = int(way["at"]), int(way["length"]) - 1
        if 0 < at < last and to <= at + 1:
            at, to = at + 1, last
        way["at"], way["to"] = at, to
        if 0 < at and to <= at + 1:
            way["phase"], way["at"] = Phase.FOUND, 1.0
        else:
            postures = _postures(way)
            self._leg.start(way, postures[at], postures[to])

    def _named(self, memory: Array) -> np.void:
        """The memory by its fields' names; what is written there is written to the memory."""
        named: np.void = memory.view(self.fields)[0]
        return named


def _postures(way: np.void) -> Array:
    """Where a way's postures stand (2 `NODES`,n)."""
    postures: Array = way["nodes"].reshape(2 * NODES, -1)
    return postures
