"""Fuzzy starts for solvers of others."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts, default_starts
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.targets import plane_targets


def initial_guess(targets: ArrayLike, *, fuzzy: FuzzyStarts | None = None) -> Array:
    """Joint positions near a solution, by fuzzy rules on the target: for Drake's `InverseKinematics`.

        ik = InverseKinematics(plant)  # of models/labvolt5250.urdf
        ik.AddPositionConstraint(tool, [0, 0, 0], world, target, target)
        result = SnoptSolver().Solve(ik.prog(), fd.labvolt.initial_guess(target))

    Args:
        targets: (3,) or (N,3), in the base frame [m]; (x, y) of the arm's plane too, with yaw 0.
        fuzzy: the rules; None: ours.

    Returns:
        (4,) or (N,4) joint positions of `models/labvolt5250.urdf`, inside the limits [rad]; the middle
        of the limits for targets that are not finite.

    Raises:
        ValueError: targets that are not numbers or have another shape.
    """
    geometry = labvolt()
    given = plane_targets(geometry, targets)
    relative = np.repeat(geometry.middle[:, None], len(given.given), axis=1)
    starts = fuzzy or default_starts()
    relative[:, given.valid] = starts.posture(given.plane[:, given.valid])
    guess = np.column_stack([given.yaw, relative.T])
    return guess[0] if np.ndim(targets) == 1 else guess
