"""Targets that no posture of an arm can reach, by cheap proofs."""

import numpy as np

from fikm_drake.arrays import Array, Bools
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.solvers.batch.batch_targets import ORTHONORMAL


def out_of_reach(
    arm: DhArm, targets: Array, tolerance: tuple[float, float], *, limits: bool = True
) -> Bools:
    """Which targets are proven to be out of reach.

    Two proofs: the links, laid end to end from the first joint's axis, are too short, or too unequal
    to fold back far enough; a planar arm cannot leave its plane. A target that passes both may be
    out of reach all the same. Arms whose first joint is prismatic are given the benefit of its
    travel.

    Args:
        arm: the arm.
        targets: positions (N,3) [m] or poses (N,4,4), all valid.
        tolerance: position [m] and rotation [rad].
        limits: False ignores the limits of the joints; the travel of a prismatic joint is then
            without end.

    Returns:
        (N,).
    """
    pose = targets.ndim == 3
    p = targets[:, :3, 3] if pose else targets
    spans, slack = _spans(arm, limits), tolerance[0]
    planar = _leaves_plane(arm, targets, tolerance)
    if pose:
        # The tool's offset from the last joint is known: it is no link any more.
        tool_inverse = np.linalg.inv(arm.tool_pose)
        p = (targets @ tool_inverse)[:, :3, 3]
        turn = 2.0 * float(np.sin(min(tolerance[1], np.pi) / 2.0)) + 2.0 * ORTHONORMAL
        slack += turn * spans.pop()[1]
    distance = np.linalg.norm(p - arm.joint_origin(0)[:3, 3], axis=1)
    greatest = [longest for _, longest in spans]
    farthest = sum(greatest)
    others = [sum(greatest[:i] + greatest[i + 1 :]) for i in range(len(greatest))]
    nearest = max(shortest - rest for (shortest, _), rest in zip(spans, others))
    slack += 1e-9 * (1.0 + slack)
    return (distance > farthest + slack) | (distance < nearest - slack) | planar


def _spans(arm: DhArm, limits: bool) -> list[tuple[float, float]]:
    """Least and greatest distance [m] between successive points: joints' frames, then the tool."""
    joints = arm.table.joints
    spans = []
    for i, joint in enumerate(joints):
        fixed = arm.joint_origin(i)
        offset = np.zeros(3) if i == 0 else fixed[:3, 3]
        if joint.is_revolute:
            spans.append((float(np.linalg.norm(offset)),) * 2)
            continue
        travel = joint.limits if limits else (-np.inf, np.inf)
        # Along the joint's axis the offset and its travel add, across it they do not.
        along = float(offset @ fixed[:3, 2])
        across = float(np.linalg.norm(offset - along * fixed[:3, 2]))
        ends = [along + travel[0], along + travel[1]]
        least = 0.0 if ends[0] <= 0.0 <= ends[1] else min(abs(end) for end in ends)
        greatest = max(abs(end) for end in ends)
        spans.append((float(np.hypot(least, across)), float(np.hypot(greatest, across))))
    tool = float(np.linalg.norm(arm.tool_pose[:3, 3]))
    return [*spans, (tool, tool)]


def _leaves_plane(arm: DhArm, targets: Array, tolerance: tuple[float, float]) -> Bools:
    """Targets beside the plane of an arm whose joints all turn about parallel axes."""
    q = arm.default_position
    axes = arm.link_poses(q)[:, :3, 2]
    revolute = all(joint.is_revolute for joint in arm.table.joints)
    if not revolute or not np.allclose(axes @ axes[0], np.sign(axes @ axes[0]), rtol=0, atol=1e-12):
        return np.zeros(len(targets), dtype=bool)
    axis, X = axes[0], arm.forward_kinematics(q)
    pose = targets.ndim == 3
    p = targets[:, :3, 3] if pose else targets
    outside = np.abs((p - X[:3, 3]) @ axis) > tolerance[0] + 1e-9
    if pose:
        # The axis, seen from the tool, is the same in every posture.
        seen = targets[:, :3, :3] @ (X[:3, :3].T @ axis)
        tilt = np.arctan2(np.linalg.norm(np.cross(seen, axis), axis=1), seen @ axis)
        outside |= tilt > tolerance[1] + 1e-9
    return outside
