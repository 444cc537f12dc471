"""Joint 1 in the posture that is closest to mid-range, learned: the thesis's third ANFIS."""

from collections.abc import Callable

from fikm_drake.experiments.reproduce.anfis.region import ARM
from fikm_drake.experiments.reproduce.anfis.samples import exact
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import find_model
from fikm_drake.solvers.redundancy.train_bounds import train_on_workspace

FILE = "hassantabar3r_static"


def train_static(progress: Callable[[float], None] | None = None) -> Anfis:
    """Learn it from distance and angle."""
    return train_on_workspace(
        load_arm(ARM), lambda points: exact(points)["static"], "theta_1_static", progress=progress
    )


def load_static() -> Anfis:
    """The ANFIS that comes with the library, written by `fikm-drake train static`."""
    return Anfis.load(find_model(FILE, folder="learned", kind="learned model"))
