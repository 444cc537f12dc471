"""Bounds of a Jacobian's elements over all joint positions (Xu & Nechyba 1993, equations 8-11).

The paper bounds every product of sines and cosines by one, which needs the Jacobian in symbols.
Here the same bound comes from the geometry, frame by frame: of a vector in a joint's frame only
its length across the axis and its length along it matter, since the joint can turn it to any
direction about the axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf, isinf, sqrt

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_table import DhJoint


@dataclass(frozen=True)
class _Extent:
    """Bounds of a set of vectors: of the length across z, of the length along z, of the length."""

    across: float
    along: float
    length: float

    def rotated_x(self, cosine: float, sine: float) -> "_Extent":
        """Bounds after a rotation about x by a twist whose |cos| and |sin| are given."""
        along = _times(sine, self.across) + _times(cosine, self.along)
        across = _max_across(self.across, self.along, cosine, sine)
        return _Extent(min(across, self.length), min(along, self.length), self.length)

    def through_row(self, origin: Array, d: float) -> "_Extent":
        """Bounds one frame down: first |d| along z, then the twist and length of `origin`."""
        a = abs(origin[0, 3])
        raised = _Extent(self.across, self.along + d, self.length + d)
        turned = raised.rotated_x(*_twist(origin))
        length = self.length + hypot(a, d)  # a along x and d across it
        return _Extent(min(turned.across + a, length), min(turned.along, length), length)


def _times(factor: float, bound: float) -> float:
    """The product, zero for a zero factor even where the bound is infinite."""
    return factor * bound if factor else 0.0


def _max_across(R: float, Z: float, cosine: float, sine: float) -> float:
    """Largest length across the new z: max over t of R²(1 − t²) + (R t cos + Z sin)², |t| ≤ 1."""
    if isinf(R) or isinf(_times(sine, Z)):
        return inf
    Z = Z if sine else 0.0
    t = Z * cosine / (R * sine) if R * sine > Z * cosine else 1.0
    return sqrt(R * R * (1 - t * t) + (R * t * cosine + Z * sine) ** 2)


def jacobian_range(joints: Sequence[DhJoint], origins: Sequence[Array], tool: Array) -> Array:
    """Bounds (6,n) of |J_ij|, rows [ω; v], over all joint positions.

    Args:
        joints: the rows of the table.
        origins: (4,4) each; the part Rx(α) Tx(a) that begins each modified DH row.
        tool: (4,4) pose of the tool in the last link's frame.
    """
    n = len(joints)
    bound = np.zeros((6, n))
    x, y, z = np.abs(tool[:3, 3])
    # From the link's origin to the tool, in the link's frame.
    to_tool = _Extent(hypot(x, y), z, hypot(x, y, z))
    for j in reversed(range(n)):
        if joints[j].is_revolute:
            bound[:3, j] = _in_base(_Extent(0.0, 1.0, 1.0), origins[: j + 1])
            bound[3:, j] = _in_base(_Extent(to_tool.across, 0.0, to_tool.across), origins[: j + 1])
        else:
            bound[3:, j] = _in_base(_Extent(0.0, 1.0, 1.0), origins[: j + 1])
        # The joint adds its offset along z, then the row's twist and length lead one frame down.
        to_tool = to_tool.through_row(origins[j], _largest_offset(joints[j]))
    return bound


def _in_base(extent: _Extent, origins: Sequence[Array]) -> Array:
    """Bounds of the base frame's components of a vector given in the last frame of `origins`."""
    for origin in reversed(origins[1:]):
        extent = extent.rotated_x(*_twist(origin))
    cosine, sine = _twist(origins[0])
    across, along = extent.across, extent.along
    y = _times(cosine, across) + _times(sine, along)
    z = _times(sine, across) + _times(cosine, along)
    return np.minimum([across, y, z], extent.length)


def _twist(origin: Array) -> tuple[float, float]:
    """|cos| and |sin| of the twist, with the rounding of a right angle or none taken out."""
    cosine, sine = abs(origin[1, 1]), abs(origin[2, 1])
    return (1.0, 0.0) if sine < 1e-15 else (0.0, 1.0) if cosine < 1e-15 else (cosine, sine)


def _largest_offset(joint: DhJoint) -> float:
    if joint.is_revolute:
        return abs(joint.d)
    lower, upper = joint.limits
    return max(abs(joint.d + lower), abs(joint.d + upper))
