"""Closed-form inverse kinematics of an arm whose first joint tilts the plane of the other three."""

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finites
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.solvers.workplane.workplane import Workplane
from fikm_drake.solvers.workplane.workplane_inverse import WorkplaneInverse, check_reached

HEADING = (-1.01, -0.41)
"""Of the hand at the near and at the far edge [rad]: with these, Table 1's labels agree in order."""


class TiltedPlaneInverse(WorkplaneInverse):
    """Joint positions of an arm like `tojo4dof` at points of a workplane, in closed form.

    Three joints in a plane through the shoulder's y axis reach a point; the pitch tilts the plane so
    that it holds the point, and so depends on the distance from the shoulder only. The fourth joint
    is spent on the heading of the hand: its angle to the straight-ahead direction of the plane,
    positive to the left, which changes linearly from the near edge to the far one.

    Args:
        arm: of the geometry of `tojo4dof`, with any lengths of the links.
        workplane: the workplane, in the arm's base frame; it is copied.
        heading: of the hand at the near and at the far edge of the workplane [rad].

    Raises:
        ValueError: the arm has another geometry, the heading is not two finite angles, or see
            `Workplane.validate`.
    """

    def __init__(
        self, arm: DhArm, workplane: Workplane, *, heading: tuple[float, float] = HEADING
    ) -> None:
        super().__init__(arm, workplane, arm.default_position)
        self._lengths = _link_lengths(arm.table)
        self._heading = check_finites("heading", heading, 2, "rad")

    def __call__(self, points: ArrayLike) -> Array:
        """As of `WorkplaneInverse`."""
        points = np.asarray(points, dtype=float)
        forward, left, up = np.moveaxis(self._desk.to_world(points), -1, 0)
        near, far = self._heading
        heading = near + (far - near) * points[..., 1] / self._desk.size[1]
        upper, fore, hand = self._lengths
        ahead = np.hypot(forward, up) - hand * np.cos(heading)  # the wrist, in the plane
        left = left - hand * np.sin(heading)
        cosine = (ahead**2 + left**2 - upper**2 - fore**2) / (2 * upper * fore)
        check_reached(np.abs(cosine) <= 1.0, points)
        pitch = np.arctan2(forward, -up)
        elbow = np.arccos(cosine)
        roll = np.arctan2(left, ahead) + np.arctan2(fore * np.sin(elbow), upper + fore * cosine)
        return np.stack([pitch, roll, elbow, roll - elbow - heading], axis=-1)


def _link_lengths(table: DhTable) -> tuple[float, float, float]:
    """Upper arm, forearm and hand [m]; ValueError unless the table has the geometry."""
    rows = [*table.joints, table.tool]
    right = np.pi / 2
    angles = [(right, -right), (-right, 0.0), (2 * right, 0.0), (0.0, 0.0), (0.0, 0.0)]
    if not (
        table.convention == "craig"
        and len(rows) == len(angles)
        and np.allclose([(row.alpha, row.theta) for row in rows], angles, rtol=0, atol=1e-12)
        and not any((rows[0].a, rows[1].a, *(row.d for row in rows)))
    ):
        raise ValueError(f"arm {table.name!r} does not have the geometry of 'tojo4dof'")
    return rows[2].a, rows[3].a, rows[4].a
