"""An arm as a line, for pictures and pages."""

from collections.abc import Callable

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import HasChain, SerialChain, as_chain

VIEWS = {
    "xy": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "xz": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "yz": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "aslant": ((-0.707, 0.707, 0.0), (-0.354, -0.354, 0.866)),
}
"""Directions across and up of each view, in the base frame; `aslant` is from before and above."""


def arm_line(arm: SerialChain | HasChain, q: Array) -> Array:
    """Corners of the line from the base over the joints to the tool, in the base frame.

    Args:
        arm: a chain, or what has one.
        q: joint positions (…,n) [rad or m].

    Returns:
        (…,n + 2,3) [m].
    """
    chain = as_chain(arm)
    joints = chain.link_poses(q)[..., :3, 3]
    tool = chain.forward_kinematics(q)[..., None, :3, 3]
    return np.concatenate([np.zeros_like(tool), joints, tool], axis=-2)


def arm_drawing(
    arm: SerialChain | HasChain,
    joints: Callable[[Array, Array], Array] | None = None,
    *,
    view: str = "aslant",
) -> Callable[[Array, Array], Array]:
    """What `write_rules_page` draws beside its sliders: an arm.

    Args:
        arm: a chain, or what has one.
        joints: inputs (N,d) and outputs (N,k) of the fuzzy system to joint positions (N,n) [rad or m],
            NaN where there are none; None: the outputs are the joint positions.
        view: `xy`, `xz`, `yz` (of the base frame) or `aslant`.

    Returns:
        Inputs and outputs to the corners of the arm in that view (N,n + 2,2) [m].

    Raises:
        ValueError: there is no such view.
    """
    if view not in VIEWS:
        raise ValueError(f"view must be one of {tuple(VIEWS)}, got {view!r}")
    directions = np.array(VIEWS[view]).T

    def draw(points: Array, values: Array) -> Array:
        q = np.asarray(values if joints is None else joints(points, values), dtype=float)
        return np.where(
            np.isnan(q).any(axis=-1)[:, None, None],
            np.nan,
            arm_line(arm, np.nan_to_num(q)) @ directions,
        )

    return draw
