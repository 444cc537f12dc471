"""Motion that a task leaves free, and what to do with it.

On the scaled Jacobian S = R^-½ J C^-½ of the fuzzy law (R, C the row and column sums of |J|) a step of
the law is C^-½ (something in the row space of S); what the law leaves free is C^-½ (I − S⁺ S) C^½. That
projector is used here: null-space motion and law then share one metric, in which a joint that moves the
tool little is cheap. J times it is zero, whatever the rank of J.
"""

from collections.abc import Callable

import numpy as np

from fikm_drake.arrays import Array, all_finite
from fikm_drake.control.clearance import Clearance

H = 1e-5
"""Step of finite differences [rad or m]."""
FLOOR = 0.05
"""Column sums are raised to this fraction of the largest, so that a joint that moves nothing may move [-]."""
RANK = 1e-10
"""Singular values below this fraction of the largest are zero [-]."""

Objective = Callable[[Array], Array]
"""Joint positions (n,) to the joint velocity (n,) that is wished for [rad/s or m/s]."""


def null_space_step(J: Array, motion: Array) -> Array:
    """The part of a joint motion that leaves the task alone, by the law's own scaled projector.

    Args:
        J: the task Jacobian (m,n).
        motion: joint motion that is wished for (n,), in any unit.

    Returns:
        (n,) in its unit, with J · result = 0 to rounding; zeros if the motion is none, or if
        one of both is not finite.

    Example:
        >>> import numpy as np
        >>> from fikm_drake.control.null_space import null_space_step
        >>> null_space_step(np.array([[1.0, 1.0]]), np.array([0.2, 0.0])).round(3).tolist()
        [0.1, -0.1]
    """
    if not motion.any() or not np.isfinite(J).all() or not all_finite(motion):
        return np.zeros(len(motion))
    scale = np.sqrt(column_weights(J))
    # Scaling of the rows does not change the row space.
    _, sizes, directions = np.linalg.svd(J / scale, full_matrices=False)
    basis = directions[sizes > RANK * sizes[0]]
    wished = motion * scale
    free = wished - basis.T.dot(basis.dot(wished))
    return (free - basis.T.dot(basis.dot(free))) / scale  # twice: to rounding


def column_weights(J: Array) -> Array:
    """C over its largest: how much each joint moves the task, from `FLOOR` to 1 (n,) [-].

    What goes uphill in the law's metric is a gradient divided by these: then its free part goes uphill too.
    """
    columns = np.abs(J).sum(axis=0)
    largest = float(columns.max())
    return np.maximum(columns / largest, FLOOR) if largest > 0.0 else np.ones(len(columns))


def toward_posture(posture: Array, rate: float) -> Objective:
    """Toward joint positions (n,) [rad or m] at a rate [1/s]."""
    return lambda q: rate * (posture - q)


def toward_middle(lower: Array, upper: Array, rate: float) -> Objective:
    """Toward the middle of the joint limits (n,), each the more the nearer it is to a limit.

    The descent of Σ ((q − middle) / range)⁴: a joint about its middle is left alone. Joints without two
    limits are.

    Args:
        lower: (n,) [rad or m], −inf for none.
        upper: (n,) [rad or m], inf for none.
        rate: at a limit [1/s].
    """
    both = np.isfinite(lower) & np.isfinite(upper)
    middle = np.where(both, 0.5 * (np.where(both, lower, 0.0) + np.where(both, upper, 0.0)), 0.0)
    half = np.where(both, 0.5 * (np.where(both, upper, 2.0) - np.where(both, lower, 0.0)), np.inf)
    return lambda q: -rate * (q - middle) * ((q - middle) / half) ** 2


def toward_manipulability(jacobian: Callable[[Array], Array], speed: float) -> Objective:
    """Uphill in √det(J Jᵀ), Yoshikawa's manipulability, which is zero at singular postures.

    Args:
        jacobian: joint positions (n,) to the task Jacobian (m,n).
        speed: of the fastest joint where the manipulability changes by its own size in a radian, less
            where it changes less [rad/s or m/s].
    """

    def wished(q: Array) -> Array:
        gradient = np.empty(len(q))
        for j in range(len(q)):
            step = np.zeros(len(q))
            step[j] = H
            gradient[j] = _log_size(jacobian(q + step)) - _log_size(jacobian(q - step))
        gradient /= 2.0 * H
        if not np.isfinite(gradient).all():
            return np.zeros(len(q))
        gradient /= column_weights(jacobian(q))
        return speed * gradient / max(1.0, float(np.abs(gradient).max()))

    return wished


def _log_size(J: Array) -> float:
    """Logarithm of √det(J Jᵀ)."""
    return float(0.5 * np.linalg.slogdet(J.dot(J.T) + 1e-12 * np.eye(len(J)))[1])


def away_from_obstacles(
    clearance: Clearance, jacobian: Callable[[Array], Array], speed: float
) -> Objective:
    """Away from what is near, the more the nearer: the descent of Σ ½ (1 − d / influence)².

    Args:
        clearance: tells what is near.
        jacobian: joint positions (n,) to the task Jacobian (m,n).
        speed: of the fastest joint where something is at the safe distance [rad/s or m/s].
    """
    zone = clearance.config.influence_distance

    def wished(q: Array) -> Array:
        near = clearance.near(q)
        if not len(near.distances):
            return np.zeros(len(q))
        weights = np.clip(1.0 - near.distances / zone, 0.0, 1.0)
        wish = weights.dot(near.rows) / column_weights(jacobian(q))
        size = float(np.abs(wish).max())
        return (speed * float(weights.max()) / size if size > 0.0 else 0.0) * wish

    return wished
