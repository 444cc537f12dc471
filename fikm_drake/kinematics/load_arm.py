"""Arms from YAML files."""

from pathlib import Path

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.resources import load_model


def load_arm(name_or_path: str | Path) -> DhArm:
    """Load an arm by the name of one of our models or from a YAML file of your own.

    Args:
        name_or_path: such as `arm7`, or a path that ends in .yaml; `fikm-drake models` lists ours.

    Raises:
        FileNotFoundError: there is no such file; the message lists our models.
        ValueError: the file does not describe an arm; the message says what is wrong.
    """
    return DhArm(load_model(DhTable, name_or_path, kind="arm"))
