"""The self-motion of an arm with one spare degree of freedom, traced within its limits."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts, check_number
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.self_motion.curve import CurvePoint, SelfMotionCurve
from fikm_drake.solvers.self_motion.events import turning_point
from fikm_drake.solvers.self_motion.interval_table import FULL_TURN, TURNING_POINT
from fikm_drake.solvers.self_motion.loops import (
    Piece,
    both_ways,
    dense,
    free_line,
    seeds,
)
from fikm_drake.solvers.self_motion.polyline import Polylines
from fikm_drake.solvers.self_motion.self_motion import (
    SelfMotion,
    SelfMotionComponent,
    SelfMotionStatus,
)
from fikm_drake.solvers.self_motion.spare_task import SpareTask
from fikm_drake.solvers.self_motion.walk import AT_LIMIT, CLOSED, SINGULAR, TOO_LONG, Walls

MAX_STEP = 0.2
"""[rad or m]."""
SEARCHES = 6
"""Random postures for each joint that must lead to a known curve before the search ends."""
NOISE = 1e-9
"""Motion of a joint that does not move, of the tangent's length."""


def trace_self_motion(
    arm_or_plant: DhArm | SerialChain | MultibodyPlant,
    q_or_target: ArrayLike | RigidTransform,
    task: str | Task = "position",
    *,
    frame: str = "tool",
) -> SelfMotion:
    """All motions that hold the tool at a target while every joint is within its limits.

    For an arm with one degree of freedom more than the task fixes they are curves in the space of
    its joints. Each is traced by a predictor along the null vector of the Jacobian and a corrector,
    and ends exactly on the limit that it meets first, by Newton's method on the target and the limit
    together.

        motion = fd.trace_self_motion(fd.load_arm("iiwa14"), q, "pose")
        motion.components[0].ends  # such as ("joint 2 lower", "joint 6 upper")

    To trace many targets of one arm, make a `SelfMotionTracer` and keep it.

    Args:
        arm_or_plant: the arm, a chain of `SerialChain.from_plant`, or a finalized plant with the arm only.
        q_or_target: n joint positions [rad or m], whose target is where the tool is then; or a
            target in the world frame: the coordinates that count [m], a pose (4,4) or a
            RigidTransform. A vector of n numbers is taken for joint positions.
        task: what the target fixes; it must leave one degree of freedom. A planar arm with three
            joints has `xy`, one with four has `pose`, a spatial one with seven has `pose`.
        frame: name of the tool's frame in a plant.

    Returns:
        The components, first the one that `q` is on if it is within the limits; `SelfMotion.status`
        tells what is missing. Where the range of a joint is a whole turn or more, components other
        than the first are sought from the postures nearest to the middle of its range.

    Raises:
        ValueError: the task leaves none or more than one degree of freedom; a bad plant, frame,
            task, posture or target.
    """
    return SelfMotionTracer(arm_or_plant, task, frame=frame).trace(q_or_target)


