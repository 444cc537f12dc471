"""A joint step that keeps clear of obstacles and of the arm itself."""

from collections.abc import Sequence
from math import exp, inf
from typing import Any, NamedTuple

import numpy as np
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array
from fikm_drake.checks import check_positive_finite
from fikm_drake.control.clearance_config import (
    ClearanceConfig,
    clearance_table,
    load_clearance_rules,
)
from fikm_drake.control.near_pairs import Near, NearPairs
from fikm_drake.control.row_projection import (
    free_part,
    kept,
    project,
    shortened_toward,
    with_box,
)
from fikm_drake.kinematics.checker_joints import arm_joint_names, joint_reach
from fikm_drake.kinematics.plant_arm import PlantArm

BENT = 5e-4
"""How far a step may bend off its tangent before its end is looked at too [m]."""
LOSS = 2.5e-4
"""A step may end this much nearer than the safe distance [m]."""
LOOKS = 3
"""Ends of steps that are looked at in a cycle; the last one is half a step, else none [-]."""
BLOCKED = 0.5
"""The arm is blocked where obstacles take away this fraction of the step [-]."""
DAMPING = 0.05
"""Damping of the motion that gives way, over the mean square of the rows of the Jacobian [-]."""
USELESS = (0.002, 0.005)
"""The first fraction of the task's motion is not worth a motion of the joints, the second is [-]."""
NONE = (-1, -1)
"""No pair."""


class ClearanceInfo(NamedTuple):
    """What a cycle's obstacles did."""

    distance: float = inf
    """Distance of the nearest pair before the step [m]; inf: none is within the influence distance."""
    blocked: bool = False
    """Obstacles take away half of the step, or more."""
    pair: tuple[int, int] = NONE
    """Indices of the two bodies whose row pushes most, in the checker's plant; −1: none does."""


