"""The pairs of bodies that are near, and how their distances change, by Drake's collision checker."""

import threading
from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import CollisionChecker, RobotClearance

from fikm_drake.arrays import Array, all_finite
from fikm_drake.kinematics.checker_joints import checker_indices

AHEAD = 1e-6
"""Length of a step that shows which way a distance changes [rad or m]."""
UNFELT = 1e-18
"""The square of a row that the arm's joints do not change, such as that of its base [(m/rad)²]."""


class Near(NamedTuple):
    """The pairs of bodies that are nearer than the influence distance and that the arm's joints change."""

    distances: Array
    """(k,) [m], negative in penetration."""
    rows: Array
    """Their derivatives by the arm's joints (k,n)."""
    places: NDArray[np.int64]
    """Where they stand in what the checker said (k,)."""


class NearPairs:
    """Asks a checker for the pairs of bodies that are nearer than a distance.

    From any thread: the checker's Context, which Drake needs as scratch, is one for each thread.

    Args:
        checker: a `SceneGraphCollisionChecker` of a world with the arm.
        joints: names of the arm's joints in the checker's plant; None: all that it has.
        influence_distance: pairs farther apart are left out [m].

    Attributes:
        indices: of the arm's joints in the positions of the checker's plant (n,).
        default_others: default positions of all else (p,), in the plant's order.

    Raises:
        ValueError: joints that the checker has not, or a checker that cannot tell distances.
    """

    def __init__(
        self, checker: CollisionChecker, joints: Sequence[str] | None, influence_distance: float
    ) -> None:
        self.indices = checker_indices(checker, joints)
        self._influence = influence_distance
        self._padded = checker.GetLargestPadding
        self._paddings, self._filters = checker.GetPaddingMatrix, checker.GetFilteredCollisionMatrix
        self._added = checker.GetAllAddedCollisionShapes
        self._calc = checker.CalcContextRobotClearance
        self._scratch = _Scratch(checker)
        self._plant = checker.plant()
        self._default = self._plant.GetPositions(self._plant.CreateDefaultContext())
        self._alone = len(self.indices) == self._plant.num_positions()
        other = np.ones(len(self._default), dtype=bool)
        other[self.indices] = False
        self._others = np.flatnonzero(other)
        self.default_others: Array = self._default[self._others]
        try:
            self(self._default[self.indices])
        except RuntimeError as error:
            raise ValueError(f"the checker cannot tell distances: {error}") from error

    def __call__(self, q: Array, others: Array | None = None, within: float = 0.0) -> Near:
        """Pairs nearer than the influence distance, or than `within` [m], at finite q (n,).

        Args:
            q: the arm's joints (n,) [rad or m].
            others: the positions of all else (p,); None: the plant's defaults.
            within: another distance than the influence distance [m]; 0: that.
        """
        return self.of(self.ask(q, others, within), q, others)

    def ask(self, q: Array, others: Array | None = None, within: float = 0.0) -> RobotClearance:
        """What the checker says; the arguments are those of a call.

        Its rows are the derivatives by all positions of its plant; the arm's joints do not change all pairs.
        """
        full = self._full(q, others)
        return self._calc(self._scratch.context, full, within or self._influence)

    def of(self, found: RobotClearance, q: Array, others: Array | None = None) -> Near:
        """The pairs in what the checker said."""
        distances, rows = found.distances(), np.array(found.jacobians())
        if not self._alone:
            rows = rows[:, self.indices]
        squares = np.einsum("ij,ij->i", rows, rows)
        felt = np.flatnonzero((squares > UNFELT) & (squares < inf))
        near = Near(distances, rows, felt)
        if len(felt) < len(distances):
            near = Near(distances[felt], rows[felt], felt)
        if len(felt) and near.distances.min() < 0.0 and self.padded:
            self._turn_rows(q, others, found, near)
        return near

    def moving(
        self, q: Array, found: RobotClearance, others: Array | None, before: Array | None
    ) -> tuple[Array | None, Array | None]:
        """Where others will be after this cycle (p,), and what they did to the distances in the last one.

        Args:
            q: the arm's joints (n,) [rad or m].
            found: what the checker says there.
            others: where others are (p,); None: where they are by default.
            before: where they were in the last cycle (p,); None: nothing moves.

        Returns:
            The positions, and the change of each distance found (k,) [m]; None: none moves.
        """
        if others is None or before is None or not all_finite(before) or (others == before).all():
            return others, None
        farthest = 2.0 * self._influence
        was, now = nearest_of(self.ask(q, before, farthest)), nearest_of(found)
        changes = []
        for i, d in enumerate(found.distances().tolist()):
            pair = pair_of(found, i)
            changes.append(min(now[pair] - was.get(pair, farthest), d))
        moved = np.maximum(changes, -self._influence)
        return others + (others - before), moved

    @property
    def num_positions(self) -> int:
        """Of the checker's plant."""
        return len(self._default)

    @property
    def padded(self) -> bool:
        """The checker has paddings."""
        return self._padded() > 0.0

    @property
    def world(self) -> bytes | None:
        """What an answer depends on beside positions, as far as it can change; None: that cannot be told."""
        if self._added():
            return None
        return self._paddings().tobytes() + self._filters().tobytes()

    def _full(self, q: Array, others: Array | None) -> Array:
        if self._alone:
            return q
        full = self._default.copy()
        full[self.indices] = q
        if others is not None:
            full[self._others] = others
        return full

    def _turn_rows(self, q: Array, others: Array | None, found: RobotClearance, near: Near) -> None:
        """Turn rows that point into an obstacle.

        Drake 1.51 to 1.58 turn a row the wrong way while only the padding is penetrated, where the distance
        less the padding is negative and the distance is not.
        """
        for i in np.flatnonzero(near.distances < 0.0).tolist():
            row, d = near.rows[i], float(near.distances[i])
            size = float(np.linalg.norm(row))
            moved = self.ask(q + AHEAD * row / size, others)
            pair = pair_of(found, int(near.places[i]))
            changes = [
                x - d for j, x in enumerate(moved.distances().tolist()) if pair_of(moved, j) == pair
            ]
            if changes and min(changes, key=lambda x: abs(abs(x) - AHEAD * size)) < 0.0:
                near.rows[i] = -row

    def names(self, pair: tuple[int, int]) -> tuple[str, str]:
        """Scoped names of the bodies of a pair; empty for no pair."""
        if pair[0] < 0 or pair[1] < 0:
            return "", ""
        one, two = (self._plant.get_body(BodyIndex(i)).scoped_name().get_full() for i in pair)
        return one, two


def pair_of(found: RobotClearance, i: int) -> tuple[int, int]:
    """Indices of the two bodies of a row in the checker's plant."""
    return int(found.robot_indices()[i]), int(found.other_indices()[i])


def nearest_of(found: RobotClearance) -> dict[tuple[int, int], float]:
    """The least distance of each pair of bodies, which may have several shapes."""
    least: dict[tuple[int, int], float] = {}
    for i, d in enumerate(found.distances().tolist()):
        pair = pair_of(found, i)
        least[pair] = min(d, least.get(pair, inf))
    return least


class _Scratch(threading.local):
    """A context of the checker's model for each thread; each use writes all of it that it reads."""

    def __init__(self, checker: CollisionChecker) -> None:
        self.context = checker.MakeStandaloneModelContext()
