"""Whether the numbers of a chain make sense: rigid transforms, limits in order, names."""

from typing import TYPE_CHECKING

import numpy as np

from fikm_drake.kinematics.dh_table import JOINT_TYPES

if TYPE_CHECKING:
    from fikm_drake.kinematics.serial_chain import SerialChain

RIGID = 1e-6
"""How far a transform may be from a rigid one, by its elements [-]."""


def check_chain(chain: "SerialChain") -> None:
    """Raise ValueError, naming the joint or the transform, unless the chain's numbers make sense."""
    where = f"chain {chain.name!r}"
    if not chain.kinds or len(chain.joint_names) != len(chain.kinds):
        raise ValueError(f"{where} must have joints, and a name for each: {chain.joint_names}")
    if len(set(chain.joint_names)) != len(chain.joint_names):
        raise ValueError(f"{where}: joint_names must differ, got {chain.joint_names}")
    for X in (*chain.before, chain.tool):
        R = X[:3, :3]
        rigid = np.abs(R @ R.T - np.eye(3)).max() < RIGID and np.linalg.det(R) > 0.0
        if not (np.isfinite(X).all() and rigid and np.array_equal(X[3], [0.0, 0.0, 0.0, 1.0])):
            raise ValueError(f"{where}: before and tool must be rigid transforms, got\n{X}")
    for i, (name, kind) in enumerate(zip(chain.joint_names, chain.kinds)):
        if kind not in JOINT_TYPES:
            raise ValueError(f"{where}, {name}: kind must be one of {JOINT_TYPES}, got {kind!r}")
        low, high, default = chain.lower[i], chain.upper[i], chain.default_position[i]
        if not low <= default <= high:
            raise ValueError(
                f"{where}, {name}: lower <= default position <= upper must hold, got {low}, "
                f"{default}, {high}"
            )
        for field in ("velocity_limits", "acceleration_limits"):
            if not getattr(chain, field)[i] >= 0.0:
                raise ValueError(
                    f"{where}, {name}: {field} must not be negative, got {getattr(chain, field)[i]}"
                )