class Clearance:
    """Turns a law's joint step into the nearest one that keeps clear.

    Each pair of bodies at a distance d below the influence distance is one row a = ∂d/∂q, and
    a · dθ ≥ −(1 − exp(−rate T)) (d − d_safe) − ḋ_others T is what this cycle allows: the distance to the
    safe one shrinks at the `rate` that fuzzy rules read off distance and speed of approach; a pair that is
    too near is parted at that rate; what others move toward the arm is added. Rows that the step
    violates are projected (`row_projection`). What of the task this takes away is asked once more of the
    joint motion that the rows leave free, so that a redundant arm gives way with its elbow and not with its
    tool.

    Rows are tangents. Therefore no point of the arm moves further in a cycle than the influence zone is
    wide, and a step that bends, long and near, is looked at where it ends; there it is corrected,
    then halved, then given up. An arm that keeps the distance goes on to, whatever the rate of the
    cycles; one that starts nearer, or in penetration, backs out.

    A checker's context is scratch, one for each thread. Positions that are not finite never reach it:
    Drake ends the process on them.

    Args:
        checker: Drake's, such as of `MakeCollisionChecker`; shapes may be added to it while it is
            in use, such as what a hand holds (`AddCollisionShapeToBody`).
        config: see `ClearanceConfig`.
        period: of the control cycle [s].
        joints: scoped names of the arm's joints in the order of q, such as `iiwa14::joint1`; None: all
            joints of the checker's robot.

    Raises:
        ValueError: naming the bad value, a joint that the checker's plant does not have (a checker of
            another plant), or shapes between which Drake knows no distance.
    """

    def __init__(
        self,
        checker: CollisionChecker,
        config: ClearanceConfig | None = None,
        *,
        period: float,
        joints: Sequence[str] | None = None,
    ) -> None:
        config = config or ClearanceConfig()
        config.validate()
        self.config = config
        self.near = NearPairs(checker, joints, config.influence_distance)
        self._reach = joint_reach(checker, self.near.indices)
        self._period = check_positive_finite("period", period, "s")
        self._rates = clearance_table(load_clearance_rules(config.rules))
        self._least_share = self._share(float(self._rates.consequents.min()))
        self._tolerance = 0.1 * LOSS * self._least_share

    @property
    def period(self) -> float:
        """Period of the control cycle [s]."""
        return self._period

    @property
    def num_joints(self) -> int:
        """The number of the arm's joints, n."""
        return len(self.near.indices)

    @property
    def default_others(self) -> Array:
        """Default positions of all in the checker's plant that is not the arm (p,), in its order."""
        return self.near.default_others

    def distance(self, q: Array, others: Array | None = None) -> float:
        """Distance of the nearest pair at q (n,) [m], inf beyond the influence distance; NaN for bad q."""
        if not np.isfinite(q).all():
            return float("nan")
        return float(min(self.near(q, others).distances, default=inf))

    def is_clear(self, q: Array, others: Array | None = None) -> bool:
        """True if q (n,) is finite and no pair is nearer than the safe distance, but for `LOSS`."""
        if not np.isfinite(q).all():
            return False
        within = max(self.config.safe_distance, LOSS)
        found = self.near(q, others, within).distances
        return not len(found) or bool(found.min() >= self.config.safe_distance - LOSS)

    def names(self, pair: tuple[int, int]) -> tuple[str, str]:
        """Scoped names of the bodies of a pair; empty for no pair."""
        return self.near.names(pair)

    def __call__(
        self,
        q: Array,
        step: Array,
        *,
        J: Array | None = None,
        low: Array | None = None,
        high: Array | None = None,
        others: Array | None = None,
        others_before: Array | None = None,
    ) -> tuple[Array, ClearanceInfo]:
        """The joint step (n,) that keeps clear, and what the obstacles did.

        Args:
            q: the arm's joints (n,) [rad or m].
            step: the step that is asked for (n,) [rad or m].
            J: the task Jacobian at q (m,n): joints that are left free make up for what the obstacles take
                away of the task; None: they do not.
            low: least step of each joint in this cycle (n,) [rad or m]; None: not bounded.
            high: largest step of each joint (n,) [rad or m]; None: not bounded.
            others: positions of all in the checker's plant that is not the arm (p,); None: the defaults.
            others_before: those of the last cycle; None: nothing moves.

        Returns:
            The step; zeros if `q` or the step is not finite.
        """
        if not (np.isfinite(q).all() and np.isfinite(step).all()):
            return np.zeros(len(q)), ClearanceInfo()
        if others is not None and not np.isfinite(others).all():
            return np.zeros(len(q)), ClearanceInfo()
        step = shortened_toward(step, low, high)
        way = float(np.abs(step).dot(self._reach))
        zone = self.config.zone
        if way > zone:
            step, way = step * (zone / way), zone
        near = self.near(q, others)
        if not len(near.distances):
            return step, ClearanceInfo()
        distance = float(near.distances.min())
        moved = self._moved(q, near, others, others_before)
        gaps, change = near.distances - self.config.safe_distance, near.rows.dot(step)
        if moved is None and (change >= -self._least_share * gaps).all() and gaps.min() >= 0.0:
            return step, ClearanceInfo(distance)
        bounds = self._bounds(gaps, change, moved)
        rows, bounds = with_box(near.rows, bounds, low, high)
        asked = step
        step, pushes = project(asked, rows, bounds, self._tolerance)
        if J is not None and pushes.any():
            step, pushes = _again(J, asked, step, pushes, rows, bounds, self._tolerance)
        step = kept(step, rows, bounds, self._tolerance)
        step = self._looked_at(q, step, near, rows, bounds, others, others_before)
        if J is not None and not (bounds > 2.0 * self._tolerance).any():
            step = step * _use(J.dot(asked), J.dot(step))
        return step, self._info(distance, near, pushes, asked, step, J)

    def _share(self, rate: Any) -> Any:
        """The fraction of what is left of a distance that a cycle takes at a rate [1/s]."""
        return 1.0 - (
            exp(-rate * self._period) if isinstance(rate, float) else np.exp(-rate * self._period)
        )

    def _bounds(self, gaps: Array, change: Array, moved: Array | None) -> Array:
        """What the distances (k,) must at least change by in this cycle [m]."""
        if moved is not None:
            change = change + moved
        zone = self.config.zone
        asked = np.maximum(-change, 0.0) / (zone * self._period)
        share = self._share(self._rates(gaps / zone, asked))
        bounds = np.minimum(-share * gaps, self.config.retreat_speed * self._period)
        return bounds if moved is None else bounds - moved

    def _moved(
        self, q: Array, near: Near, others: Array | None, before: Array | None
    ) -> Array | None:
        """What the motion of others in the last cycle changed of the distances (k,) [m]."""
        if others is None or before is None or not np.isfinite(before).all():
            return None
        if (others == before).all():
            return None
        then: dict[tuple[int, int], list[float]] = {}
        found = self.near(q, before, 2.0 * self.config.influence_distance)
        for i, d in enumerate(found.distances.tolist()):
            then.setdefault(found.bodies(i), []).append(d)
        changes = []
        for i, d in enumerate(near.distances.tolist()):
            # Pairs of bodies with several shapes: the nearest are compared.
            was = min(then.get(near.bodies(i), [2.0 * self.config.influence_distance]))
            now = min(
                x for j, x in enumerate(near.distances.tolist()) if near.bodies(j) == near.bodies(i)
            )
            changes.append(max(min(now - was, d), -self.config.influence_distance))
        return np.array(changes)

    def _looked_at(
        self,
        q: Array,
        step: Array,
        near: Near,
        rows: Array,
        bounds: Array,
        others: Array | None,
        before: Array | None,
    ) -> Array:
        """The step, corrected where its end is nearer than its tangents say."""
        size = np.abs(step)
        bend = 0.5 * float(size.sum() * size.dot(self._reach))
        least = min(self.config.safe_distance, float(near.distances.min()))
        k = len(near.distances)
        if bend <= BENT or (near.distances + rows[:k].dot(step)).min() > least + bend:
            return step
        if others is not None and before is not None and np.isfinite(before).all():
            others = others + (others - before)
        for look in range(LOOKS):
            end = self.near(q + step, others)
            if not len(end.distances) or end.distances.min() >= least - LOSS:
                return step
            if look + 2 < LOOKS:
                rows = np.vstack([rows, end.rows])
                bounds = np.concatenate([bounds, least - end.distances + end.rows.dot(step)])
                step, _ = project(step, rows, bounds)
            else:
                step = 0.5 * step
        return np.zeros(len(step))

    def _info(
        self, distance: float, near: Near, pushes: Array, asked: Array, step: Array, J: Array | None
    ) -> ClearanceInfo:
        lost, whole = (asked - step, asked) if J is None else (J.dot(asked - step), J.dot(asked))
        blocked = lost.dot(lost) > BLOCKED**2 * whole.dot(whole)
        ours = pushes[: len(near.distances)]
        pair = near.bodies(int(ours.argmax())) if ours.any() else NONE
        return ClearanceInfo(distance, bool(blocked) and pair != NONE, pair)


