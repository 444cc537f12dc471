"""The one model of an arm: fixed transforms, joints, limits, a tool."""

# No `from __future__ import annotations`: dataclasses keep real types.
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.check_chain import check_chain
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.kinematics.frames import Frames, FramesOfPostures
from fikm_drake.kinematics.native.native_kinematics import NativeKinematics, native_kinematics
from fikm_drake.kinematics.one_posture import OnePosture
from fikm_drake.kinematics.transforms import joint_motion

if TYPE_CHECKING:
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import Frame, ModelInstanceIndex
    from pydrake.systems.framework import Context


@dataclass(frozen=True, eq=False)
class SerialChain:
    """Joints of one degree of freedom, one after the other, from a base frame to a tool frame.

    Joint i turns about, or slides along, the z axis of its own frame, which `before[i]` places in the
    frame that joint i − 1 moves, the first in the base frame. Everything that asks for an arm takes a
    chain, or what has one:

        chain = fd.load_arm("panda").chain
        chain = fd.SerialChain.from_plant(plant, "left::tool")      # every joint on the way there
        chain = fd.SerialChain.from_plant(plant, "tool", joints=["shoulder", "elbow"])
        X, J = chain.forward_kinematics(q), chain.jacobian(q)        # (…,4,4) and (…,6,n)

    Attributes:
        name: for messages.
        joint_names: n names, each once.
        kinds: n times `revolute` or `prismatic`.
        before: (n,4,4), fixed transforms [m]; `before[0]` begins at the base frame.
        tool: (4,4), of the tool frame in the frame that the last joint moves.
        lower, upper: (n,) limits [rad or m], infinite where there is none.
        velocity_limits: (n,) [rad/s or m/s], inf where there is none.
        acceleration_limits: (n,) [rad/s² or m/s²], inf where there is none.
        default_position: (n,) [rad or m], inside the limits.
        position_indices, velocity_indices: (n,) where the joints stand in a plant's q and v; None
            where there is no plant.
        scoped_joint_names: n names in a plant, `instance::joint`; None where there is no plant.

    The arrays cannot be written to.

    Raises:
        ValueError: naming the joint or the array, what it is, and what it must be.
    """

    name: str
    joint_names: tuple[str, ...]
    kinds: tuple[str, ...]
    before: Array
    tool: Array
    lower: Array
    upper: Array
    velocity_limits: Array
    acceleration_limits: Array
    default_position: Array
    position_indices: NDArray[np.intp] | None = None
    velocity_indices: NDArray[np.intp] | None = None
    scoped_joint_names: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        n = len(self.kinds)
        shapes: dict[str, tuple[int, ...]] = {"before": (n, 4, 4), "tool": (4, 4)}
        vectors = ("lower", "upper", "velocity_limits", "acceleration_limits", "default_position")
        for name, shape in (shapes | dict.fromkeys(vectors, (n,))).items():
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != shape:
                raise ValueError(f"chain {self.name!r}: {name} must be {shape}, is {array.shape}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        for name in ("position_indices", "velocity_indices"):
            if getattr(self, name) is not None:
                indices = np.array(getattr(self, name), dtype=np.intp)
                indices.flags.writeable = False
                object.__setattr__(self, name, indices)
        check_chain(self)

    @classmethod
    def from_dh(cls, arm: "DhTable | HasTable") -> "SerialChain":
        """The chain of a Denavit-Hartenberg table, in its base frame.

        A table in the standard convention is read as the modified one it equals: the factors
        Tx(a_i) Rx(α_i) that end one row begin the next, the last of them the tool. A row with equal
        limits is no joint: it stays where they say.

        Args:
            arm: the table, or the arm that has it.

        Raises:
            ValueError: naming the bad number and the valid ones.
        """
        from fikm_drake.kinematics.chain_of_table import chain_of_table

        return chain_of_table(arm if isinstance(arm, DhTable) else arm.table)

    @classmethod
    def from_plant(
        cls,
        plant: "MultibodyPlant",
        frame: "str | Frame",
        *,
        joints: "Sequence[str] | ModelInstanceIndex | None" = None,
        base: "str | Frame | None" = None,
        context: "Context | None" = None,
    ) -> "SerialChain":
        """The joints of a plant that move a frame.

        Args:
            plant: a finalized plant.
            frame: the tool's frame, or its name; `instance::name` where several have such a frame.
            joints: which of the joints on the way move: names (`instance::name` where several joints
                have one), or a model instance. None: all revolute and prismatic ones that are neither
                locked nor fixed by equal limits, from where the frame's way parts from the base's.
                Whatever else is on the way, floating bases and ball joints too, is held.
            base: the frame in which the chain stands; None: the world.
            context: of the plant; where held joints are, and which are locked. None: the default.

        Returns:
            The chain, its joints in the order from the base to the frame.

        Raises:
            ValueError: the plant is not finalized; no or more than one such frame or joint; a named
                joint is not on the way, is locked, or is neither revolute nor prismatic; no joint is
                left. The message lists the joints on the way.
        """
        from fikm_drake.kinematics.chain_of_plant import chain_of_plant

        return chain_of_plant(plant, frame, joints=joints, base=base, context=context)

    @property
    def chain(self) -> "SerialChain":
        """The chain itself: what asks for an arm's chain takes a chain too."""
        return self

    @property
    def num_joints(self) -> int:
        """The number of joints, n."""
        return len(self.kinds)

    @property
    def axes(self) -> Array:
        """(n,3): the axis of each joint in its own frame, always z."""
        return np.tile([0.0, 0.0, 1.0], (self.num_joints, 1))

    @cached_property
    def revolute(self) -> Bools:
        """(n,): which joints turn; the others slide."""
        return np.array([kind == "revolute" for kind in self.kinds])

    @cached_property
    def reach(self) -> float:
        """How far the tool can be from the first joint's axis, at most; solvers normalise by it [m].

        The distances from axis to axis to tool, with the travel of prismatic joints that have limits;
        it does not depend on where along an axis a frame stands. A chain without any extent: 1.
        """
        reach, point = 0.0, self.tool[:3, 3]
        for i in reversed(range(self.num_joints)):
            if self.revolute[i]:
                # From the axis's point next to the one before: the rest of the way is across it.
                reach += float(np.hypot(*point[:2]))
                point = np.array([0.0, 0.0, point[2]])
            elif np.isfinite(self.upper[i] - self.lower[i]):
                reach += float(self.upper[i] - self.lower[i])
            if i:
                point = self.before[i][:3, :3] @ point + self.before[i][:3, 3]
        return reach if reach > 0.0 else 1.0

    @cached_property
    def _frames(self) -> FramesOfPostures:
        return FramesOfPostures(self.before, self.tool, self.revolute)

    @cached_property
    def one(self) -> OnePosture:
        """Kinematics of one posture at a time, in numpy."""
        return OnePosture(self.before, self.tool, self.revolute)

    @cached_property
    def _native(self) -> NativeKinematics | None:
        return native_kinematics(self.packed(), self.num_joints)

    def packed(self) -> Array:
        """The chain as the native kernel takes it; see `native/lanes.h`."""
        return self._frames.packed()

    def frames(self, q: Array) -> Frames:
        """Tool frames and joint axes of N postures (n,N), for what computes on many at once."""
        return self._frames(q)

    def forward_kinematics(self, q: ArrayLike) -> Array:
        """Poses of the tool frame in the base frame.

        Args:
            q: joint positions (…,n) [rad or m].

        Returns:
            (…,4,4), translation in m.

        Raises:
            ValueError: the last axis of `q` is not n long.
        """
        q = self.checked(q)
        if self._native:
            return self._native.poses(np.ascontiguousarray(q))
        if q.ndim == 1:
            return self.one.pose(q)
        frames = self._frames(q.reshape(-1, self.num_joints).T)
        X = np.zeros((frames.position.shape[1], 4, 4))
        X[:, :3, :3] = frames.rotation.transpose(2, 1, 0)
        X[:, :3, 3] = frames.position.T
        X[:, 3, 3] = 1.0
        return X.reshape(*q.shape[:-1], 4, 4)

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian of the tool point in the base frame.

        Args:
            q: joint positions (…,n) [rad or m].

        Returns:
            (…,6,n), rows [ω; v]: [rad/s and m/s for each rad/s or m/s of the joint].

        Raises:
            ValueError: the last axis of `q` is not n long.
        """
        q = self.checked(q)
        if self._native:
            return self._native.jacobians(np.ascontiguousarray(q))
        if q.ndim == 1:
            return self.one.jacobian(q)
        J = self._frames(q.reshape(-1, self.num_joints).T).jacobian()
        return np.ascontiguousarray(J.transpose(2, 0, 1)).reshape(*q.shape[:-1], *J.shape[:2])

    def link_poses(self, q: ArrayLike) -> Array:
        """Poses (…,n,4,4) in the base frame of the frames that the joints move, at `q` (…,n)."""
        q, X = self.checked(q), np.eye(4)
        poses = np.empty((*q.shape, 4, 4))
        for i, turns in enumerate(self.revolute):
            X = X @ self.before[i] @ joint_motion(turns, q[..., i])
            poses[..., i, :, :] = X
        return poses

    def from_full(self, q_plant: ArrayLike) -> Array:
        """The chain's positions (…,n) out of a plant's (…,num_positions)."""
        return np.asarray(q_plant, dtype=float)[..., self._positions()]

    def to_full(self, q: ArrayLike, q_plant: ArrayLike) -> Array:
        """A plant's positions (…,num_positions) with the chain's (…,n) put in; others stay."""
        q = self.checked(q)
        q_plant = np.asarray(q_plant, dtype=float)
        full = np.array(np.broadcast_to(q_plant, (*q.shape[:-1], q_plant.shape[-1])))
        full[..., self._positions()] = q
        return full

    def checked(self, q: ArrayLike) -> Array:
        """The positions as an array (…,n).

        Raises:
            ValueError: the last axis is not n long.
        """
        q, n = np.asarray(q, dtype=float), self.num_joints
        if q.ndim == 0 or q.shape[-1] != n:
            raise ValueError(f"arm {self.name!r}: q must have shape (…, {n}), got {q.shape}")
        return q

    def __repr__(self) -> str:
        return f"<SerialChain {self.name!r}: {self.num_joints} joints>"

    def _positions(self) -> NDArray[np.intp]:
        if self.position_indices is None:
            raise ValueError(
                f"chain {self.name!r} is of no plant: SerialChain.from_plant makes such"
            )
        return self.position_indices


class HasTable(Protocol):
    """What has a Denavit-Hartenberg table."""

    @property
    def table(self) -> DhTable:
        """The table."""


class HasChain(Protocol):
    """What has a chain, such as `DhArm`."""

    @property
    def chain(self) -> SerialChain:
        """The chain."""


def as_chain(arm: SerialChain | HasChain) -> SerialChain:
    """The chain itself, or that of an arm that has one.

    Raises:
        ValueError: it is no chain and has none.
    """
    chain = arm if isinstance(arm, SerialChain) else getattr(arm, "chain", None)
    if not isinstance(chain, SerialChain):
        raise ValueError(
            f"arm must be a SerialChain (SerialChain.from_plant makes one of a plant) or a DhArm, "
            f"got {type(arm).__name__}"
        )
    return chain
