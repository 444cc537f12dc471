"""A serial arm given by its Denavit-Hartenberg table."""

import copy

from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.kinematics.chain_limits import ChainLimits
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.kinematics.jacobian_range import jacobian_range
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.urdf import urdf


class DhArm(ChainLimits):
    """A serial arm given by its Denavit-Hartenberg table: kinematics and URDF.

    Everything is vectorised over the leading axes of `q`. Frames: the base frame, link frames
    1 … n (the modified DH frames, each on its joint's axis) and the tool frame.

    A table in the standard convention is read as the modified table it equals: the factors
    Tx(a_i) Rx(α_i) that end one standard row begin the next modified one, the last of them the
    tool.

    Args:
        table: the arm's table; it is copied.

    Attributes:
        chain: the arm's one model of its kinematics, in the base frame.

    Raises:
        ValueError: naming the bad number and the valid ones.
    """

    def __init__(self, table: DhTable) -> None:
        self.chain = SerialChain.from_dh(table)
        self._table = table.in_si()

    @property
    def table(self) -> DhTable:
        """A copy of the arm's table, in radians and metres."""
        return copy.deepcopy(self._table)

    @property
    def name(self) -> str:
        """The arm's name."""
        return self._table.name

    def joint_origin(self, i: int) -> Array:
        """Pose (4,4) in link i's frame of the frame whose z is the axis of joint i (from 0)."""
        return self.chain.before[i].copy()

    @property
    def tool_pose(self) -> Array:
        """Pose (4,4) of the tool frame in the last link's frame."""
        return self.chain.tool.copy()

    def link_poses(self, q: ArrayLike) -> Array:
        """Poses (…,n,4,4) of the link frames in the base frame at `q` (…,n); see `SerialChain`."""
        return self.chain.link_poses(q)

    def forward_kinematics(self, q: ArrayLike) -> Array:
        """Pose (…,4,4) of the tool frame in the base frame at `q` (…,n); see `SerialChain`."""
        return self.chain.forward_kinematics(q)

    def jacobian(self, q: ArrayLike) -> Array:
        """Jacobian (…,6,n) of the tool point, rows [ω; v], at `q` (…,n); see `SerialChain`."""
        return self.chain.jacobian(q)

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's elements over all joint positions (Xu & Nechyba, eqs. 8-11).

        Returns:
            (6,n), rows [ω; v]: |J_ij(q)| never exceeds element (i,j). Revolute joints are taken
            to turn freely; prismatic ones move within their limits, and their offsets make the
            bound infinite where they have none. Attained for planar arms.
        """
        return jacobian_range(self.chain)

    def to_urdf(self, *, capsules: bool = True) -> str:
        """The arm as URDF: links `base`, `link1` …, `tool`, joints `joint1` …; see `urdf.py`.

        Args:
            capsules: False leaves out what collides.
        """
        return urdf(self.chain, capsules=capsules)

    def __repr__(self) -> str:
        return f"<DhArm {self.name!r}: {self.num_joints} joints>"
