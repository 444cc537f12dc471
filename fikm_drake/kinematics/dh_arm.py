"""A serial arm given by its Denavit-Hartenberg table."""

import copy

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_table import DhTable, DhTransform
from fikm_drake.kinematics.jacobian_range import jacobian_range
from fikm_drake.kinematics.transforms import rotation_x, rotation_z, translation
from fikm_drake.kinematics.urdf import urdf


class DhArm:
    """A serial arm given by its Denavit-Hartenberg table: kinematics and URDF.

    Everything is vectorised over the leading axes of `q`. Frames: the base frame, link frames
    1 … n (the modified DH frames, each on its joint's axis) and the tool frame.

    A table in the standard convention is read as the modified table it equals: the factors
    Tx(a_i) Rx(α_i) that end one standard row begin the next modified one, the last of them the
    tool.

    Args:
        table: the arm's table; it is copied.

    Raises:
        ValueError: naming the bad number and the valid ones.
    """

    def __init__(self, table: DhTable) -> None:
        table.validate()
        self._table = copy.deepcopy(table)
        rows = self._table.joints
        if table.convention == "craig":
            self._origins = [_x_part(row) for row in rows]
            self._tool = _x_part(table.tool) @ _z_part(table.tool)
        else:
            ends = [_x_part(row) for row in rows]
            self._origins = [np.eye(4), *ends[:-1]]
            self._tool = ends[-1] @ _z_part(table.tool) @ _x_part(table.tool)

    @property
    def table(self) -> DhTable:
        """A copy of the arm's table."""
        return copy.deepcopy(self._table)

    @property
    def name(self) -> str:
        """The arm's name."""
        return self._table.name

    @property
    def num_joints(self) -> int:
        """The number of joints, n."""
        return len(self._table.joints)

    @property
    def lower(self) -> Array:
        """Lower joint limits (n,) [rad or m], −inf where there is none."""
        return np.array([joint.limits[0] for joint in self._table.joints])

    @property
    def upper(self) -> Array:
        """Upper joint limits (n,) [rad or m], inf where there is none."""
        return np.array([joint.limits[1] for joint in self._table.joints])

    @property
    def velocity(self) -> Array:
        """Joint speed limits (n,) [rad/s or m/s], inf where there is none."""
        limits = [joint.velocity for joint in self._table.joints]
        return np.array([np.inf if limit is None else limit for limit in limits])

    @property
    def default_position(self) -> Array:
        """The joint positions nearest to zero inside the limits (n,) [rad or m]."""
        return np.clip(np.zeros(self.num_joints), self.lower, self.upper)

    def joint_origin(self, i: int) -> Array:
        """Pose (4,4) in link i's frame of the frame whose z is the axis of joint i (from 0)."""
        row = self._table.joints[i]
        return self._origins[i] @ _z_part(row)

    @property
    def tool_pose(self) -> Array:
        """Pose (4,4) of the tool frame in the last link's frame."""
        return self._tool.copy()

    def link_poses(self, q: ArrayLike) -> Array:
        """Poses of the link frames in the base frame.

        Args:
            q: joint positions (…,n) [rad or m].

        Returns:
            (…,n,4,4).

        Raises:
            ValueError: the last axis of `q` is not n long.
        """
        q = self._checked(q)
        X = np.eye(4)
        poses = np.empty((*q.shape, 4, 4))
        for i, joint in enumerate(self._table.joints):
            motion = rotation_z(q[..., i]) if joint.is_revolute else translation(z=q[..., i])
            X = X @ self.joint_origin(i) @ motion
            poses[..., i, :, :] = X
        return poses

    def forward_kinematics(self, q: ArrayLike) -> Array:
        """Pose of the tool frame in the base frame.

        Args:
            q: joint positions (…,n) [rad or m].

        Returns:
            (…,4,4), translation in m.

        Raises:
            ValueError: the last axis of `q` is not n long.
        """
        return self.link_poses(q)[..., -1, :, :] @ self._tool

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian of the tool point in the base frame.

        Column j is [z_j; z_j × (p_tool − p_j)] for a revolute joint and [0; z_j] for a prismatic
        one, with the joint's own (modified DH) axis. Equations 6 and 7 of Xu & Nechyba 1993 as
        printed leave out the arm from the base to joint j: theirs is the velocity of another point.

        Args:
            q: joint positions (…,n) [rad or m].

        Returns:
            (…,6,n), rows [ω; v]: [rad/s and m/s for each rad/s or m/s of the joint].

        Raises:
            ValueError: the last axis of `q` is not n long.
        """
        poses = self.link_poses(q)
        tool = (poses[..., -1, :, :] @ self._tool)[..., None, :3, 3]
        axes, origins = poses[..., :3, 2], poses[..., :3, 3]
        revolute = np.array([joint.is_revolute for joint in self._table.joints])[:, None]
        angular = np.where(revolute, axes, 0.0)
        linear = np.where(revolute, np.cross(axes, tool - origins), axes)
        return np.swapaxes(np.concatenate([angular, linear], axis=-1), -1, -2)

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's elements over all joint positions (Xu & Nechyba, eqs. 8-11).

        Returns:
            (6,n), rows [ω; v]: |J_ij(q)| never exceeds element (i,j). Revolute joints are taken
            to turn freely; prismatic ones move within their limits, and their offsets make the
            bound infinite where they have none. Attained for planar arms.
        """
        return jacobian_range(self._table.joints, self._origins, self._tool)

    def to_urdf(self) -> str:
        """The arm as URDF: links `base`, `link1` …, `tool`, joints `joint1` …; see `urdf.py`."""
        joints = self._table.joints
        origins = [self.joint_origin(i) for i in range(self.num_joints)]
        return urdf(self.name, joints, origins, self._tool)

    def __repr__(self) -> str:
        return f"<DhArm {self.name!r}: {self.num_joints} joints>"

    def _checked(self, q: ArrayLike) -> Array:
        q = np.asarray(q, dtype=float)
        if q.ndim == 0 or q.shape[-1] != self.num_joints:
            raise ValueError(
                f"arm {self.name!r}: q must have shape (…, {self.num_joints}), got {q.shape}"
            )
        return q


def _x_part(row: DhTransform) -> Array:
    return rotation_x(row.alpha) @ translation(x=row.a)


def _z_part(row: DhTransform) -> Array:
    return rotation_z(row.theta) @ translation(z=row.d)
