"""Points that cover the workspace of an arm inside its joint limits."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.batch.posture_pool import start_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table

COARSE = 60
"""Grid points from end to end of the reach, to measure the workspace."""
NEAR = 0.02
"""Postures this near to a limit are near it, as a share of the joint's range."""
HALVINGS = 40
"""Halvings of a grid step, to find the edge of the workspace."""


def workspace_points(arm: DhArm, count: int, *, edge: bool = False) -> Array:
    """A square grid over the workspace of a planar 3R arm, inside its joint limits.

    Args:
        arm: a planar arm with three revolute joints about z.
        count: about how many points.
        edge: whether to add the points where grid lines leave the workspace. There the bounds change
            fastest, and a grid alone leaves up to a step uncovered.

    Returns:
        (N,2) [m], N about `count`.

    Raises:
        ValueError: the arm is of another kind, or the workspace is too small for the count.
    """
    if not count > 0:
        raise ValueError(f"count must be positive, got {count!r}")
    reach = float(Planar3R(arm).lengths.sum())
    coarse = 2.0 * reach / COARSE
    found, _ = _grid(arm, coarse)
    step = coarse * np.sqrt(len(found) / count)
    for _ in range(2):  # the second time with the edge's points known
        points, crossings = _grid(arm, step)
        if edge:
            points = np.concatenate([points, _edge(arm, crossings)])
        if not len(points):
            raise ValueError(f"arm {arm.name!r} reaches no point of a grid of {step:.3g} m")
        step *= np.sqrt(len(points) / count)
    return points


def random_workspace_points(arm: DhArm, count: int, seed: int) -> Array:
    """Random points (count,2) [m], uniform over the workspace of a planar 3R arm inside its limits.

    Raises:
        ValueError: the arm is of another kind.
    """
    geometry, rng = Planar3R(arm), np.random.default_rng(seed)
    reach, found = float(geometry.lengths.sum()), np.empty((0, 2))
    while len(found) < count:
        points = geometry.base + rng.uniform(-reach, reach, (count, 2))
        found = np.concatenate([found, points[feasible_interval_table(arm, points).feasible]])
    return found[:count]


def random_tool_poses(arm: DhArm, count: int, seed: int, *, near_limits: float = 0.5) -> Array:
    """Poses (count,4,4) of the tool at random postures within the limits.

    Args:
        arm: any arm; joints without a limit are drawn as in `PosturePool`.
        count: how many, at least 1.
        seed: of the random numbers.
        near_limits: share of the postures whose joints are drawn, every other one, near a limit.

    Raises:
        ValueError: the count is not positive.
    """
    if not count > 0:
        raise ValueError(f"count must be positive, got {count!r}")
    rng, shape = np.random.default_rng(seed), (count, arm.num_joints)
    lower, upper = start_range(arm.chain)
    share, ends = rng.random(shape), rng.integers(0, 2, shape)
    moved = (rng.random(shape) < 0.5) & (rng.random((count, 1)) < near_limits)
    share = np.where(moved, np.abs(ends - NEAR * share), share)
    return arm.forward_kinematics(lower + (upper - lower) * share)


def _grid(arm: DhArm, step: float) -> tuple[Array, Array]:
    """Feasible points (N,2) of a grid, and neighbours (M,2,2), of which only the first is feasible."""
    geometry = Planar3R(arm)
    half = int(np.ceil(geometry.lengths.sum() / step)) + 1
    ticks = step * np.arange(-half, half + 1)
    grid = np.stack(np.meshgrid(ticks, ticks, indexing="ij"), axis=-1) + geometry.base
    inside = feasible_interval_table(arm, grid.reshape(-1, 2)).feasible.reshape(grid.shape[:2])
    pairs = []
    for points, flags in ((grid, inside), (grid.swapaxes(0, 1), inside.T)):
        for a, b in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            leaving = flags[a] & ~flags[b]
            pairs.append(np.stack([points[a][leaving], points[b][leaving]], axis=1))
    return grid[inside], np.concatenate(pairs)


def _edge(arm: DhArm, crossings: Array) -> Array:
    """The last feasible points (M,2) between feasible points and infeasible ones (M,2,2)."""
    inside, outside = crossings[:, 0], crossings[:, 1]
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        feasible = feasible_interval_table(arm, middle).feasible[:, None]
        inside, outside = np.where(feasible, middle, inside), np.where(feasible, outside, middle)
    return inside
