"""What the ANFIS of learned bounds take, for points and for poses in the plane."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.angles import middle_of_limits, wrap
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import ROUNDING, Planar3R

INPUTS = ("xy", "polar")
JOINTS = {"xy": 3, "pose": 4}
"""Joints of the planar arms whose bounds can be learned, by the task."""
NAMES = {"xy": ("x", "y"), "polar": ("r", "phi")}
TURNED = {"xy": "psi", "polar": "psi_minus_phi"}
"""The third input of poses."""


class BoundsInputs:
    """Inputs of bounds: `xy`, x and y [m], or `polar`, distance from joint 1 [m] and angle φ [rad].

    For poses a third follows: the tool's angle ψ [rad], for `polar` less φ. Angles are from the base's x
    axis, cut opposite to where they are in the middle of the joints' limits.

    Args:
        arm: a planar arm of revolute joints about z, three for the task `xy`, four for `pose`.
        task: `xy` or `pose`.
        inputs: `xy` or `polar`.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(self, arm: DhArm, task: str, inputs: str) -> None:
        if inputs not in INPUTS:
            raise ValueError(f"inputs must be one of {INPUTS}, got {inputs!r}")
        if task not in JOINTS:
            raise ValueError(f"task of learned bounds must be one of {(*JOINTS,)}, got {task!r}")
        if task == "xy":
            Planar3R(arm)
        else:
            _check_planar_4r(arm)
        self._task, self._inputs = task, inputs
        origins = [arm.joint_origin(i) for i in range(arm.num_joints)]
        middle = middle_of_limits(arm.lower, arm.upper)
        self._base = origins[0][:2, 3]
        self._ahead = float(middle[0] + _angle(origins[0]))
        turns = sum(float(_angle(X)) for X in (*origins, arm.tool_pose))
        self._tool_ahead = float(middle.sum() + turns)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        names = NAMES[self._inputs]
        return names if self._task == "xy" else (*names, TURNED[self._inputs])

    def __call__(self, points: Array) -> Array:
        """The inputs (N,2) for points (N,2) [m], or (N,3) for poses (N,4,4); NaN for NaN."""
        poses = self._task == "pose"
        columns = self._position(points[:, :2, 3] if poses else points)
        if poses:
            relative = self._inputs == "polar"
            angle = _angle(points) - (columns[1] if relative else 0.0)
            cut = self._tool_ahead - (self._ahead if relative else 0.0)
            columns.append(cut + wrap(angle - cut))
        return np.column_stack(columns)

    def _position(self, points: Array) -> list[Array]:
        if self._inputs == "xy":
            return list(points.T)
        x, y = (points - self._base).T
        return [np.hypot(x, y), self._ahead + wrap(np.arctan2(y, x) - self._ahead)]


def _check_planar_4r(arm: DhArm) -> None:
    origins = [arm.joint_origin(i) for i in range(arm.num_joints)]
    planar = all(X[2, 2] > 1.0 - ROUNDING for X in (*origins, arm.tool_pose))
    revolute = all(arm.chain.revolute)
    if arm.num_joints != 4 or not (planar and revolute):
        raise ValueError(
            f"arm {arm.name!r} must be planar with four revolute joints along the base's z for bounds "
            f"of poses to be learned"
        )


def _angle(X: Array) -> Array:
    """Angle about z of poses (…,4,4) [rad]."""
    return np.asarray(np.arctan2(X[..., 1, 0], X[..., 0, 0]))
