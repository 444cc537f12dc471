"""Postures that hold the tool at poses with one joint at given positions, by Newton's method."""

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.angles import middle_of_limits, nearest_turn
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.kinematics.unit_chain import in_reaches, joint_units, unit_chain
from fikm_drake.solvers.batch.batch_targets import BatchTargets
from fikm_drake.solvers.batch.descent import LENGTH, solve_positive_definite
from fikm_drake.solvers.batch.posture_pool import PosturePool
from fikm_drake.solvers.redundancy.tool_targets import tool_errors

POOL = 1024
"""Postures to choose from."""
NEAR, STARTS = 32, 4
"""Postures of the pool with their tool nearest to a pose, and those of them that are started from."""
CHUNK = 1024
"""Poses that are solved side by side: their arrays stay in the processor's cache."""
ITERATIONS = 25
"""Steps at most."""
CONVERGED = 1e-9
"""Error before the last step [reach]: the error after it is the square of that."""
LONGEST = 0.5
"""Longest step of a joint [rad or m]."""
DAMPING = 1e-2
"""Damping of the steps, times the square of the error [-]."""
TINY = 1e-20
"""Keeps a pivot off zero [reach²]."""
MET = 1e-9
"""A posture with less error holds the tool [reach, rad]."""


class PosturesAtJoint:
    """Postures of an arm that hold the tool at poses, with one joint at given positions.

    Without the joint as many degrees of freedom are left as the task fixes. They are sought by damped
    Newton steps, for all poses side by side, from a few random postures whose tool and joint are near.

    Args:
        arm: the arm.
        task: it leaves one degree of freedom.
        joint: its index, from 0.
    """

    def __init__(self, arm: DhArm | SerialChain, task: Task, joint: int) -> None:
        self._task, self._joint = task, joint
        self._whole, self._units = arm.chain, joint_units(arm.chain)
        self._chain = chain = unit_chain(arm.chain)
        self._pool = PosturePool(chain, LENGTH, seed=0, size=POOL)
        self._others = np.delete(np.arange(chain.num_joints), joint)
        self._middle = middle_of_limits(chain.lower, chain.upper)

    def solve(self, poses: Array, positions: Array) -> tuple[Array, Bools]:
        """Joint positions of those inside the limits, the posture that is closest to their middle.

        Args:
            poses: (N,4,4).
            positions: (N,) of the joint [rad or m].

        Returns:
            Postures (N,n), and which of them hold the tool inside the limits (N,).
        """
        q, good = np.empty((len(poses), self._chain.num_joints)), np.empty(len(poses), dtype=bool)
        poses = in_reaches(poses, self._whole)
        positions = positions / self._units[self._joint]
        for start in range(0, len(poses), CHUNK):
            rows = slice(start, start + CHUNK)
            q[rows], good[rows] = self._solve(poses[rows], positions[rows])
        return q * self._units, good

    def _solve(self, poses: Array, positions: Array) -> tuple[Array, Bools]:
        chain, count = self._chain, len(poses)
        rows = np.repeat(np.arange(count), STARTS)
        targets = BatchTargets.from_array(poses)
        near = self._pool.nearest(targets, NEAR)
        away = np.abs(self._pool.q[self._joint, near] - positions[:, None])
        chosen = np.take_along_axis(near, np.argsort(away, axis=1)[:, :STARTS], axis=1)
        q = self._pool.q[:, chosen.ravel()]
        q[self._joint] = positions[rows]
        self._descend(q, targets.take(rows))
        q = q.T
        q += np.where(chain.revolute, nearest_turn(q, self._middle), 0.0)
        distance, turn = tool_errors(chain, self._task, q, poses[rows])
        inside = ((q >= chain.lower) & (q <= chain.upper)).all(axis=1)
        good = inside & (distance < MET) & (turn < MET)
        cost = np.where(good, np.sum((q - self._middle) ** 2, axis=1), np.inf)
        best = STARTS * np.arange(count) + np.argmin(cost.reshape(count, STARTS), axis=1)
        return q[best], good[best]

    def _descend(self, q: Array, targets: BatchTargets) -> None:
        """Move the other joints of starts `q` (n,L) towards one target each, in place."""
        task, others = self._task, self._others
        active = np.arange(q.shape[1])
        for _ in range(ITERATIONS):
            frames = self._chain.frames(q[:, active])
            error, _, _ = targets.take(active).error(frames, LENGTH)
            error = error[task.rows]
            J = frames.jacobian(LENGTH)[task.rows][:, others]
            square = np.sum(error * error, axis=0)
            M = np.einsum("ijl,ikl->jkl", J, J)
            M[np.arange(len(others)), np.arange(len(others))] += DAMPING * square + TINY
            step = solve_positive_definite(M, np.einsum("ijl,il->jl", J, error))
            step *= np.minimum(1.0, LONGEST / np.maximum(np.abs(step).max(axis=0), LONGEST))
            q[np.ix_(others, active)] += step
            active = active[square > CONVERGED**2]
            if not active.size:
                return
