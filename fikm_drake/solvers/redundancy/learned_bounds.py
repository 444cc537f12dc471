"""Bounds of the redundant joint, learned by two ANFIS."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common.yaml import yaml_dump_typed

from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.angles import wrap
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.resources import find_model, load_yaml, model_names
from fikm_drake.solvers.redundancy.bounds_data import BoundsData

Array = NDArray[np.float64]
INPUTS = ("xy", "polar")
FOLDER = "bounds"
"""Where in `models/` the bounds are that come with the library."""


class LearnedBounds:
    """Bounds of joint 1 of a planar 3R arm as functions of the point, learned.

    Args:
        arm: the arm that they are of.
        inputs: what `lower` and `upper` take: `xy`, or `polar`: distance from joint 1 [m] and angle [rad].
        lower: the lower bound [rad].
        upper: the upper bound [rad].

    Raises:
        ValueError: the arm is of another kind, or the inputs are.
    """

    def __init__(self, arm: DhArm, inputs: str, lower: Anfis, upper: Anfis) -> None:
        check_inputs(inputs)
        self._geometry = Planar3R(arm)
        for name, anfis in (("lower", lower), ("upper", upper)):
            if len(anfis.memberships) != 2:
                raise ValueError(f"{name} must have 2 inputs, got {len(anfis.memberships)}")
        self.arm, self.inputs, self.lower, self.upper = arm, inputs, lower, upper

    def predict(self, points: ArrayLike) -> tuple[Array, Array]:
        """Lower and upper bound of joint 1 (N,) [rad] for points (N,2) [m]; NaN for NaN.

        Raises:
            ValueError: the points have another shape.
        """
        X = bounds_inputs(self._geometry, points, self.inputs)
        return self.lower.predict(X), self.upper.predict(X)

    def save(self, path: str | Path) -> None:
        """Write a YAML file that `load` reads, with the arm's table.

        Raises:
            OSError: the file cannot be written.
        """
        data = BoundsData(self.arm.table, self.inputs, self.lower.to_data(), self.upper.to_data())
        yaml_dump_typed(data, filename=str(path))

    @classmethod
    def load(cls, name_or_path: str | Path) -> LearnedBounds:
        """Read bounds that come with the library, by their name, or your own, by the path of the file.

        Raises:
            FileNotFoundError: there is no such file; the message lists those that come with the library.
            ValueError: it is not such a file; the message says what is wrong.
        """
        path = find_model(name_or_path, folder=FOLDER, kind="learned bounds")
        data = load_yaml(BoundsData, path, kind="learned bounds")
        try:
            lower, upper = Anfis.from_data(data.lower), Anfis.from_data(data.upper)
            return cls(DhArm(data.arm), data.inputs, lower, upper)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    @classmethod
    def of(cls, arm: DhArm) -> LearnedBounds:
        """The bounds of an arm that come with the library.

        Raises:
            ValueError: there are none of this arm; the message says how to train them.
        """
        if arm.name in model_names(FOLDER):
            bounds = cls.load(arm.name)
            if bounds.arm.table == arm.table:
                return bounds
        raise ValueError(
            f"no learned bounds of arm {arm.name!r} come with the library: train some with "
            f"`train_bounds(arm)` or `fikm-drake train`, and give them as `bounds`"
        )


def bounds_inputs(geometry: Planar3R, points: ArrayLike, inputs: str) -> Array:
    """What the ANFIS of bounds take (N,2) for points (N,2) [m].

    Polar angles [rad] are from the base's x axis, cut opposite to the middle of joint 1.

    Raises:
        ValueError: the points have another shape.
    """
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {array.shape}")
    if inputs == "xy":
        return array
    x, y = (array - geometry.base).T
    ahead = geometry.middle[0] + geometry.offsets[0]
    return np.column_stack([np.hypot(x, y), ahead + wrap(np.arctan2(y, x) - ahead)])


def check_inputs(inputs: str) -> None:
    """Raise ValueError unless these are inputs that bounds may have."""
    if inputs not in INPUTS:
        raise ValueError(f"inputs must be one of {INPUTS}, got {inputs!r}")
