"""Mamdani systems from YAML files."""

from pathlib import Path

from fikm_drake.fuzzy.mamdani.mamdani_config import MamdaniConfig
from fikm_drake.fuzzy.mamdani.mamdani_system import MamdaniSystem
from fikm_drake.resources import load_model


def load_mamdani(name_or_path: str | Path) -> MamdaniSystem:
    """Load a Mamdani system by the name of one of ours or from a YAML file of your own.

    Args:
        name_or_path: such as `labvolt_theta3`, or a path that ends in .yaml.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file does not describe a Mamdani system; the message says what is wrong.
    """
    config = load_model(MamdaniConfig, name_or_path, folder="fuzzy", kind="fuzzy system")
    return MamdaniSystem(config)
