"""Continuous joint positions along a path of the tool (`fd.joint_path`)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.planning import CollisionChecker
from pydrake.trajectories import PathParameterizedTrajectory

from fikm_drake.arrays import Array, Bools
from fikm_drake.checks import check_counts, check_positive_finite
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.files import write_whole
from fikm_drake.kinematics.serial_chain import HasChain, SerialChain, as_chain
from fikm_drake.solvers.count_statuses import count_statuses
from fikm_drake.solvers.paths.path_follower import Follower, PathStatus
from fikm_drake.solvers.paths.path_solver import PathSolver
from fikm_drake.solvers.paths.path_targets import SAMPLES, Targets, path_targets
from fikm_drake.solvers.paths.path_trajectory import path_trajectory

LENGTH = 0.25
"""The characteristic length of rotations over the reach [-]."""


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

    def trajectory(
        self,
        *,
        velocity_limits: ArrayLike | None = None,
        acceleration_limits: ArrayLike | None = None,
    ) -> PathParameterizedTrajectory:
        """The path in time, from rest to rest, as fast as the limits allow, by Drake's Toppra.

        Args:
            velocity_limits: of each joint, one number or (n,) [rad/s or m/s]; None: the chain's, and 1
                for joints that have none.
            acceleration_limits: of each joint, one number or (n,) [rad/s² or m/s²]; None: the chain's,
                and for joints that have none, what reaches the limit of speed in 0.1 s.

        Raises:
            ValueError: a target was not followed (the message says which), all rows are one, or a limit is
                not positive and finite.
            RuntimeError: Toppra finds no solution.
        """
        if not self.success:
            bad = np.flatnonzero(self.status != PathStatus.FOLLOWED)
            word = PathStatus(int(self.status[bad[0]])).name
            raise ValueError(
                f"the path must be followed throughout, but {len(bad)} of its {len(self)} targets are "
                f"not: target {bad[0]} is {word}"
            )
        return path_trajectory(
            self.chain,
            self.q,
            velocity_limits=velocity_limits,
            acceleration_limits=acceleration_limits,
        )

    def explain(self, most: int = 5) -> list[str]:
        """A line for each target that was not followed: what is wrong there.

        Args:
            most: lines; what is left is counted in one more.
        """
        lines = []
        bad = np.flatnonzero(self.status != PathStatus.FOLLOWED).tolist()
        for k in bad[:most]:
            status = PathStatus(int(self.status[k]))
            why = "not finite, or no pose"
            if status == PathStatus.NOT_REACHED:
                why = f"{1e3 * self.error[k]:.1f} mm from it; the joints stay"
            elif status == PathStatus.RECONFIGURED:
                turn = self.q[k] - self.q[k - 1]
                joint = int(np.abs(turn).argmax())
                unit = "m" if self.chain.kinds[joint] == "prismatic" else "rad"
                why = (
                    "reached, but the joints have to change posture before it: "
                    f"{self.chain.joint_names[joint]} by {turn[joint]:.3g} {unit}"
                )
            lines.append(f"target {k}: {status.name}, {why}")
        if len(bad) > most:
            lines.append(f"and {len(bad) - most} more")
        return lines

    def save_csv(self, path: str | Path) -> None:
        """Write `target, joint names…, status, error_m`, a line a target.

        Raises:
            OSError: the file cannot be written; what was there stays.
        """
        lines = [",".join(["target", *self.chain.joint_names, "status", "error_m"])]
        for k, (q, status, error) in enumerate(zip(self.q, self.status, self.error)):
            numbers = [f"{x:.17g}" for x in q]
            lines.append(",".join([str(k), *numbers, PathStatus(int(status)).name, f"{error:.6g}"]))
        write_whole(path, "\n".join(lines) + "\n")

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
            trajectory = path.trajectory()
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
    if task not in ("position", "pose"):
        raise ValueError(f"task must be 'position', or with poses 'pose', got {task!r}")
    if task == "pose" and array.ndim == 2:
        raise ValueError("task 'pose' needs poses, but the targets are positions (N,3)")
    if task == "position" and array.ndim == 3:
        array = array[:, :3, 3]
    check_counts(0, seed=seed)
    guard = None
    if collision_checker is not None:
        guard = Clearance(
            collision_checker, clearance, period=0.02, joints=chain.scoped_joint_names
        )
        if guard.num_joints != chain.num_joints:
            raise ValueError(
                f"collision_checker has a robot of {guard.num_joints} joints, the arm {chain.num_joints}"
            )
    solver = PathSolver(
        chain, LENGTH * chain.reach, check_positive_finite("tolerance", tolerance, "m"), guard
    )
    follower = Follower(solver, array, check_positive_finite("max_ratio", max_ratio, "-"), seed)
    start = None if initial_position is None else _checked_start(chain, initial_position)
    q, status, error = follower.run(start)
    return JointPath(chain, q, status, error, array, max_ratio)


def _checked_start(chain: SerialChain, start: ArrayLike) -> Array:
    q = np.array(start, dtype=float)
    n = chain.num_joints
    if q.shape != (n,) or not np.isfinite(q).all():
        raise ValueError(
            f"initial_position must be {n} finite numbers [rad or m], got {q.tolist()}"
        )
    if (q < chain.lower).any() or (q > chain.upper).any():
        joint = int(np.flatnonzero((q < chain.lower) | (q > chain.upper))[0])
        raise ValueError(
            f"initial_position of {chain.joint_names[joint]} must be in "
            f"[{chain.lower[joint]:g}, {chain.upper[joint]:g}], got {q[joint]:g}"
        )
    return q
