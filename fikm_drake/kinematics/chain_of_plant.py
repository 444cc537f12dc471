"""The chain of joints between two frames of a MultibodyPlant."""

import warnings
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, ModelInstanceIndex
from pydrake.systems.framework import Context

from fikm_drake.arrays import Array
from fikm_drake.kinematics.checker_joints import scoped_joint_name
from fikm_drake.kinematics.plant_frames import as_frame, frame_by_name
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.transforms import TURN_OVER


@dataclass(frozen=True, eq=False)
class _Passage:
    """A joint on the way, and whether the way leads from its parent to its child."""

    joint: Joint
    forward: bool
    outward: bool
    """True from the last body that is also on the base's way to the world."""

    @property
    def name(self) -> str:
        return self.joint.name()


def chain_of_plant(
    plant: MultibodyPlant,
    frame: str | Frame,
    *,
    joints: Sequence[str] | ModelInstanceIndex | None = None,
    base: str | Frame | None = None,
    context: Context | None = None,
) -> SerialChain:
    """See `SerialChain.from_plant`."""
    if not plant.is_finalized():
        raise ValueError("the plant must be finalized: call plant.Finalize() first")
    if frame is None:  # of a tool; a base may be left to the world
        frame_by_name(plant, frame)
    tool, start = as_frame(plant, frame), as_frame(plant, base)
    context = plant.CreateDefaultContext() if context is None else context.Clone()
    way = _way(plant, start, tool)
    chosen = _chosen(plant, way, joints, context, tool)
    plant.SetPositions(context, held_positions(plant, context))
    X = _inverse(start.GetFixedPoseInBodyFrame().GetAsMatrix4())
    before: list[Array] = []
    for passage in way:
        joint = passage.joint
        X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame().GetAsMatrix4()
        X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame().GetAsMatrix4()
        near, far = (X_PF, X_CM) if passage.forward else (X_CM, X_PF)
        if passage not in chosen:
            X_FM = joint.frame_on_child().CalcPose(context, joint.frame_on_parent())
            held = (X_FM if passage.forward else X_FM.inverse()).GetAsMatrix4()
            X = X @ near @ held @ _inverse(far)
            continue
        aligned = _z_to(_axis(joint))
        if not passage.forward:
            aligned = aligned @ TURN_OVER
        before.append(X @ near @ aligned)
        X = _inverse(aligned) @ _inverse(far)
    moving = [passage.joint for passage in chosen]
    lower = np.array([joint.position_lower_limits()[0] for joint in moving])
    upper = np.array([joint.position_upper_limits()[0] for joint in moving])
    positions = np.array([joint.position_start() for joint in moving], dtype=np.intp)
    return SerialChain(
        name=tool.scoped_name().get_full(),
        joint_names=_names(moving),
        kinds=tuple(joint.type_name() for joint in moving),
        before=np.array(before),
        tool=X @ tool.GetFixedPoseInBodyFrame().GetAsMatrix4(),
        lower=lower,
        upper=upper,
        velocity_limits=_bound(moving, "velocity"),
        acceleration_limits=_bound(moving, "acceleration"),
        default_position=np.clip(plant.GetPositions(context)[positions], lower, upper),
        position_indices=positions,
        velocity_indices=np.array([joint.velocity_start() for joint in moving], dtype=np.intp),
        scoped_joint_names=tuple(scoped_joint_name(joint, plant) for joint in moving),
    )


def held_positions(plant: MultibodyPlant, context: Context) -> Array:
    """A plant's positions in a Context, joints with equal limits where those say."""
    q = np.array(plant.GetPositions(context))
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if _is_fixed(joint):
            q[joint.position_start()] = joint.position_lower_limits()[0]
    return q


def _way(plant: MultibodyPlant, start: Frame, tool: Frame) -> list[_Passage]:
    """The joints from one frame's body to the other's, in order."""
    neighbours: dict[int, list[tuple[int, Joint, bool]]] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        parent, child = int(joint.parent_body().index()), int(joint.child_body().index())
        neighbours.setdefault(parent, []).append((child, joint, True))
        neighbours.setdefault(child, []).append((parent, joint, False))
    world = int(plant.world_body().index())
    found: dict[int, tuple[int, Joint, bool] | None] = {world: None}
    queue = deque([world])
    while queue:
        body = queue.popleft()
        for other, joint, forward in neighbours.get(body, []):
            if other not in found:
                found[other] = (body, joint, forward)
                queue.append(other)

    def from_world(body: int) -> list[tuple[Joint, bool]]:
        steps = []
        while (step := found[body]) is not None:
            body = step[0]
            steps.append(step[1:])
        return steps[::-1]

    there, here = from_world(int(tool.body().index())), from_world(int(start.body().index()))
    common = 0
    for a, b in zip(there, here):
        if a[0].index() != b[0].index():
            break
        common += 1
    back = [_Passage(joint, not forward, False) for joint, forward in reversed(here[common:])]
    return [*back, *(_Passage(joint, forward, True) for joint, forward in there[common:])]


