"""Feasible intervals at many points, on one machine or many."""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.checks import check_counts, check_joint
from fikm_drake.executors import completed
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.solvers.self_motion.feasibility_data import (
    FeasibilityData,
    empty_data,
    feasibility_rows,
)
from fikm_drake.solvers.self_motion.spare_task import SpareTask

BETWEEN_SAVES = 10.0
"""Seconds."""
CHUNKS = {True: 20_000, False: 50}
"""Points that a worker takes at once: in closed form, or traced."""


def generate_feasibility_data(
    arm: DhArm,
    points: ArrayLike,
    executor: Executor | None = None,
    *,
    task: str | None = None,
    joint: int = 0,
    file: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
    chunk: int | None = None,
) -> FeasibilityData:
    """Feasible intervals of a joint, and the posture closest to mid-range, at many points.

        with ProcessPoolExecutor() as executor:
            data = fd.generate_feasibility_data(arm, points, executor, file="training.npz")

    Args:
        arm: the arm.
        points: (N,2) of a planar 3R arm [m]; with a task: its targets, (N,m) [m] or poses (N,4,4).
        executor: of any kind, such as ProcessPoolExecutor or Dask's; None: this process.
        task: None: a planar 3R arm in closed form. Else self-motions of any arm are traced for this
            task, which must leave one degree of freedom.
        joint: whose interval it is, from 0; the first in closed form.
        file: where the data are kept (.npz), every 10 s and at the end. What it holds already of the
            same points is not computed again, so a run that was stopped goes on where it was.
        progress: called after each chunk with the fraction done.
        chunk: points that a worker takes at once; None: 20,000 in closed form, 50 traced.

    Raises:
        ValueError: naming the bad value and the valid ones; `file` holds data of another job.
    """
    source = _checked_source(arm, task, joint)
    data = _started(arm, points, source, file)
    if chunk is not None:
        check_counts(chunk=chunk)
    missing = np.flatnonzero(data.count < 0)
    size = chunk or CHUNKS[task is None]
    chunks = [missing[start : start + size] for start in range(0, missing.size, size)]
    saved = time.monotonic()
    try:
        work = [(arm, data.points[rows], task, joint) for rows in chunks]
        for number, found in completed(executor, feasibility_rows, work):
            rows = chunks[number]
            data.count[rows], data.closest[rows] = found.count, found.closest
            data.lower[rows], data.upper[rows] = found.lower, found.upper
            if progress:
                progress(float(np.mean(data.count >= 0)))
            if file and time.monotonic() - saved > BETWEEN_SAVES:
                data.save(file)
                saved = time.monotonic()
    finally:
        if file:
            data.save(file)
    return data


def _checked_source(arm: DhArm, task: str | None, joint: int) -> str:
    if task is None:
        Planar3R(arm)
        if joint != 0:
            raise ValueError(f"joint must be 0 without a task, got {joint!r}")
    else:
        SpareTask(arm, task)
        check_joint(joint, arm.num_joints)
    return f"{arm.table!r}, task {task}, joint{joint + 1}"


def _started(
    arm: DhArm, points: ArrayLike, source: str, file: str | Path | None
) -> FeasibilityData:
    """The data as far as the file has them."""
    data = empty_data(arm, points, source)
    shape = data.points.shape
    if len(shape) not in (2, 3) or not np.isfinite(data.points).all():
        raise ValueError(f"points must be finite, (N, m) or (N, 4, 4), got shape {shape}")
    if file is None or not Path(file).is_file():
        return data
    before = FeasibilityData.load(file)
    if before.source != source or not np.array_equal(before.points, data.points):
        raise ValueError(f"{file} holds data of another arm, task, joint or other points")
    return before
