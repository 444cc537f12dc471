"""A joint step that keeps clear of obstacles and of the arm itself."""

from collections.abc import Sequence
from functools import partial
from math import inf
from typing import NamedTuple

import numpy as np
from pydrake.planning import CollisionChecker, RobotClearance

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import check_positive_finite
from fikm_drake.control.clear_step import LOOKS, LOSS, Bounds, ClearStep
from fikm_drake.control.clearance_config import (
    ClearanceConfig,
    clearance_table,
    load_clearance_rules,
)
from fikm_drake.control.joint_limits import StepBox
from fikm_drake.control.near_pairs import Near, NearPairs, pair_of
from fikm_drake.control.steps import length
from fikm_drake.kinematics.checker_joints import arm_joint_names, joint_reach
from fikm_drake.kinematics.native.kernel import kernel
from fikm_drake.kinematics.native.native_clearance import NativeAnswer, NativeClearStep
from fikm_drake.kinematics.plant_arm import PlantArm

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


class Around(NamedTuple):
    """What is near at joint positions."""

    q: Array
    """(n,) [rad or m]."""
    others: Array | None
    """Positions of all in the checker's plant that is not the arm (p,); None: the defaults."""
    found: RobotClearance
    """What the checker said."""
    near: Near | None
    """The pairs that the arm's joints move; None: the native kernel has them."""
    pairs: int
    """How many they are."""
    taken: int
    """The kernel's mark of them."""


