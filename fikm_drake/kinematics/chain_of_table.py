"""The chain of a Denavit-Hartenberg table."""

import numpy as np

from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.transforms import (
    TURN_OVER,
    joint_motion,
    rotation_x,
    rotation_z,
    translation,
)


def chain_of_table(table: DhTable) -> SerialChain:
    """See `SerialChain.from_dh`."""
    table.validate()
    table = table.in_si()
    rows = table.joints
    x_parts = [rotation_x(row.alpha) @ translation(x=row.a) for row in (*rows, table.tool)]
    z_parts = [rotation_z(row.theta) @ translation(z=row.d) for row in (*rows, table.tool)]
    if table.convention == "craig":
        *poses, tool = (x @ z for x, z in zip(x_parts, z_parts))
    else:
        starts = [np.eye(4), *x_parts[: len(rows) - 1]]
        poses = [x @ z for x, z in zip(starts, z_parts)]
        tool = x_parts[-2] @ z_parts[-1] @ x_parts[-1]
    X, before = np.eye(4), []
    for row, pose in zip(rows, poses):
        turned = TURN_OVER if row.flip else np.eye(4)
        X = X @ pose @ turned
        if row.is_fixed:
            X = X @ joint_motion(row.is_revolute, row.limits[0])
        else:
            before.append(X)
            X = np.eye(4)
        X = X @ turned
    moving = [(i, row) for i, row in enumerate(rows, start=1) if not row.is_fixed]
    limits = np.array([row.limits for _, row in moving])
    speeds = [np.inf if row.velocity is None else row.velocity for _, row in moving]
    return SerialChain(
        name=table.name,
        joint_names=tuple(f"joint{i}" for i, _ in moving),
        kinds=tuple(row.type for _, row in moving),
        before=np.array(before),
        tool=X @ tool,
        lower=limits[:, 0],
        upper=limits[:, 1],
        velocity_limits=np.array(speeds),
        acceleration_limits=np.full(len(moving), np.inf),
        default_position=np.clip(0.0, limits[:, 0], limits[:, 1]),
    )
