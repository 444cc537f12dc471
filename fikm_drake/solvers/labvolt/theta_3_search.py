"""Algorithm 1 of the paper: θ_3 is guessed, the other two angles follow; if they cannot be, the next θ_3."""

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.solvers.labvolt.geometry import Geometry
from fikm_drake.solvers.labvolt.two_links import EDGE, two_links, wrap

FIRST_GUESS = float(np.deg2rad(-90.0))
"""The paper's, where no fuzzy rules give a better one [rad]."""
STEP = float(np.deg2rad(1.0))
"""Between guesses [rad]; the paper gives none, M. Elsharif's MATLAB library takes this."""
MOST_TRIES = 361
"""The first guess and up to 180° either way."""


def theta_3_search(
    geometry: Geometry, target: Array, guess: Array
) -> tuple[Array, NDArray[np.int_]]:
    """Guess θ_3, then 1° more, 1° less, 2° more … until the posture is inside the limits.

    Args:
        geometry: of the arm.
        target: points in the arm's plane (2,N) [m].
        guess: first θ_3 (N,), absolute [rad].

    Returns:
        Relative angles (3,N) [rad], NaN where no guess is good; tries (N,).
    """
    q = np.full((3, target.shape[1]), np.nan)
    tries = np.full(target.shape[1], MOST_TRIES)
    left = np.arange(target.shape[1])
    for k in range(MOST_TRIES):
        steps = (k + 1) // 2 * (1 if k % 2 else -1)
        found, good = _postures(geometry, target[:, left], guess[left] + steps * STEP)
        done = left[good]
        q[:, done], tries[done] = found[:, good], k + 1
        left = left[~good]
        if not left.size:
            break
    return q, tries


def _postures(geometry: Geometry, target: Array, theta_3: Array) -> tuple[Array, Bools]:
    """Relative angles (3,N) with the elbow up, else down, and whether they are inside the limits."""
    first, second, third = geometry.lengths
    wrist = target - third * np.array([np.cos(theta_3), np.sin(theta_3)])
    q = np.empty((3, target.shape[1]))
    good = np.zeros(target.shape[1], dtype=bool)
    for side in (-1.0, 1.0):
        theta_1, elbow = two_links(first, second, wrist, side)
        posture = wrap(np.array([theta_1, elbow, theta_3 - theta_1 - elbow]))
        better = geometry.contains(posture, EDGE) & ~good
        q[:, better] = posture[:, better]
        good |= better
    return q, good
