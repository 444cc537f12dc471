"""Mamdani systems from YAML files."""

from pathlib import Path

from fikm_drake.fuzzy.mamdani.mamdani_config import MamdaniConfig
from fikm_drake.fuzzy.mamdani.mamdani_system import MamdaniSystem
from fikm_drake.resources import find_model, load_yaml


def load_mamdani(name_or_path: str | Path) -> MamdaniSystem:
    """Load a Mamdani system by the name of one of ours or from a YAML file of your own.

    Args:
        name_or_path: such as `labvolt_theta3`, or a path that ends in .yaml.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file does not describe a Mamdani system; the message says what is wrong.
    """
    path = find_model(name_or_path, folder="fuzzy", kind="fuzzy system")
    config = load_yaml(MamdaniConfig, path, kind="fuzzy system")
    try:
        return MamdaniSystem(config)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