def _chosen(
    plant: MultibodyPlant,
    way: list[_Passage],
    joints: Sequence[str] | ModelInstanceIndex | None,
    context: Context,
    tool: Frame,
) -> list[_Passage]:
    """Those that move."""
    able = [passage for passage in way if passage.joint.type_name() in ("revolute", "prismatic")]
    free = [p for p in able if not (p.joint.is_locked(context) or _is_fixed(p.joint))]
    if joints is None:
        chosen = [passage for passage in free if passage.outward]
    elif isinstance(joints, ModelInstanceIndex):
        chosen = [passage for passage in free if passage.joint.model_instance() == joints]
    else:
        named = {int(_joint(plant, name, way).index()): name for name in joints}
        chosen = [passage for passage in free if int(passage.joint.index()) in named]
        found = {int(passage.joint.index()) for passage in chosen}
        if missing := [name for index, name in named.items() if index not in found]:
            raise ValueError(
                f"joints must be revolute or prismatic, not locked, not fixed by equal limits, and on "
                f"the way to frame {tool.name()!r}; {missing} is not, there are "
                f"{[p.name for p in free]}"
            )
    if not chosen:
        raise ValueError(
            f"no joint moves frame {tool.name()!r}: on the way to it are "
            f"{[f'{p.name} ({p.joint.type_name()})' for p in way]}; revolute and prismatic ones that "
            "are neither locked nor fixed by equal limits can move it"
        )
    return chosen


def _joint(plant: MultibodyPlant, name: str, way: list[_Passage]) -> Joint:
    """The only joint of that name, `instance::name` where several have it; one on the way first."""
    instance, _, short = name.rpartition("::")
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    same = [
        joint
        for joint in joints
        if joint.name() == short
        and instance in ("", plant.GetModelInstanceName(joint.model_instance()))
    ]
    on_way = {int(passage.joint.index()) for passage in way}
    same = [joint for joint in same if int(joint.index()) in on_way] or same
    if len(same) != 1:
        raise ValueError(
            f"joints: {name!r} must name exactly one joint, names {len(same)}; on the way to the frame "
            f"are {[passage.name for passage in way]}"
        )
    return same[0]


def _names(joints: list[Joint]) -> tuple[str, ...]:
    """The joints' names; with their model instances where two have one name."""
    names = [joint.name() for joint in joints]
    if len(set(names)) < len(names):
        names = [joint.scoped_name().get_full() for joint in joints]
    return tuple(names)


def _axis(joint: Joint) -> Array:
    turns = joint.type_name() == "revolute"
    return np.asarray(joint.revolute_axis() if turns else joint.translation_axis())


def _bound(joints: list[Joint], of: str) -> Array:
    """The smaller of both limits of the speeds or accelerations (n,)."""
    upper = [getattr(joint, f"{of}_upper_limits")()[0] for joint in joints]
    lower = [getattr(joint, f"{of}_lower_limits")()[0] for joint in joints]
    bound = np.minimum(upper, -np.array(lower))
    if zeros := [joint.name() for joint, value in zip(joints, bound) if value == 0.0]:
        warnings.warn(
            f"{of} limit 0 of {zeros}, as exporters of CAD programs write it, is taken as no limit: set "
            f"it in the model, or by Joint.set_{of}_limits before the plant is finalized; lock a joint, "
            "or leave it out of joints=, if it must not move",
            stacklevel=5,
        )
    return np.where(bound == 0.0, np.inf, bound)


def _is_fixed(joint: Joint) -> bool:
    """True if a joint of one degree of freedom has equal limits."""
    one = joint.num_positions() == 1
    return bool(one and joint.position_lower_limits()[0] == joint.position_upper_limits()[0])


def _inverse(X: Array) -> Array:
    inverse = np.eye(4)
    inverse[:3, :3] = X[:3, :3].T
    inverse[:3, 3] = -X[:3, :3].T @ X[:3, 3]
    return inverse


def _z_to(axis: Array) -> Array:
    """A rotation (4,4) whose z is `axis`; of zeros and ones for an axis along x, y or z."""
    x = np.zeros(3)
    x[[1, 2, 0][int(np.argmax(np.abs(axis)))]] = 1.0
    if abs(axis[2]) == 1.0:
        x = np.array([1.0, 0.0, 0.0])
    x -= (x @ axis) * axis
    x /= np.linalg.norm(x)
    X = np.eye(4)
    X[:3, :3] = np.column_stack([x, np.cross(axis, x), axis])
    return X
