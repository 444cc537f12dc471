"""A chain with its reach as the unit of length, so that arms of all sizes are alike to a solver."""

from dataclasses import replace

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import SerialChain


def joint_units(chain: SerialChain) -> Array:
    """(n,): 1 for a joint that turns; the reach [m] for one that slides."""
    return np.where(chain.revolute, 1.0, chain.reach)


def unit_chain(chain: SerialChain) -> SerialChain:
    """The chain with all lengths divided by its reach; its joints are at q / `joint_units`."""
    unit = joint_units(chain)
    before, tool = chain.before.copy(), chain.tool.copy()
    before[:, :3, 3] /= chain.reach
    tool[:3, 3] /= chain.reach
    lower, upper = chain.lower / unit, chain.upper / unit
    default = np.clip(chain.default_position / unit, lower, upper)
    return replace(
        chain, before=before, tool=tool, lower=lower, upper=upper, default_position=default
    )


def in_reaches(poses: Array, chain: SerialChain) -> Array:
    """Poses (…,4,4), their positions as fractions of a chain's reach."""
    scaled = np.array(poses)
    scaled[..., :3, 3] /= chain.reach
    return scaled
