"""Where to begin, from fuzzy rules on the target: tables 1 and 2 of the paper."""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array, Bools
from fikm_drake.fuzzy.mamdani import MamdaniSystem, load_mamdani
from fikm_drake.solvers.labvolt.geometry import labvolt
from fikm_drake.solvers.labvolt.plane_targets import plane_targets

FIRST_GUESS = float(np.deg2rad(-90.0))
"""First guess of θ_3: the paper's, where no fuzzy rules give a better one [rad]."""
THETA_3, POSTURE = "labvolt_theta3", "labvolt_posture"
"""Names of the two systems in `models/fuzzy/`."""


class FuzzyStarts:
    """The paper's two Mamdani systems: a first θ_3 for algorithm 1, and a start for the SQP.

    Rules are the paper's. Its figures 2 to 4 give no numbers: peaks of the outputs are calibrated
    by what the solvers make of them (`fikm-drake calibrate labvolt`).

    Args:
        theta_3: x and y [m] to θ_3 [rad]; None: ours.
        posture: distance [m] and bearing [rad] of the target to θ_1, θ_2, θ_3 [rad]; None: ours.
        fill_holes: table 1 has no rule for some targets. True: θ_3 is the bearing of the target
            there; False: −90°, as without rules.

    Raises:
        ValueError: a system that has not these inputs and outputs.
    """

    def __init__(
        self,
        *,
        theta_3: MamdaniSystem | None = None,
        posture: MamdaniSystem | None = None,
        fill_holes: bool = True,
    ) -> None:
        self._theta_3 = theta_3 or load_mamdani(THETA_3)
        self._posture = posture or load_mamdani(POSTURE)
        self._fill_holes = fill_holes
        _check(self._theta_3, "theta_3", ["x", "y"], ["theta_3"])
        angles = ["theta_1", "theta_2", "theta_3"]
        _check(self._posture, "posture", ["distance", "bearing"], angles)

    def theta_3(self, target: Array) -> tuple[Array, Bools]:
        """First guess of θ_3, absolute.

        Args:
            target: points in the arm's plane (2,N) [m].

        Returns:
            θ_3 (N,) [rad]; whether a rule fired (N,).
        """
        values, fired = self._theta_3(target.T)
        other = np.arctan2(target[1], target[0]) if self._fill_holes else FIRST_GUESS
        return np.where(fired[:, 0], values[:, 0], other), fired[:, 0]

    def posture(self, target: Array) -> Array:
        """Start of the SQP.

        Args:
            target: points in the arm's plane (2,N) [m].

        Returns:
            Relative angles (3,N), inside the limits [rad].
        """
        bearing = np.arctan2(target[1], target[0])
        # A target behind and below the arm is reached over the top.
        bearing = np.where(bearing < -0.5 * np.pi, bearing + 2.0 * np.pi, bearing)
        values, _ = self._posture(np.column_stack([np.hypot(*target), bearing]))
        relative = np.diff(values.T, axis=0, prepend=0.0)
        return labvolt().clip(relative)


@cache
def default_starts() -> FuzzyStarts:
    """With our memberships, holes filled."""
    return FuzzyStarts()


def _check(system: MamdaniSystem, name: str, inputs: list[str], outputs: list[str]) -> None:
    config = system.config
    found = [variable.name for variable in config.inputs], [v.name for v in config.outputs]
    if found != (inputs, outputs):
        raise ValueError(f"{name} must have inputs {inputs} and outputs {outputs}, got {found}")


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
