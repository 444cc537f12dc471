"""The arithmetic of a clearance: distances and their derivatives in, the step that keeps them out."""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.control.near_pairs import UNFELT, Near
from fikm_drake.control.row_projection import (
    FREE,
    SOFT,
    TINY,
    kept,
    project,
    shortened,
    task_metric,
    with_box,
)
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, Kernel
from fikm_drake.kinematics.native.native_clearance import NativeClearStep

LOSS = 2.5e-4
"""A step may end this much nearer than the safe distance [m]."""
LOOKS = 3
"""Ends of steps that are looked at in a cycle; the last one is half a step, else none [-]."""
BLOCKED = 0.5
"""The arm is blocked where obstacles take away this fraction of the step [-]."""
USELESS = (0.002, 0.005)
"""The first fraction of the task's motion is not worth a motion of the joints, the second is [-]."""
NO_ROW = -1

Look = Callable[[Array], Near]
"""A joint step (n,) to the pairs that are near after it."""
Bounds = Callable[[], tuple[Array, Array]]
"""The least and the greatest step of each joint in this cycle (n,), (n,) [rad or m]."""


class Cleared(NamedTuple):
    """A step that keeps clear."""

    step: Array
    """(n,) [rad or m]."""
    distance: float
    """Of the nearest pair before the step [m]; inf: none is near."""
    blocked: bool
    """Obstacles take away half of the step, or more."""
    row: int
    """The pair that pushes most; −1: none does."""


class ClearStep:
    """Turns a joint step into the nearest one that keeps clear of pairs whose distances are known.

    Args:
        config: see `ClearanceConfig`.
        period: of the control cycle [s].
        rates: the rules' table over distance and speed of approach, both in widths of the zone.
        reach: bounds of how far the joints move points of the arm (n,) [m/rad or 1].
    """

    def __init__(
        self, config: ClearanceConfig, period: float, rates: RuleBase, reach: Array
    ) -> None:
        self.config, self.period, self.rates, self.reach = config, period, rates, reach
        self.least_share = float(1.0 - np.exp(-rates.consequents.min() * period))
        self.tolerance = 0.1 * LOSS * self.least_share

    def native(
        self, columns: NDArray[np.int64], positions: int, loaded: Kernel | None
    ) -> NativeClearStep | None:
        """The same by the native kernel; None: there is none.

        Args:
            columns: where the arm's joints stand in the positions of the checker's plant (n,).
            positions: how many that has.
            loaded: the kernel.
        """
        if loaded is None or len(columns) > MOST_JOINTS:
            return None
        config, table = self.config, self.rates
        nothing, something = USELESS
        numbers = {
            "safe": config.safe_distance,
            "zone": config.zone,
            "period": self.period,
            "retreat": config.retreat_speed,
            "tolerance": self.tolerance,
            "least_share": self.least_share,
            "loss": LOSS,
            "free": FREE,
            "soft": SOFT,
            "tiny": TINY,
            "unfelt": UNFELT,
            "blocking": BLOCKED,
            "nothing": nothing,
            "something": something,
        }
        parts = table.first.knots, table.second.knots, table.consequents
        return NativeClearStep(loaded, columns, positions, self.reach, parts, numbers)

    def __call__(
        self,
        step: Array,
        near: Near,
        look: Look,
        *,
        J: Array | None = None,
        low: Array | None = None,
        high: Array | None = None,
        bounds: Bounds | None = None,
        moved: Array | None = None,
    ) -> Cleared:
        """The step that keeps clear; the arguments are those of `Clearance`.

        Args:
            step: what is asked for (n,), finite [rad or m].
            near: the pairs that are near before it.
            look: tells those after a step.
            J: the task Jacobian (m,n).
            low: least step (n,).
            high: greatest step (n,).
            bounds: tells both where the step is inside them.
            moved: what others did to the distances in the last cycle (k,) [m].
        """
        step = shortened(step, low, high)
        zone = self.config.zone
        way = float(np.abs(step).dot(self.reach))
        if way > zone:
            step = step * (zone / way)
        distances, rows = near.distances, near.rows
        distance = float(distances.min(initial=inf))
        gaps, change = distances - self.config.safe_distance, rows.dot(step)
        quiet = (
            moved is None
            and gaps.min(initial=0.0) >= 0.0
            and (change >= -self.least_share * gaps).all()
        )
        if quiet and (low is None or high is None or inside(step, low, high)):
            return Cleared(step, distance, False, NO_ROW)
        least = self._least_changes(gaps, change, moved)
        if bounds is not None:
            low, high = bounds()
        rows, least = with_box(rows, least, low, high)
        metric = None if J is None else task_metric(J)
        asked = step
        step, pushes = project(asked, rows, least, self.tolerance, metric)
        step = kept(step, rows, least, self.tolerance)
        rests = None if (least > 2.0 * self.tolerance).any() else J
        step = _used(step, asked, rests)  # an arm that is stuck has nothing to look at
        looked = self._looked_at(step, distance, rows, least, metric, look)
        step = step if looked is step else _used(looked, asked, rests)
        pushes = pushes[: len(distances)]
        row = int(pushes.argmax()) if pushes.any() else NO_ROW
        lost, whole = (asked - step, asked) if J is None else (J.dot(asked - step), J.dot(asked))
        blocked = bool(lost.dot(lost) > BLOCKED**2 * whole.dot(whole))
        return Cleared(step, distance, blocked and row != NO_ROW, row)

    def _least_changes(self, gaps: Array, change: Array, moved: Array | None) -> Array:
        """What the distances (k,) must at least change by in this cycle [m]."""
        if moved is not None:
            change = change + moved
        zone = self.config.zone
        approach = np.maximum(-change, 0.0) / (zone * self.period)
        share = 1.0 - np.exp(-self.rates(gaps / zone, approach) * self.period)
        least = np.minimum(-share * gaps, self.config.retreat_speed * self.period)
        return least if moved is None else least - moved

    def _looked_at(
        self,
        step: Array,
        distance: float,
        rows: Array,
        least: Array,
        metric: Array | None,
        look: Look,
    ) -> Array:
        """The step, corrected where its end is nearer than its tangents say.

        A distance bends with the posture, and has an edge where the nearest points leap along a link that
        lies along a box. What holds is that it falls by no more than the arm's points move.
        """
        floor = min(self.config.safe_distance - LOSS, distance)
        if distance - float(np.abs(step).dot(self.reach)) >= floor:
            return step
        for i in range(LOOKS):
            end = look(step)
            if not len(end.distances) or end.distances.min() >= floor:
                return step
            if i + 2 < LOOKS:
                rows = np.vstack([rows, end.rows])
                more = floor + 0.5 * LOSS - end.distances + end.rows.dot(step)
                least = np.concatenate([least, more])
                step, _ = project(step, rows, least, 0.0, metric)
            else:
                step = 0.5 * step
        return np.zeros(len(step))


def inside(step: Array, low: Array, high: Array) -> bool:
    """True if a step (n,) is inside its bounds."""
    return bool(((step >= low) & (step <= high)).all())


def _used(step: Array, asked: Array, J: Array | None) -> Array:
    """The step, less where next to nothing is left of the task's motion: an arm that is stuck shall rest.

    What would go on is a drift of its joints along the obstacle, which brings the tool no nearer.
    """
    if J is None:
        return step
    way = J.dot(asked)
    whole = float(way.dot(way))
    if whole == 0.0:
        return step
    nothing, something = USELESS
    use = (float(J.dot(step).dot(way)) / whole - nothing) / (something - nothing)
    return step * min(1.0, max(0.0, use))
