"""Targets of a path from arrays, poses, Drake trajectories and CSV files."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.trajectories import PiecewisePose, Trajectory

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts

Targets: TypeAlias = ArrayLike | Sequence[RigidTransform] | Trajectory

SAMPLES = 200
"""Targets of a trajectory by default (-)."""
COLUMNS = {
    3: "x, y, z",
    6: "x, y, z, roll, pitch, yaw",
    7: "x, y, z, qw, qx, qy, qz",
}


def path_targets(targets: Targets, *, samples: int = SAMPLES) -> Array:
    """Targets as positions (N,3) [m] or poses (N,4,4).

    Args:
        targets: positions (N,3), poses (N,4,4), RigidTransforms, or a Drake trajectory of one of these.
        samples: how many evenly spaced times of a trajectory are taken.

    Raises:
        ValueError: naming the shape.
    """
    if isinstance(targets, Trajectory):
        check_counts(2, samples=samples)
        times = np.linspace(targets.start_time(), targets.end_time(), samples)
        if isinstance(targets, PiecewisePose):
            return np.array([targets.GetPose(t).GetAsMatrix4() for t in times])
        values = np.array([targets.value(t) for t in times])
        array = values[..., 0] if values.shape[1:] == (3, 1) else values
    elif isinstance(targets, list | tuple) and any(isinstance(X, RigidTransform) for X in targets):
        array = np.array([X.GetAsMatrix4() for X in targets])
    else:
        array = np.array(targets, dtype=float)
    if len(array) < 1 or array.shape[1:] not in ((3,), (4, 4)):
        raise ValueError(
            "targets must be positions (N,3), poses (N,4,4), RigidTransforms, or a trajectory of "
            f"these, got the shape {array.shape}"
        )
    return array


def between(before: Array, after: Array, fraction: float) -> Array:
    """The target between two: straight on, and for poses about one axis."""
    if before.ndim == 1:
        return before + fraction * (after - before)
    one, two = (
        RigidTransform(RotationMatrix.ProjectToRotationMatrix(X[:3, :3]), X[:3, 3])
        for X in (before, after)
    )
    turn = (one.rotation().inverse() @ two.rotation()).ToAngleAxis()
    part = RotationMatrix(type(turn)(fraction * turn.angle(), turn.axis()))
    position = before[:3, 3] + fraction * (after[:3, 3] - before[:3, 3])
    return RigidTransform(one.rotation() @ part, position).GetAsMatrix4()


def load_path_csv(path: str | Path) -> Array:
    """Targets from a CSV file: a line each, [m, rad], a first line of names if you like.

    Columns: `x, y, z`; or `x, y, z, roll, pitch, yaw`; or `x, y, z, qw, qx, qy, qz`.

    Returns:
        Positions (N,3) or poses (N,4,4).

    Raises:
        OSError: the file cannot be read; FileNotFoundError if there is none.
        ValueError: naming the file, the line and what is wrong with it.
    """
    if not Path(path).is_file():
        raise FileNotFoundError(f"no file of targets {path}")
    rows: list[list[float]] = []
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), start=1):
        cells = [cell.strip() for cell in line.split("#")[0].replace(";", ",").split(",")]
        if cells == [""]:
            continue
        try:
            row = [float(cell) for cell in cells]
        except ValueError:
            if not rows and number == 1:
                continue  # names
            raise ValueError(f"{path}, line {number}: must be numbers, got {line!r}") from None
        if len(row) not in COLUMNS or (rows and len(row) != len(rows[0])):
            raise ValueError(
                f"{path}, line {number}: must have the columns {' or '.join(COLUMNS.values())}, the same "
                f"in every line, got {len(row)} numbers"
            )
        if not np.isfinite(row).all():
            raise ValueError(f"{path}, line {number}: must be finite, got {line!r}")
        rows.append(row)
    if not rows:
        raise ValueError(f"{path} has no targets: lines of {' or '.join(COLUMNS.values())}")
    table = np.array(rows)
    if table.shape[1] == 3:
        return table
    return np.array([_pose(path, row) for row in table])


def _pose(path: str | Path, row: Array) -> Array:
    if len(row) == 6:
        return RigidTransform(RollPitchYaw(row[3:]), row[:3]).GetAsMatrix4()
    size = float(np.linalg.norm(row[3:]))
    if not 0.5 < size < 2.0:
        raise ValueError(f"{path}: a quaternion must have the length 1, got {row[3:].tolist()}")
    return RigidTransform(Quaternion(row[3:] / size), row[:3]).GetAsMatrix4()
