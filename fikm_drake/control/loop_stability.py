"""How fast the control loop converges, and when it is stable: section 2.7 with a frozen Jacobian.

The mapping is dθ = C⁻¹ Jᵀ R⁻¹ d, so the task error falls by A d a cycle, A = J C⁻¹ Jᵀ R⁻¹. By the
Schur test no eigenvalue λ of A exceeds 1, and none is negative. Along an eigenvector, with a gain K
and a filter of the error with smoothing s (equation 31: s = 2/3), the loop
e' = e − λ d, d = s d' + (1 − s) K e has the characteristic polynomial

    z² − (1 + s − (1 − s) λK) z + s,

which is stable for 0 < λK < 2 (1 + s) / (1 − s): 2 without the filter, 10 with it.
"""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.laws.law import Law


def largest_stable_gain(smoothing: float, *, delay: int = 0) -> float:
    """The bound of λK below which the loop is stable [-].

    Args:
        smoothing: weight of the last error [-], 0 ≤ smoothing < 1; 0: no filter.
        delay: of the joints' measurement [cycles]; 1 leaves a bound of 1, whatever the filter.
    """
    bound = 2.0 * (1.0 + smoothing) / (1.0 - smoothing)
    if delay == 0:
        return bound
    low = 0.0
    for _ in range(60):
        middle = 0.5 * (low + bound)
        stable = convergence_factor(middle, smoothing, delay=delay) < 1.0
        low, bound = (middle, bound) if stable else (low, middle)
    return low


def convergence_factor(loop_gain: ArrayLike, smoothing: float, *, delay: int = 0) -> Array:
    """The factor by which the error falls a cycle in the long run; stable below 1.

    Args:
        loop_gain: λK (…) [-].
        smoothing: weight of the last error [-], 0 ≤ smoothing < 1; 0: no filter.
        delay: of the joints' measurement [cycles].

    Returns:
        The largest absolute value of the roots (…) [-].
    """
    loop_gain = np.asarray(loop_gain, dtype=float)
    factors = np.empty(loop_gain.shape)
    for index, gain in np.ndenumerate(loop_gain):
        # z^delay (z − 1)(z − s) + (1 − s) λK z: the polynomial above, the feedback late.
        polynomial = np.zeros(delay + 3)
        polynomial[:3] = 1.0, -1.0 - smoothing, smoothing
        polynomial[-2] += (1.0 - smoothing) * gain
        factors[index] = np.abs(np.roots(polynomial)).max()
    return factors


def task_matrix(law: Law, J: ArrayLike) -> Array:
    """A (m,m): the task coordinates move by A d for a law's answer to d, the Jacobian frozen.

    Args:
        law: a law that is linear in the task error, such as `FuzzyMapping()`.
        J: Jacobian (m,n).
    """
    J = np.asarray(J, dtype=float)
    m = J.shape[0]
    return J @ law(np.broadcast_to(J, (m, *J.shape)), np.eye(m)).T


def loop_matrix(A: ArrayLike, gain: float, smoothing: float) -> Array:
    """The closed loop (2m,2m): error and filtered error of a cycle to those of the next.

    Args:
        A: of `task_matrix` (m,m).
        gain: K [-].
        smoothing: weight of the last error [-].
    """
    A = np.asarray(A, dtype=float)
    one = np.eye(len(A))
    new = (1.0 - smoothing) * gain
    return np.block([[one - new * A, -smoothing * A], [new * one, smoothing * one]])
