"""Targets that no posture of a chain can reach, by cheap proofs."""

import numpy as np

from fikm_drake.arrays import Bools
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.solvers.batch.batch_targets import ORTHONORMAL, BatchTargets


class Reach:
    """Two proofs that a target is out of reach.

    The links, laid end to end from the first joint's axis, are too short, or too unequal to fold back far
    enough; a planar arm cannot leave its plane. A target that passes both may be out of reach all the
    same. Chains whose first joint is prismatic are given the benefit of its travel.

    Args:
        chain: the chain.
        pose: whether targets are poses, else positions.
        tolerance: position [m] and rotation [rad].
        limits: False ignores the limits of the joints; the travel of a prismatic joint is then
            without end.
    """

    def __init__(
        self, chain: SerialChain, pose: bool, tolerance: tuple[float, float], limits: bool = True
    ) -> None:
        self._pose = pose
        spans, slack = _spans(chain, limits), tolerance[0]
        self._tool_point = np.zeros(3)
        if pose:
            # The tool's offset from the last joint is known: it is no link any more.
            self._tool_point = -chain.tool[:3, :3].T @ chain.tool[:3, 3]
            turn = 2.0 * float(np.sin(min(tolerance[1], np.pi) / 2.0)) + 2.0 * ORTHONORMAL
            slack += turn * spans.pop()[1]
        self._center = chain.before[0][:3, 3]
        greatest = [longest for _, longest in spans]
        farthest = sum(greatest)
        others = [sum(greatest[:i] + greatest[i + 1 :]) for i in range(len(greatest))]
        nearest = max(shortest - rest for (shortest, _), rest in zip(spans, others))
        slack += 1e-9 * (1.0 + slack)
        self._farthest, self._nearest = farthest + slack, nearest - slack
        # A planar chain: its plane, and its axis as the tool sees it in every posture.
        q = chain.default_position
        axes, X = chain.link_poses(q)[:, :3, 2], chain.forward_kinematics(q)
        products = axes @ axes[0]
        parallel = np.allclose(products, np.sign(products), rtol=0, atol=1e-12)
        self._planar = bool(chain.revolute.all() and parallel)
        self._axis, self._height = axes[0], float(axes[0] @ X[:3, 3])
        self._seen = X[:3, :3].T @ axes[0]
        self._slack = (tolerance[0] + 1e-9, tolerance[1] + 1e-9)

    def beyond(self, targets: BatchTargets) -> Bools:
        """Which of N targets are proven to be out of reach (N,)."""
        p, R = targets.position, targets.rotation
        seen = self._seen
        if R is not None:
            p = p + np.einsum("ikn,i->kn", R, self._tool_point)
        distance = np.sqrt(np.sum((p - self._center[:, None]) ** 2, axis=0))
        far = (distance > self._farthest) | (distance < self._nearest)
        if self._planar:
            far |= np.abs(self._axis @ targets.position - self._height) > self._slack[0]
            if R is not None:
                seen = np.einsum("ikn,i->nk", R, self._seen)
                away = np.linalg.norm(np.cross(seen, self._axis), axis=1)
                far |= np.arctan2(away, seen @ self._axis) > self._slack[1]
        return far

    def numbers(self) -> list[float]:
        """What the native kernel needs, in its order: REACH to SLACK of `native/kernel.c`."""
        return [
            *self._center,
            self._farthest,
            self._nearest,
            float(self._planar),
            *self._axis,
            self._height,
            *self._seen,
            *self._tool_point,
            *self._slack,
        ]


def _spans(chain: SerialChain, limits: bool) -> list[tuple[float, float]]:
    """Least and greatest distance between successive points: joints' frames, then the tool."""
    spans = []
    for i in range(chain.num_joints):
        offset = np.zeros(3) if i == 0 else chain.before[i][:3, 3]
        if chain.revolute[i]:
            spans.append((float(np.linalg.norm(offset)),) * 2)
            continue
        travel = (chain.lower[i], chain.upper[i]) if limits else (-np.inf, np.inf)
        # Along the joint's axis the offset and its travel add, across it they do not.
        along = float(offset @ chain.before[i][:3, 2])
        across = float(np.linalg.norm(offset - along * chain.before[i][:3, 2]))
        ends = [along + travel[0], along + travel[1]]
        least = 0.0 if ends[0] <= 0.0 <= ends[1] else min(abs(end) for end in ends)
        greatest = max(abs(end) for end in ends)
        spans.append((float(np.hypot(least, across)), float(np.hypot(greatest, across))))
    tool = float(np.linalg.norm(chain.tool[:3, 3]))
    return [*spans, (tool, tool)]
