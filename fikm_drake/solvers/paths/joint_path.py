"""Continuous joint positions along a path of the tool (`fd.joint_path`)."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array, Bools
from fikm_drake.checks import check_counts, check_positive_finite
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.kinematics.serial_chain import HasChain, SerialChain, as_chain
from fikm_drake.solvers.count_statuses import count_statuses
from fikm_drake.solvers.paths.path_solver import PathSolver
from fikm_drake.solvers.paths.path_targets import SAMPLES, Targets, between, path_targets

LENGTH = 0.25
"""The characteristic length of rotations over the reach [-]."""
APART = 0.02
"""Targets further apart than this fraction of the reach are reached through others in between [-]."""
STARTS = 64
"""Random postures from which postures of a target are searched [-]."""
TRIES, AHEAD = 8, 40
"""Postures that are tried at a reconfiguration, and the number of targets that each is tried on [-]."""
STILL = 1e-3
"""What a joint may move where the tool does not [rad, or over the reach]."""


class PathStatus(IntEnum):
    """How a target of a path was met."""

    INVALID_INPUT = 0
    """The target is NaN, infinite or no pose; the joints stay."""
    FOLLOWED = 1
    """Within the tolerance, without a leap."""
    RECONFIGURED = 2
    """Within the tolerance, but the joints have to change to another posture before this target."""
    NOT_REACHED = 3
    """No posture was found that is inside the limits, clear, and solves the target; the joints stay."""


@dataclass(frozen=True)
class JointPath:
    """Joint positions along a path of the tool.

    Attributes:
        chain: the arm.
        q: (N,n) joint positions [rad or m], never NaN.
        status: (N,) values of `PathStatus`.
        error: (N,) of the tool [m], rotations times the characteristic length; NaN for invalid targets.
        targets: (N,3) or (N,4,4).
        max_ratio: the factor that no step is longer than, see `joint_path`.
    """

    chain: SerialChain
    q: Array
    status: NDArray[np.int_]
    error: Array
    targets: Array
    max_ratio: float

    @property
    def success(self) -> bool:
        """True if every target was followed."""
        return bool((self.status == PathStatus.FOLLOWED).all())

    @property
    def reached(self) -> Bools:
        """(N,): within the tolerance."""
        return (self.status == PathStatus.FOLLOWED) | (self.status == PathStatus.RECONFIGURED)

    @property
    def reconfigurations(self) -> NDArray[np.intp]:
        """Indices of the targets before which the joints have to change posture."""
        return np.flatnonzero(self.status == PathStatus.RECONFIGURED)

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        where = "".join(f", at target {k}" for k in self.reconfigurations[:3].tolist())
        return f"<JointPath: {count_statuses(self.status, PathStatus)}{where}>"


def joint_path(
    arm: SerialChain | HasChain,
    targets: Targets,
    *,
    task: str | None = None,
    initial_position: ArrayLike | None = None,
    collision_checker: CollisionChecker | None = None,
    clearance: ClearanceConfig | None = None,
    tolerance: float = 1e-6,
    max_ratio: float = 20.0,
    samples: int = SAMPLES,
    seed: int = 0,
) -> JointPath:
    """Joint positions that lead the tool along targets, continuously where that is possible.

        path = fd.joint_path(fd.load_arm("panda"), poses, initial_position=home)
        if path.success:
            trajectory = fd.path_trajectory(path)
        else:
            print(path)     # <JointPath: 117 followed, 1 reconfigured, at target 63>

    Args:
        arm: a chain, or what has one.
        targets: positions (N,3) [m] or poses (N,4,4) in the chain's base frame, RigidTransforms, or a
            Drake trajectory of these.
        task: `position` or `pose`; None: what the targets are. `position` ignores their rotation.
        initial_position: where the joints are before the first target (n,) [rad or m]; the posture
            of the first target is the one next to it. None: the posture that follows best.
        collision_checker: of the chain's world; postures and the ways between them are then clear.
        clearance: distances to keep; None: the defaults of `ClearanceConfig`.
        tolerance: of the error, rotations times a quarter of the reach [m].
        max_ratio: no joint turns by more than this many radians (slides by this many reaches) while the
            tool moves by a reach of the arm, a turn of 1 rad counting as a quarter of it.
        samples: targets that are taken of a trajectory.
        seed: of the random postures.

    Returns:
        One row a target.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    chain = as_chain(arm)
    array = path_targets(targets, samples=samples)
    task = task or ("position" if array.ndim == 2 else "pose")
    if task not in ("position", "pose") or (task == "pose" and array.ndim == 2):
        raise ValueError(
            f"task must be 'position', or with poses 'pose', got {task!r} and {array.shape}"
        )
    if task == "position" and array.ndim == 3:
        array = array[:, :3, 3]
    check_counts(0, seed=seed)
    guard = None
    if collision_checker is not None:
        names = None if chain.position_indices is None else list(chain.joint_names)
        guard = Clearance(collision_checker, clearance, period=0.02, joints=names)
        if guard.num_joints != chain.num_joints:
            raise ValueError(
                f"collision_checker has a robot of {guard.num_joints} joints, the arm {chain.num_joints}"
            )
    solver = PathSolver(
        chain, LENGTH * chain.reach, check_positive_finite("tolerance", tolerance, "m"), guard
    )
    follower = _Follower(solver, array, check_positive_finite("max_ratio", max_ratio, "-"), seed)
    start = None if initial_position is None else _checked_start(chain, initial_position)
    q, status, error = follower.run(start)
    return JointPath(chain, q, status, error, array, max_ratio)


