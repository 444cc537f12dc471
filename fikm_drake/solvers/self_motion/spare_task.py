"""The equations of a task that leaves one degree of freedom to spare."""

import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, JointIndex

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.add_dh_arm import MakeChainPlant, MakeDhArmPlant
from fikm_drake.kinematics.angles import middle_of_limits
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.native.kernel import MOST_JOINTS, kernel
from fikm_drake.kinematics.native.native_curve import CurveOptions, NativeCurve
from fikm_drake.kinematics.plant_frames import check_plant, frame_by_name
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.solvers.batch.batch_targets import checked_targets

ORIGIN = np.zeros((3, 1))  # of this shape it is passed on without a copy
SAMPLES = 8
"""Random postures whose Jacobians tell what a task fixes."""
RANK = 1e-9
"""Singular values under this, relative to the largest, are zero."""
MET = 1e-9
"""Error of a row that no joint moves [lever]: more is out of reach."""
TURN = 0.3
"""A turn of 1 rad counts as this much [lever]."""


class SpareTask:
    """A task of an arm, or of a MultibodyPlant, that leaves one degree of freedom to spare.

    Its equations are the rows of the task that the arm can move at all, so a planar arm may have
    the task `pose`: its three rows count. Joints that do not move the tool (a gripper's) stay where
    they are; the others are the *moving* joints, k of them, and there are k − 1 equations. Their unit of
    length is the *lever*, the longest that some random postures show, so that arms of all sizes are alike.

    Args:
        arm_or_plant: the arm; a chain, such as one of the joints of a plant that holds more; or a
            finalized plant with nothing but the arm.
        task: the task, or its name with the usual characteristic length.
        frame: name of the tool's frame in the plant.

    Raises:
        ValueError: the task leaves none or more than one degree of freedom; bad plant, frame, task.
    """

    def __init__(
        self,
        arm_or_plant: DhArm | SerialChain | MultibodyPlant,
        task: str | Task,
        frame: str = "tool",
    ) -> None:
        self.task = task if isinstance(task, Task) else Task(task)
        self._connect(arm_or_plant, frame)
        plant = self._plant
        self.default_position: Array = np.array(plant.GetPositions(self._context))
        """(n,) the plant's default positions [rad or m]."""
        lower = np.array(plant.GetPositionLowerLimits())
        upper = np.array(plant.GetPositionUpperLimits())
        revolute = _revolute(plant)
        self._set_rows(lower, upper)
        self.num_joints = len(lower)
        """n, all joints of the plant."""
        self.lower, self.upper = lower[self.moving], upper[self.moving]
        """(k,) limits of the moving joints [rad or m], infinite where there is none."""
        self.revolute = revolute[self.moving]
        """(k,): which moving joints turn."""
        self.middle = middle_of_limits(self.lower, self.upper)
        """(k,) middle of the limits [rad or m]."""
        self.search_range = _search_range(self.lower, self.upper)
        """(k,) and (k,): the limits, no further than half a turn from their middle [rad or m]."""
        self._chain = _chain(plant, self._frame_name, self.moving) if kernel() else None

    def _connect(self, source: DhArm | SerialChain | MultibodyPlant, frame: str) -> None:
        """Take a plant of the arm, and a context of it to compute in."""
        if isinstance(source, DhArm):
            plant: MultibodyPlant = MakeDhArmPlant(source)
        elif isinstance(source, SerialChain):
            plant, frame = MakeChainPlant(source), "tool"
        else:
            plant = source
        check_plant(plant)
        self._source, self._frame_name, self._plant = source, frame, plant
        self._frame = frame_by_name(plant, frame)
        self._world = plant.world_frame()
        self._context = plant.CreateDefaultContext()

    def __reduce__(self) -> tuple:
        """Pickled as its arguments, with the arm's chain in place of a plant of Drake's."""
        source = self._source
        if isinstance(source, MultibodyPlant):
            source = SerialChain.from_plant(source, self._frame_name)
            indices = source.position_indices
            if indices is None or not np.array_equal(indices, np.arange(self.num_joints)):
                raise TypeError(
                    "an arm of a plant with other joints cannot be pickled: take the arm's "
                    "SerialChain.from_plant in place of the plant"
                )
        return SpareTask, (source, self.task, self._frame_name)

    def _set_rows(self, lower: Array, upper: Array) -> None:
        """Find the joints that move the tool, and the combinations of rows that they move."""
        rows = self.task.rows
        low, high = _search_range(lower, upper)
        draws = np.random.default_rng(0).uniform(low, high, (SAMPLES, len(lower)))
        self.moving: NDArray[np.intp] = np.arange(len(lower))
        """(k,) indices of the joints that move the tool."""
        whole = np.array([self._jacobian(draw) for draw in draws])
        levers = np.linalg.norm(whole[:, 3:], axis=1)[np.abs(whole[:, :3]).max(axis=1) > 0.5]
        lever = float(levers.max(initial=0.0)) or 1.0  # only joints that slide: [m]
        select = np.diag([TURN] * 3 + [1.0 / lever] * 3)[rows]
        J = select @ whole
        largest = np.abs(J).max()
        self.moving = np.flatnonzero(np.abs(J).max(axis=(0, 1)) > RANK * largest)
        left, singular, _ = np.linalg.svd(np.concatenate(list(J), axis=1))
        rank = int(np.count_nonzero(singular > RANK * singular[0]))
        spare = len(self.moving) - rank
        if spare != 1:
            raise ValueError(
                f"task {self.task.name!r} fixes {rank} of the {len(self.moving)} degrees of freedom "
                f"of the joints that move the tool and leaves {spare}; it must leave 1"
            )
        self._rows = select if rank == len(rows) else left[:, :rank].T @ select
        self._fixed = left[:, rank:].T @ select

    def full(self, q: Array, start: Array) -> Array:
        """Positions of all joints (…,n) from those of the moving ones (…,k), others as in `start`."""
        every = np.broadcast_to(start, (*q.shape[:-1], self.num_joints)).copy()
        every[..., self.moving] = q
        return every

    def pose(self, q: Array) -> RigidTransform:
        """Pose of the tool at `q` (n,), in the world frame."""
        self._plant.SetPositions(self._context, q)
        return self._frame.CalcPoseInWorld(self._context)

    def target(self, target: ArrayLike | RigidTransform) -> RigidTransform:
        """A target as a pose; what the task does not count is arbitrary.

        Raises:
            ValueError: it is not what the task needs, or not finite.
        """
        if isinstance(target, RigidTransform):
            target = target.GetAsMatrix4()
        matrix = np.asarray(target, dtype=float)
        coordinates = self.task.coordinates
        if matrix.shape == (4, 4):
            if not checked_targets(matrix[None], "pose")[1][0]:
                raise ValueError(f"target must be finite and a pose, got {target!r}")
            rotation = RotationMatrix.ProjectToRotationMatrix(matrix[:3, :3])
            return RigidTransform(rotation, matrix[:3, 3])
        if self.task.turns or matrix.shape != (len(coordinates),):
            wanted = "a pose (4, 4)" if self.task.turns else f"{len(coordinates)} coordinates [m]"
            raise ValueError(
                f"target of task {self.task.name!r} must be {wanted} or joint positions "
                f"({self.num_joints},), got shape {matrix.shape}"
            )
        if not np.isfinite(matrix).all():
            raise ValueError(f"target must be finite, got {target!r}")
        position = np.zeros(3)
        position[coordinates] = matrix
        return RigidTransform(position)

    def error_and_jacobian(self, target: RigidTransform, q: Array) -> tuple[Array, Array]:
        """Error (k−1,) [lever] and Jacobian (k−1,k) at all joints' positions (n,)."""
        J = self._jacobian(q)
        return self._rows @ self._error(target), self._rows @ J

    def is_met(self, target: RigidTransform, q: Array) -> bool:
        """Whether `q` (n,), with no error in the rows that move, has none in the others either."""
        if not len(self._fixed):
            return True
        self._plant.SetPositions(self._context, q)
        return bool(np.abs(self._fixed @ self._error(target)).max() < MET)

    def native_curve(
        self, target: RigidTransform, start: Array, options: CurveOptions
    ) -> NativeCurve | None:
        """The equations for a target and the joints that do not move (n,), where there is a kernel."""
        loaded, chain = kernel(), self._chain
        if loaded is None or chain is None:
            return None
        positions = chain.from_full(np.arange(self.num_joints)).tolist()
        moving = np.array([positions.index(joint) for joint in self.moving.tolist()])
        X = target.GetAsMatrix4()
        return NativeCurve(
            loaded, chain.packed(), chain.from_full(start), moving, self._rows, X, options
        )

    def _error(self, target: RigidTransform) -> Array:
        X = self._frame.CalcPoseInWorld(self._context)
        error = np.zeros(6)
        error[3:] = target.translation() - X.translation()
        if self.task.turns:
            turn = target.rotation().multiply(X.rotation().inverse()).ToAngleAxis()
            error[:3] = turn.angle() * turn.axis()
        return error

    def _jacobian(self, q: Array) -> Array:
        self._plant.SetPositions(self._context, q)
        J = self._plant.CalcJacobianSpatialVelocity(
            self._context,
            JacobianWrtVariable.kV,
            self._frame,
            ORIGIN,
            self._world,
            self._world,
        )
        return J[:, self.moving]


def _chain(plant: MultibodyPlant, frame: str, moving: NDArray[np.intp]) -> SerialChain | None:
    """The joints that move a frame as a chain; None if it is not made of all those that do."""
    try:
        with warnings.catch_warnings():  # a limit of speed is none of this
            warnings.simplefilter("ignore")
            chain = SerialChain.from_plant(plant, frame)
    except ValueError:
        return None
    joints = chain.from_full(np.arange(plant.num_positions()))
    return chain if np.isin(moving, joints).all() and len(joints) <= MOST_JOINTS else None


def _search_range(lower: Array, upper: Array) -> tuple[Array, Array]:
    middle = middle_of_limits(lower, upper)
    return np.maximum(lower, middle - np.pi), np.minimum(upper, middle + np.pi)


def _revolute(plant: MultibodyPlant) -> Bools:
    """(n,): which positions are angles of revolute joints."""
    turns = np.zeros(plant.num_positions(), dtype=bool)
    for index in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(int(index)))
        if joint.num_positions() == 1:
            turns[joint.position_start()] = joint.type_name() == "revolute"
    return turns
