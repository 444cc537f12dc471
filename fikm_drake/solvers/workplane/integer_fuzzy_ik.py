"""Fuzzy inverse kinematics in integers only (Tojo & Morishita 2010)."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fikm_drake.arrays import Array, Bools
from fikm_drake.checks import check_positive_finite
from fikm_drake.fuzzy.integer import IntegerRuleBase, write_c
from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import LARGEST, Conjunction
from fikm_drake.fuzzy.integer.write_c import Shape
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.workplane.workplane import load_workplane
from fikm_drake.solvers.workplane.workplane_data import WorkplaneData
from fikm_drake.solvers.workplane.workplane_inverse import TiltedPlaneInverse, WorkplaneInverse


class IntegerFuzzyIk:
    """Joint angles for a point (x, y) of a workplane, by fuzzy rules in integers only.

    Each rule "IF x is A AND y is B" has a singleton for each joint. A point in whole millimetres
    gives whole steps of `resolution`, by equation 5 with grades to 255: no floating point, no sine,
    no square root. `to_c` writes the same for a small processor.

        ik = fd.IntegerFuzzyIk(labels=(9, 9), conjunction="product")
        angles, outside = ik.solve(120, 80)  # [0.01°]

    The default is the paper's: three labels an input, `min`, decimals cut off. Its data of a person
    are not published; its arm is modelled by `tojo4dof`.

    Args:
        source: where the singletons come from: a `WorkplaneInverse` of any arm, or `WorkplaneData` that were
            measured. None: the arm `tojo4dof` at its workplane.
        labels: memberships of x and of y, 2 to 33 each, evenly spaced over the workplane.
        conjunction: AND of a rule: `min` as in the paper, or `product`, which interpolates better.
        rounding: `truncate` as in the paper, or `nearest`.
        resolution: one step of the angles [degrees].
        least_squares: False: the singletons are the joint positions at the peaks of the memberships;
            True: they are fitted to the joint positions everywhere.

    Raises:
        ValueError: an argument is not as described, the arm does not reach a point, or the data do not
            determine every singleton.
    """

    def __init__(
        self,
        source: WorkplaneInverse | WorkplaneData | None = None,
        *,
        labels: tuple[int, int] = (3, 3),
        conjunction: Conjunction = "min",
        rounding: Rounding = "truncate",
        resolution: float = 0.01,
        least_squares: bool = False,
    ) -> None:
        self._resolution = check_positive_finite("resolution", resolution, "°")
        if np.shape(labels) != (2,):
            raise ValueError(f"labels must be two numbers, of x and of y, got {labels!r}")
        first, second, singletons = (source or tojo_inverse()).singletons(
            labels, conjunction, least_squares=least_squares
        )
        steps = np.rint(np.rad2deg(singletons) / resolution)
        if np.abs(steps).max() > LARGEST:
            raise ValueError(f"resolution {resolution} [°] is too fine: angles exceed 32 bits")
        self._rules = IntegerRuleBase(
            first, second, steps.astype(np.int64), conjunction=conjunction, rounding=rounding
        )

    @property
    def rules(self) -> IntegerRuleBase:
        """The rules: inputs in mm, outputs in steps of `resolution`."""
        return self._rules

    @property
    def resolution(self) -> float:
        """One step of the angles [degrees]."""
        return self._resolution

    @property
    def num_joints(self) -> int:
        """The number of joints, n."""
        return self._rules.num_outputs

    def __repr__(self) -> str:
        rules = self._rules
        return (
            f"<{type(self).__name__} {len(rules.first)} x {len(rules.second)} labels, "
            f"{self.num_joints} joints, {rules.conjunction}, {rules.rounding}, "
            f"{self._resolution:g}°>"
        )

    def solve(self, x: int, y: int) -> tuple[list[int], bool]:
        """Joint angles at one point, in Python integers (a few microseconds).

        Args:
            x: to the right [mm].
            y: away from the arm [mm].

        Returns:
            The angles (n) in steps of `resolution`, and True if the point lies outside the rules'
            rectangle: the angles are then those of the nearest point inside.

        Raises:
            TypeError: x or y is not an integer.
        """
        return self._rules.infer(x, y)

    def solve_batch(self, points: ArrayLike) -> tuple[NDArray[np.int64], Bools]:
        """Joint angles at many points, the same integers as of `solve`.

        Args:
            points: integers x, y (…,2) [mm].

        Returns:
            The angles (…,n) in steps of `resolution`, and whether each point lies outside (…).

        Raises:
            ValueError: the points are not integers, or not (…,2).
        """
        points = np.asarray(points)
        if points.ndim < 1 or points.shape[-1] != 2:
            raise ValueError(f"points must be (…, 2), got {points.shape}")
        return self._rules.infer_batch(points[..., 0], points[..., 1])

    def to_radians(self, angles: ArrayLike) -> Array:
        """Angles in steps of `resolution` as joint positions [rad]."""
        return np.deg2rad(np.asarray(angles) * self._resolution)

    def to_c(self, path: str | Path, *, shape: Shape = "shared_cell") -> tuple[Path, Path]:
        """Write C99 that gives the same integers, see `fuzzy.integer.write_c`.

        Args:
            path: of the source, `…/NAME.c`; its header is put beside it.
            shape: `shared_cell`, or `rule_loop` as the paper's equations stand.

        Returns:
            Paths of the source and of the header.

        Raises:
            ValueError: the shape is unknown, or NAME is not a C identifier.
            OSError: a file cannot be written.
        """
        note = f"Inputs: x, y [mm]. Outputs: {self.num_joints} joint angles in steps of "
        note += f"{self._resolution:g} degrees."
        return write_c(self._rules, path, shape=shape, note=note)


def tojo_inverse() -> TiltedPlaneInverse:
    """The arm `tojo4dof` at its workplane."""
    return TiltedPlaneInverse(load_arm("tojo4dof"), load_workplane("tojo4dof"))
