"""Tables of targets over time."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
import csv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.trajectories import PiecewisePolynomial, PiecewiseQuaternionSlerp, Trajectory

from fikm_drake.checks import check_not_negative
from fikm_drake.simulation.scenario.motion import Motion, rotation_at

TABLES = {
    ("x_m", "y_m"): 2,
    ("x_m", "y_m", "z_m"): 3,
    ("qw", "qx", "qy", "qz", "x_m", "y_m", "z_m"): 7,
}
"""Columns of a target's table, after `time_s`, and how many numbers a target has."""


@dataclass
class Samples:
    """A table of targets over time.

    Attributes:
        times: increasing [s]; the first is 0.
        values: a row a time: (x, y) or (x, y, z) [m], or quaternion w, x, y, z and position [m].
        interpolation: `linear` between rows, or `hold` the last row.
        hold: at the end [s].
    """

    times: list[float] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)
    interpolation: str = "linear"
    hold: float = 0.4

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        times = np.array(self.times, dtype=float)
        if not len(times) or times[0] != 0.0 or not np.isfinite(times).all():
            raise ValueError(f"times must be finite and start at 0 [s], got {self.times[:3]} …")
        if not (np.diff(times) > 0.0).all():
            raise ValueError("times must increase [s]")
        try:
            values = np.array(self.values, dtype=float)
        except (TypeError, ValueError) as error:
            raise ValueError("values must be rows of one length") from error
        if values.ndim != 2 or len(values) != len(times) or values.shape[1] not in (2, 3, 7):
            raise ValueError(
                f"values must be {len(times)} rows of 2, 3 or 7 numbers, got {values.shape}"
            )
        if not np.isfinite(values).all():
            raise ValueError("values must be finite")
        if values.shape[1] == 7 and not (np.linalg.norm(values[:, :4], axis=1) > 0.0).all():
            raise ValueError("values have a quaternion of length 0")
        if self.interpolation not in ("linear", "hold"):
            raise ValueError(f"interpolation must be linear or hold, got {self.interpolation!r}")
        check_not_negative("hold", self.hold)

    @property
    def duration(self) -> float:
        """Until the last row [s]."""
        return self.times[-1]

    def motion(self) -> Motion:
        """The target over time."""
        times, values = np.array(self.times), np.array(self.values)
        points = values[:, -3:] if values.shape[1] == 7 else values
        rotations = [
            RotationMatrix(Quaternion(v[:4] / np.linalg.norm(v[:4])))
            for v in (values if values.shape[1] == 7 else [])
        ]
        if len(times) == 1 or self.interpolation == "hold":

            def row(t: float) -> int:
                return max(int(np.searchsorted(times, t + 1e-9 * max(1.0, t), side="right")) - 1, 0)

            turn = (lambda t: rotations[row(t)]) if rotations else None
            return Motion(values.shape[1], times[-1], lambda t: points[row(t)], turn, points)
        path = PiecewisePolynomial.FirstOrderHold(times, points.T)
        turn = None
        if rotations:
            slerp = PiecewiseQuaternionSlerp(times, rotations)
            turn = lambda t: rotation_at(slerp, min(t, times[-1]))  # noqa: E731
        end = times[-1]
        return Motion(values.shape[1], end, lambda t: path.value(min(t, end))[:, 0], turn, points)

    @classmethod
    def of_trajectory(cls, trajectory: Trajectory, *, rate: float, hold: float = 0.4) -> "Samples":
        """A Drake Trajectory as a table, exact at the control cycles of a rate.

        Args:
            trajectory: 2 or 3 rows [m], 7 (quaternion w, x, y, z and position), or of poses (4 x 4).
            rate: of the control cycle [Hz].
            hold: at the end [s].

        Raises:
            ValueError: it has another shape, or does not start at 0.
        """
        shape = (trajectory.rows(), trajectory.cols())
        if shape not in ((2, 1), (3, 1), (7, 1), (4, 4)) or trajectory.start_time() != 0.0:
            raise ValueError(
                "a trajectory must start at 0 s and have 2, 3 or 7 rows, or be of poses, "
                f"got {shape} from {trajectory.start_time()} s"
            )
        count = round(trajectory.end_time() * rate)
        times = [k / rate for k in range(count + 1)]
        values = [trajectory.value(min(t, trajectory.end_time())) for t in times]
        rows = [_pose_row(v) if shape == (4, 4) else v[:, 0].tolist() for v in values]
        return cls(times, rows, hold=hold)


@dataclass
class Csv:
    """A table of targets in a file: `time_s`, then x_m, y_m, or z_m too, or qw, qx, qy, qz before them.

    Attributes:
        file: path of the .csv file; relative to the scenario's own.
        interpolation: `linear` between rows, or `hold` the last row.
        hold: at the end [s].
    """

    file: str = ""
    interpolation: str = "linear"
    hold: float = 0.4

    def samples(self) -> Samples:
        """The table.

        Raises:
            FileNotFoundError: there is no such file.
            ValueError: it is no such table; the message names the line.
        """
        if not Path(self.file).is_file():
            raise FileNotFoundError(f"no table {self.file!r}")
        with open(self.file, newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file) if Path(self.file).stat().st_size else [[]]
        names = tuple(name.strip() for name in header)
        if names[:1] != ("time_s",) or names[1:] not in TABLES:
            known = " or ".join(", ".join(("time_s", *columns)) for columns in TABLES)
            raise ValueError(f"{self.file}: columns must be {known}, got {', '.join(names)}")
        numbers = []
        for line, row in enumerate(rows, start=2):
            try:
                numbers.append([float(cell) for cell in row])
            except ValueError as error:
                raise ValueError(f"{self.file}, line {line}: {error}") from error
        times, values = [row[0] for row in numbers], [row[1:] for row in numbers]
        return Samples(times, values, interpolation=self.interpolation, hold=self.hold)

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if not self.file:
            raise ValueError("a Csv needs a file")
        self.samples().validate()

    @property
    def duration(self) -> float:
        """Until the last row [s]."""
        return self.samples().duration

    def motion(self) -> Motion:
        """The target over time."""
        return self.samples().motion()


def _pose_row(matrix: ArrayLike) -> list[float]:
    pose = RigidTransform(np.asarray(matrix))
    return [*pose.rotation().ToQuaternion().wxyz(), *pose.translation()]