class SelfMotionTracer:
    """Traces self-motions of one arm with one task; see `trace_self_motion`.

    All curves that hold the target are found from random postures and traced without limits first;
    so no piece within the limits is missed because it is small. Not for several threads at once.

    Args:
        arm_or_plant: the arm, or a finalized MultibodyPlant.
        task: what a target fixes.
        frame: name of the tool's frame in a plant.
        searches: random postures in a row that must lead to a known curve before the search ends;
            None: 6 for each joint that moves the tool, 18 for a planar 3R, 42 for a 7-joint arm.
        max_step: longest step along a curve [rad or m].
        seed: of the random postures.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        arm_or_plant: DhArm | SerialChain | MultibodyPlant,
        task: str | Task = "position",
        *,
        frame: str = "tool",
        searches: int | None = None,
        max_step: float = MAX_STEP,
        seed: int = 0,
    ) -> None:
        if searches is not None:
            check_counts(searches=searches)
        check_counts(0, seed=seed)
        check_number("max_step", max_step, "in (0, 0.5] [rad or m]", lambda x: 0.0 < x <= 0.5)
        self._task = SpareTask(arm_or_plant, task, frame)
        self._searches = searches or SEARCHES * len(self._task.moving)
        self._max_step, self._seed = max_step, seed
        endless = np.isinf(self._task.lower) & np.isinf(self._task.upper)
        self._walls = Walls(self._task.lower, self._task.upper, self._task.revolute & endless)

    @property
    def task(self) -> Task:
        """What a target fixes."""
        return self._task.task

    def trace(self, q_or_target: ArrayLike | RigidTransform) -> SelfMotion:
        """The self-motion at a posture's or at a given target; see `trace_self_motion`."""
        task = self._task
        q, target = self._posture_and_target(q_or_target)
        curve = SelfMotionCurve(task, target, task.default_position if q is None else q)
        first = None
        if q is not None:  # where it is singular it is on its own curve all the same
            here = q[task.moving]
            first = curve.point(here) or CurvePoint(here, curve.direction(here))
        lines = self._free_lines(curve, first)
        starts = [seed for line, closed in lines for seed in seeds(curve, line, closed)]
        if first and _is_inside(task, first.q):
            starts.insert(0, first)
        pieces: list[Piece] = []
        traced = Polylines(self._walls.periodic)
        for start in starts:
            if not traced.meet(start.q):
                pieces.append(both_ways(curve, start, self._walls, self._max_step))
                traced.add(dense(pieces[-1]))
        return SelfMotion(_status(bool(lines), pieces), [_component(curve, p) for p in pieces])

    def _posture_and_target(
        self, q_or_target: ArrayLike | RigidTransform
    ) -> tuple[Array | None, RigidTransform]:
        if not isinstance(q_or_target, RigidTransform):
            q = np.asarray(q_or_target, dtype=float)
            if q.shape == (self._task.num_joints,):
                if not np.isfinite(q).all():
                    raise ValueError(f"joint positions must be finite, got {q}")
                return q, self._task.pose(q)
        return None, self._task.target(q_or_target)

    def _free_lines(
        self, curve: SelfMotionCurve, first: CurvePoint | None
    ) -> list[tuple[Array, bool]]:
        """The curves that hold the target without limits, as dense polylines; whether each closes."""
        task = self._task
        rng = np.random.default_rng(self._seed)
        lines: list[tuple[Array, bool]] = []
        traced, point, known = Polylines(task.revolute), first, 0
        while True:
            if point and not traced.meet(point.q):
                lines.append(free_line(curve, point, self._max_step))
                traced.add(lines[-1][0])
                known = 0
            if known == self._searches:
                return lines
            near, point = curve.arrive(rng.uniform(*task.search_range)), None
            if near is not None and not traced.meet(near):
                point = curve.point(near)
                point = point if point is not None and curve.is_met(point.q) else None
            known += 1


def _is_inside(task: SpareTask, q: Array) -> bool:
    return bool(((q >= task.lower - AT_LIMIT) & (q <= task.upper + AT_LIMIT)).all())


def _status(reachable: bool, pieces: list[Piece]) -> SelfMotionStatus:
    if any(end in (SINGULAR, TOO_LONG) for piece in pieces for end in piece.ends):
        return SelfMotionStatus.INCOMPLETE
    if pieces:
        return SelfMotionStatus.TRACED
    return SelfMotionStatus.INFEASIBLE if reachable else SelfMotionStatus.UNREACHABLE


def _component(curve: SelfMotionCurve, piece: Piece) -> SelfMotionComponent:
    task = curve.task
    bounds = np.array([curve.start, curve.start])
    ends = [[TURNING_POINT] * task.num_joints for _ in range(2)]
    for side, sign in enumerate((-1.0, 1.0)):
        bounds[side, task.moving], found = _extents(curve, piece, sign)
        for joint, end in zip(task.moving.tolist(), found):
            ends[side][joint] = end
    return SelfMotionComponent(
        task.full(piece.q, curve.start),
        task.full(piece.tangents, np.zeros(task.num_joints)),
        piece.lengths,
        piece.ends,
        bounds[0],
        bounds[1],
        tuple(ends[0]),
        tuple(ends[1]),
        curve,
    )


def _extents(curve: SelfMotionCurve, piece: Piece, sign: float) -> tuple[Array, list[str]]:
    """Least (`sign` −1) or greatest (1) positions (k,), and what keeps each joint from going on."""
    q, rates = sign * piece.q, sign * piece.tangents
    best, last = np.argmax(q, axis=0), len(q) - 1
    values, ends = q.max(axis=0), [TURNING_POINT] * q.shape[1]
    for joint in np.flatnonzero((best == 0) | (best == last)).tolist():
        ends[joint] = piece.ends[0 if best[joint] == 0 else 1]
        if ends[joint] == CLOSED:
            turned = abs(q[-1, joint] - q[0, joint]) > 1.0
            ends[joint] = FULL_TURN if turned else TURNING_POINT
    # Between two points a joint may go a little further than at either.
    step = np.sqrt(np.sum(np.diff(q, axis=0) ** 2, axis=1))[:, None]
    hump = (rates[:-1] > NOISE) & (rates[1:] < -NOISE)
    reach = np.maximum(q[:-1], q[1:]) + step * np.minimum(rates[:-1], -rates[1:])
    for i, joint in np.argwhere(hump & (reach > values)).tolist():
        here, there = (CurvePoint(piece.q[k], piece.tangents[k]) for k in (i, i + 1))
        top = sign * turning_point(curve, here, there, joint).q[joint]
        if top > values[joint]:
            values[joint], ends[joint] = top, TURNING_POINT
    return sign * values, ends