class _Follower:
    """Goes along the targets, looks for another posture where it must."""

    def __init__(self, solver: PathSolver, targets: Array, max_ratio: float, seed: int) -> None:
        self._solver, self._targets, self._ratio = solver, targets, max_ratio
        self._valid = np.isfinite(targets).reshape(len(targets), -1).all(axis=1)
        if targets.ndim == 3:
            R = targets[self._valid][:, :3, :3]
            far = np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).reshape(len(R), 9).max(axis=1)
            self._valid[self._valid] = (far < 1e-4) & (np.linalg.det(R) > 0.0)
        chain = solver.chain
        low, high = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
        slides = ~chain.revolute
        low = np.where(slides, np.maximum(chain.lower, -chain.reach), low)
        high = np.where(slides, np.minimum(chain.upper, chain.reach), high)
        n = chain.num_joints
        self._starts = low + (high - low) * np.random.default_rng(seed).random((STARTS, n))
        self._units = np.where(chain.revolute, 1.0, chain.reach)

    def run(self, start: Array | None) -> tuple[Array, NDArray[np.int_], Array]:
        """Joint positions (N,n), statuses (N,) and errors (N,)."""
        count = len(self._targets)
        q = np.empty((count, self._solver.chain.num_joints))
        status = np.full(count, PathStatus.INVALID_INPUT.value)
        error = np.full(count, np.nan)
        here, last = start, -1  # the last target that was reached
        for k in range(count):
            if self._valid[k]:
                there = None
                if last >= 0 and here is not None:
                    there = self._follow(here, last, k)
                status[k] = PathStatus.FOLLOWED
                if there is None:
                    there = self._other_posture(here, k, first=last < 0)
                    status[k] = PathStatus.FOLLOWED if last < 0 else PathStatus.RECONFIGURED
                if there is None:
                    status[k] = PathStatus.NOT_REACHED
                else:
                    here, last = there, k
            q[k] = self._solver.chain.default_position if here is None else here
            if self._valid[k]:
                error[k] = self._solver.errors(q[k][None], self._targets[k])[1][0]
        return q, status, error

    def _follow(self, q: Array, before: int, k: int) -> Array | None:
        """The posture of target k, continuous from q at target `before`; None: there is none."""
        one, two = self._targets[before], self._targets[k]
        reach = self._solver.chain.reach
        motion = self._motion(one, two)
        parts = max(1, int(np.ceil(motion / (APART * reach))))
        for i in range(1, parts + 1):
            target = two if i == parts else between(one, two, i / parts)
            there, size = self._solver.follow(q, target, motion / parts)
            most = self._ratio * motion / parts / reach + STILL
            leaps = np.abs((there - q) / self._units).max() > most
            if size > self._solver.tolerance or leaps or not self._solver.clear_between(q, there):
                return None
            q = there
        return q

    def _other_posture(self, q: Array | None, k: int, *, first: bool) -> Array | None:
        """The posture of target k that follows furthest; of a first one, that next to q."""
        solver, target = self._solver, self._targets[k]
        if first and q is not None:
            there, size = solver.follow(q, target, 0.0)
            if size <= solver.tolerance and solver.clear_between(there, there):
                return there
        starts = self._starts if q is None else np.vstack([q, self._starts])
        found = solver.search(target, starts)
        if not len(found):
            return None
        chain = solver.chain
        middle = np.clip(np.zeros(chain.num_joints), chain.lower, chain.upper) if q is None else q
        found = found[np.argsort(np.abs((found - middle) / self._units).max(axis=1))]
        if first and q is not None:
            return found[0]
        chosen, furthest = found[0], -1
        for there in _distinct(found)[:TRIES]:
            far = self._ahead(there, k)
            if far > furthest:
                chosen, furthest = there, far
        return chosen

    def _ahead(self, q: Array, k: int) -> int:
        """The number of targets after k that q follows."""
        here: Array | None = q
        for after in range(k + 1, min(len(self._targets), k + 1 + AHEAD)):
            if not self._valid[after] or here is None:
                return after - k - 1
            here = self._follow(here, after - 1, after)
            if here is None:
                return after - k - 1
        return AHEAD

    def _motion(self, one: Array, two: Array) -> float:
        """How far the tool moves between two targets [m]."""
        if one.ndim == 1:
            return float(np.linalg.norm(two - one))
        cosine = 0.5 * (np.trace(one[:3, :3].T @ two[:3, :3]) - 1.0)
        turn = self._solver.length * float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return float(np.hypot(np.linalg.norm(two[:3, 3] - one[:3, 3]), turn))


def _distinct(found: Array) -> Array:
    """Postures (K,n) that differ from those before them by 0.1 rad or more in a joint."""
    kept: list[Array] = []
    for q in found:
        if all(np.abs(q - other).max() > 0.1 for other in kept):
            kept.append(q)
    return np.array(kept)


def _checked_start(chain: SerialChain, start: ArrayLike) -> Array:
    q = np.array(start, dtype=float)
    n = chain.num_joints
    if q.shape != (n,) or not np.isfinite(q).all():
        raise ValueError(f"initial_position must be {n} finite numbers [rad or m], got {start!r}")
    if (q < chain.lower).any() or (q > chain.upper).any():
        joint = int(np.flatnonzero((q < chain.lower) | (q > chain.upper))[0])
        raise ValueError(
            f"initial_position of {chain.joint_names[joint]} must be in "
            f"[{chain.lower[joint]:g}, {chain.upper[joint]:g}], got {q[joint]:g}"
        )
    return q
