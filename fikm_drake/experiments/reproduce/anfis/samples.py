"""What is learned of the thesis's arm, and fresh points to test it on."""

from collections.abc import Callable
from functools import cache

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.region import ARM
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import find_model
from fikm_drake.solvers.redundancy.train_bounds import train_on_workspace
from fikm_drake.solvers.redundancy.workspace_points import (
    random_workspace_points,
    workspace_points,
)
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table

TRAINING_POINTS = 3356
"""As many as the thesis's, about."""
FRESH_POINTS, SEED = 20_000, 1
VALIDATION_POINTS, VALIDATION_SEED = 2000, 0
QUANTITIES = ("upper", "lower", "static")
"""Quantities of joint 1: its bounds, and its position in the posture that is closest to mid-range."""


@cache
def training_points() -> Array:
    """(N,2) a grid over the workspace [m]; the thesis's own grid, in three areas, is not given."""
    return workspace_points(load_arm(ARM), TRAINING_POINTS)


@cache
def edged_training_points() -> Array:
    """(N,2) as many, some of them on the edge of the workspace [m]."""
    return workspace_points(load_arm(ARM), TRAINING_POINTS, edge=True)


@cache
def validation_points() -> Array:
    """(2000,2) random, uniform over the workspace; they choose the best epoch [m]."""
    return random_workspace_points(load_arm(ARM), VALIDATION_POINTS, VALIDATION_SEED)


@cache
def fresh_points() -> Array:
    """(20000,2) random, uniform over the workspace [m]."""
    return random_workspace_points(load_arm(ARM), FRESH_POINTS, SEED)


def exact(points: Array) -> dict[str, Array]:
    """The quantities (N,) at points (N,2), exact [rad]."""
    arm = load_arm(ARM)
    lower, upper = feasible_interval_table(arm, points).widest()
    return {"upper": upper, "lower": lower, "static": closest_to_mid_range(arm, points)[:, 0]}


@cache
def fresh_values() -> dict[str, Array]:
    """The quantities at the fresh points, exact [rad]."""
    return exact(fresh_points())


def rms_and_max(error: Array) -> tuple[float, float]:
    """Root mean square and largest absolute error."""
    return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())


FILE = "hassantabar3r_static"


def train_static(progress: Callable[[float], None] | None = None) -> Anfis:
    """Learn it from distance and angle."""
    return train_on_workspace(
        load_arm(ARM), lambda points: exact(points)["static"], "theta_1_static", progress=progress
    )


def load_static() -> Anfis:
    """The ANFIS that comes with the library, written by `fikm-drake train static`."""
    return Anfis.load(find_model(FILE, folder="learned", kind="learned model"))
