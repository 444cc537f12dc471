"""Imports go one way, down the layers."""

import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "fikm_drake"
LAYERS = [
    "cli",
    "experiments",
    "simulation",
    "diagrams",
    "systems",
    "solvers",
    "control",
    "laws",
    "kinematics",
    "fuzzy",
    "checks",
    "executors",
    "arrays",
    "resources",
    "yaml_errors",
    "files",
]
FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_go_down_the_layers(path):
    own = LAYERS.index(path.relative_to(PACKAGE).parts[0].removesuffix(".py"))
    imported = re.findall(r"^\s*from fikm_drake\.(\w+)", path.read_text("utf-8"), flags=re.M)
    assert all(LAYERS.index(layer) >= own for layer in imported)
    assert not re.findall(r"^\s*(?:from fikm_drake|import fikm_drake)\s", path.read_text("utf-8"))
