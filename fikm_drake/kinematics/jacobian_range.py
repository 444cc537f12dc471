"""Bounds of a Jacobian's elements over all joint positions (Xu & Nechyba 1993, equations 8-11).

The paper bounds every product of sines and cosines by one, which needs the Jacobian in symbols.
Here the same bound comes from the geometry, frame by frame: of a vector in a joint's frame only
its length across the axis and its length along it matter, since the joint can turn it to any
direction about the axis.
"""

from dataclasses import dataclass
from math import hypot, inf, isinf, sqrt

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import SerialChain


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

    def through(self, pose: Array, offset: tuple[float, float]) -> "_Extent":
        """Bounds one frame down, whose z can be turned to: the joint's travel, then its fixed pose.

        Args:
            pose: of the joint's frame in the one before it.
            offset: least and greatest position along the joint's own z, the pose's part included.
        """
        d = max(abs(offset[0]), abs(offset[1]))
        aside = pose[:3, 3] - (pose[:3, 3] @ pose[:3, 2]) * pose[:3, 2]
        across, along = float(np.hypot(*aside[:2])), abs(float(aside[2]))
        raised = _Extent(self.across, self.along + d, self.length + d)
        turned = raised.rotated_x(*_tilt(pose))
        length = self.length + hypot(across, along, d)  # aside is across d
        return _Extent(min(turned.across + across, length), turned.along + along, length)


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


def jacobian_range(chain: SerialChain) -> Array:
    """Bounds (6,n) of |J_ij|, rows [ω; v], over all joint positions of a chain.

    Revolute joints are taken to turn freely; prismatic ones move within their limits.
    """
    n, before = chain.num_joints, chain.before
    bound = np.zeros((6, n))
    x, y, z = np.abs(chain.tool[:3, 3])
    # From the link's origin to the tool, in the link's frame.
    to_tool = _Extent(hypot(x, y), z, hypot(x, y, z))
    for j in reversed(range(n)):
        if chain.revolute[j]:
            bound[:3, j] = _in_base(_Extent(0.0, 1.0, 1.0), before[: j + 1])
            bound[3:, j] = _in_base(_Extent(to_tool.across, 0.0, to_tool.across), before[: j + 1])
        else:
            bound[3:, j] = _in_base(_Extent(0.0, 1.0, 1.0), before[: j + 1])
        # The joint adds its offset along z, then its pose leads one frame down.
        d = float(before[j][:3, 3] @ before[j][:3, 2])
        travel = (0.0, 0.0) if chain.revolute[j] else (chain.lower[j], chain.upper[j])
        to_tool = to_tool.through(before[j], (d + travel[0], d + travel[1]))
    return bound


def _in_base(extent: _Extent, before: Array) -> Array:
    """Bounds of the base frame's components of a vector given in the last of the joints' frames."""
    for pose in before[:0:-1]:
        extent = extent.rotated_x(*_tilt(pose))
    tilts = [_clean(hypot(*row[:2]), abs(row[2])) for row in before[0][:3, :3]]
    parts = [_times(sine, extent.across) + _times(cosine, extent.along) for sine, cosine in tilts]
    return np.minimum(parts, extent.length)


def _tilt(pose: Array) -> tuple[float, float]:
    """|cos| and |sin| of the angle between the two frames' z."""
    return _clean(abs(pose[2, 2]), hypot(*pose[2, :2]))


def _clean(cosine: float, sine: float) -> tuple[float, float]:
    """Both with the rounding of a right angle or none taken out."""
    return (1.0, 0.0) if sine < 1e-15 else (0.0, 1.0) if cosine < 1e-15 else (cosine, sine)