def _again(
    J: Array,
    asked: Array,
    step: Array,
    pushes: Array,
    rows: Array,
    bounds: Array,
    tolerance: float,
) -> tuple[Array, Array]:
    """The step with what was lost of the task asked again of the joint motion that is left free, damped."""
    free = free_part(J, rows[pushes > 0.0])
    square = free.dot(free.T)
    m = len(square)
    square.flat[:: m + 1] += DAMPING * max(float(np.einsum("ij,ij->", J, J)), 1e-300) / m
    more = np.linalg.solve(square, J.dot(asked - step)).dot(free)
    if not np.isfinite(more).all():
        return step, pushes
    again, pushed = project(step + more, rows, bounds, tolerance)
    return again, np.maximum(pushes, pushed)


def _use(asked: Array, left: Array) -> float:
    """1, less where next to nothing is left of the task's motion (m,): an arm that is stuck shall rest.

    What would go on is a drift of its joints along the obstacle, which brings the tool no nearer.
    """
    whole = float(asked.dot(asked))
    if whole == 0.0:
        return 1.0
    nothing, something = USELESS
    use = (float(left.dot(asked)) / whole - nothing) / (something - nothing)
    return min(1.0, max(0.0, use))


def make_clearance(
    arm: PlantArm, checker: CollisionChecker, config: ClearanceConfig, period: float
) -> Clearance:
    """The clearance of a controller's arm; the checker's plant has joints of the same names.

    Raises:
        ValueError: naming the bad value; the checker is of another plant.
    """
    chain = getattr(arm, "chain", None)
    names = arm_joint_names(arm.plant, None if chain is None else chain.position_indices)
    return Clearance(checker, config, period=period, joints=names)