class Clearance:
    """Turns a law's joint step into the nearest one that keeps clear.

    Each pair of bodies at a distance d below the influence distance is one row a = ∂d/∂q, and
    a · dθ ≥ −(1 − exp(−rate T)) (d − d_safe) − ḋ_others T is what this cycle allows: the distance to the
    safe one shrinks at the `rate` that fuzzy rules read off distance and speed of approach; a pair that is
    too near is parted at that rate; what others move toward the arm is added. Rows that the step
    violates are projected (`row_projection`), in a metric in which motion of the tool is dear: a
    redundant arm gives way with its elbow and not with its tool.

    Rows are tangents. Therefore no point of the arm moves further in a cycle than the influence zone is
    wide, and a step that could end too near is looked at where it ends; there it is corrected,
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
        self.config, self._checker = config, checker
        self.near = NearPairs(checker, joints, config.influence_distance)
        self._period = check_positive_finite("period", period, "s")
        rates = clearance_table(load_clearance_rules(config.rules))
        reach = joint_reach(checker, self.near.indices)
        self._clear = ClearStep(config, self._period, rates, reach)
        self._native = self._clear.native(self.near.indices, self.near.num_positions, kernel())

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

    @property
    def native(self) -> NativeClearStep | None:
        """The kernel's step that keeps clear; None: numpy's."""
        return self._native

    def distance(self, q: Array, others: Array | None = None) -> float:
        """Distance of the nearest pair at q (n,) [m], inf beyond the influence distance; NaN for bad ones."""
        if not may_ask(q, others):
            return float("nan")
        return self._distance(q, others, self.config.influence_distance)

    def is_clear(self, q: Array, others: Array | None = None) -> bool:
        """True if q (n,) is finite and no pair is nearer than the safe distance, but for `LOSS`."""
        return self.room(q, others, within=max(self.config.safe_distance, LOSS)) >= -LOSS

    def room(self, q: Array, others: Array | None = None, *, within: float = 0.0) -> float:
        """How much farther than the safe distance the nearest pair is at q (n,) [m]; −inf for bad input.

        Args:
            q: the arm's joints (n,) [rad or m].
            others: positions of all in the checker's plant that is not the arm (p,); None: the defaults.
            within: nothing is farther off than this [m]; 0: than twice the influence distance.
        """
        if not may_ask(q, others):
            return -inf
        within = within or 2.0 * self.config.influence_distance
        return min(self._distance(q, others, within), within) - self.config.safe_distance

    def _distance(self, q: Array, others: Array | None, within: float) -> float:
        found = self.near.ask(q, others, within)
        if self._native and self._native.take(found, self.near.padded) >= 0:
            return self._native.distance
        return float(self.near.of(found, q, others).distances.min(initial=inf))

    def reach(self) -> Array:
        """Bounds (n,) of how far the joints move points of the arm, and of what it holds now [m/rad or 1]."""
        return joint_reach(self._checker, self.near.indices)

    def names(self, pair: tuple[int, int]) -> tuple[str, str]:
        """Scoped names of the bodies of a pair; empty for no pair."""
        return self.near.names(pair)

    def around(self, q: Array, others: Array | None = None) -> Around | None:
        """What is near q (n,); None if it, or where others are (p,), is not finite."""
        if not may_ask(q, others):
            return None
        found = self.near.ask(q, others)
        count, near, taken = -1, None, 0
        if self._native:
            count = self._native.take(found, self.near.padded)
            taken = self._native.taken
        if count < 0:
            near = self.near.of(found, q, others)
            count = len(near.distances)
        return Around(q, others, found, near, count, taken)

    def __call__(
        self,
        q: Array,
        step: Array,
        *,
        J: Array | None = None,
        low: Array | None = None,
        high: Array | None = None,
        bounds: Bounds | None = None,
        others: Array | None = None,
        others_before: Array | None = None,
    ) -> tuple[Array, ClearanceInfo]:
        """The joint step (n,) that keeps clear, and what the obstacles did.

        Args:
            q: the arm's joints (n,) [rad or m].
            step: the step that is asked for (n,) [rad or m].
            J: the task Jacobian at q (m,n), which tells what motion is dear; None: all is alike.
            low: least step of each joint in this cycle (n,) [rad or m]; None: not bounded.
            high: largest step of each joint (n,) [rad or m]; None: not bounded.
            bounds: instead of both where the step is known to be inside them: tells them when it has to
                change.
            others: positions of all in the checker's plant that is not the arm (p,); None: the defaults.
            others_before: those of the last cycle; None: nothing moves.

        Returns:
            The step; zeros if `q` or the step is not finite.
        """
        around = self.around(q, others)
        return self.keep(
            around, step, J=J, low=low, high=high, bounds=bounds, others_before=others_before
        )

    def keep(
        self,
        around: Around | None,
        step: Array,
        *,
        J: Array | None = None,
        low: Array | None = None,
        high: Array | None = None,
        bounds: Bounds | None = None,
        others_before: Array | None = None,
    ) -> tuple[Array, ClearanceInfo]:
        """What a call does, by what is known to be near; None: an input is not finite, the joints hold."""
        if around is None or not all_finite(step):
            return np.zeros(len(step)), ClearanceInfo()
        q, others, found, near, _, taken = around
        after, moved = self.near.moving(q, found, others, others_before)
        if self._native and near is None:
            answer = self._native(
                step,
                found,
                lambda step: self.near.ask(q + step, after),
                LOOKS,
                taken=taken,
                J=J,
                low=low,
                high=high,
                bounds=bounds,
                moved=moved,
            )
            if answer is not None:
                return answer.step, info_of(answer, found)
        near = self.near.of(found, q, others) if near is None else near
        cleared = self._clear(
            step,
            near,
            lambda step: self.near(q + step, after),
            J=J,
            low=low,
            high=high,
            bounds=bounds,
            moved=None if moved is None else moved[near.places],
        )
        pair = pair_of(found, int(near.places[cleared.row])) if cleared.row >= 0 else NONE
        return cleared.step, ClearanceInfo(cleared.distance, cleared.blocked, pair)

    def keep_inside(
        self,
        around: Around | None,
        step: Array,
        *,
        J: Array,
        box: StepBox,
        velocity: Array,
        others_before: Array,
    ) -> tuple[Array, ClearanceInfo]:
        """What `keep` does inside the limits of the joints, whose bounds are worked out only where needed.

        Args:
            around: of `around`, or None.
            step: the step that is asked for (n,) [rad or m].
            J: the task Jacobian (m,n).
            box: the limits about the command.
            velocity: the last change of the command over the period (n,) [rad/s or m/s].
            others_before: where others were in the last cycle (p,).
        """
        if box.surely_holds(length(step)):
            bounds = partial(box.bounds, velocity)
            return self.keep(around, step, J=J, bounds=bounds, others_before=others_before)
        low, high = box.bounds(velocity)
        return self.keep(around, step, J=J, low=low, high=high, others_before=others_before)


def info_of(answer: NativeAnswer, found: RobotClearance) -> ClearanceInfo:
    """What the kernel says that obstacles did, by what the checker found."""
    pair = pair_of(found, answer.row) if answer.row >= 0 else NONE
    return ClearanceInfo(answer.distance, answer.blocked, pair)


def may_ask(q: Array, others: Array | None) -> bool:
    """True if both may reach the checker: Drake ends the process on positions that are not finite."""
    return all_finite(q) and (others is None or all_finite(others))


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
