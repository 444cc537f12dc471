"""The way out of a dead point: a step aside where the error gives no direction."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SEEN = 1e-3
"""A joint step is at a dead point if it is shorter than this fraction of the error [rad/m], and a
direction of the joints moves the tool if its singular value is above this fraction of the largest."""
LEAST_ERROR = 1e-4
"""An error shorter than this is no reason to step aside [m]."""


def is_dead_point(squared_step: float, squared_error: float) -> bool:
    """True if a law's joint step hardly answers an error that is there; of both, |·|²."""
    return squared_step < SEEN**2 * squared_error and squared_error > LEAST_ERROR**2


def leave_dead_point(
    jacobian: Callable[[Array], Array], q: Array, error: Array, largest: float
) -> Array:
    """The joint step that leaves a dead point, where Jᵀ error = 0 and no law sees a way.

    Such as a stretched arm whose target lies straight inward: every direction that moves the tool
    is wrong, but one that does not yet move it brings it nearer in the second order. With N the
    joint directions that J does not see, and M = Nᵀ ∂(Jᵀ error)/∂q N, the error falls by
    ½ xᵀ M x along N x; the best is M's eigenvector of the largest eigenvalue. If none is positive,
    as for a target that is out of reach beyond the stretched arm, the tool is as near as it gets
    and stays.

    Args:
        jacobian: q to the task Jacobian (m,n).
        q: joint positions (n,) [rad or m].
        error: task error (m,) [m].
        largest: the largest joint motion of the step [rad or m].

    Returns:
        (n,) [rad or m]; its largest element is positive, so that it is the same each time. Zeros if
        there is no way out.
    """
    J = jacobian(q)
    _, values, directions = np.linalg.svd(J)
    rank = int((values > SEEN * values[0]).sum()) if values[0] > 0.0 else 0
    N = directions[rank:].T
    if not N.size:
        return np.zeros_like(q)
    h = 1e-4
    change = [(jacobian(q + h * v) - jacobian(q - h * v)).T @ error / (2 * h) for v in N.T]
    M = N.T @ np.stack(change, axis=1)
    gains, ways = np.linalg.eigh((M + M.T) / 2)
    if gains[-1] <= SEEN * np.linalg.norm(error) * values[0]:
        return np.zeros_like(q)
    way = N @ ways[:, -1]
    return largest * way / way[np.abs(way).argmax()]
