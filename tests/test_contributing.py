"""The recipes of CONTRIBUTING.md, carried out on a copy of the tree as they stand there."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
RECIPES = dict(re.findall(r"^## (A new [^\n]*)\n(.*?)(?=^## |\Z)", TEXT, flags=re.M | re.S))
BLOCKS = {
    name: re.findall(r"^```(\w+)\n(.*?)^```", text, flags=re.M | re.S)
    for name, text in RECIPES.items()
}


@pytest.fixture
def tree(tmp_path):
    """A copy of what the recipes touch."""
    for folder in ("fikm_drake", "models"):
        skip = shutil.ignore_patterns("__pycache__", "*.so")
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=skip)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def change(tree, block):
    """Carry out a diff: a line @@ divides the places, a line with neither - nor + stays."""
    path, _, hunks = block.partition("\n")
    file = tree / path.removeprefix("# ")
    text = file.read_text("utf-8")
    for hunk in hunks.split("@@\n"):
        lines = hunk.splitlines()
        old = "\n".join(line[1:] for line in lines if line[0] in " -")
        new = "\n".join(line[1:] for line in lines if line[0] in " +")
        assert text.count(old) == 1, f"{old!r} must stand once in {file}"
        text = text.replace(old, new)
    file.write_text(text, "utf-8")


DRIVER = """
import runpy, shlex, sys
for command in sys.argv[1:]:
    print("$", command, flush=True)
    program, *words = shlex.split(command)
    if program == "fikm-drake":
        from fikm_drake.cli import main
        code = main(words)
    elif words[:2] == ["-m", "pytest"]:
        import pytest
        code = pytest.main(["-p", "no:cacheprovider", *words[2:]])
    else:
        code = 0 if runpy.run_path(words[0]) else 1
    if code:
        sys.exit(f"{command}: {code}")
"""
"""Runs a recipe's commands in one process, since the imports take most of the time."""


@pytest.mark.parametrize("name", RECIPES)
def test_recipe(name, tree):
    commands = []
    for language, block in BLOCKS[name]:
        if language == "diff":
            change(tree, block)
        elif language == "sh":
            commands += block.splitlines()
        else:
            path = tree / block.partition("\n")[0].removeprefix("# ")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.partition("\n")[2], "utf-8")
    assert commands
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", DRIVER, *commands],
        cwd=tree,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    # Every run of a scenario ends where it should.
    ends = re.findall(r"e_ss ([\d.]+) cm", done.stdout)
    assert len(ends) == sum(" run " in command for command in commands)
    assert all(float(error) < 0.1 for error in ends)


def test_there_are_four_recipes_and_the_rooms_are_those_of_the_package():
    assert len(RECIPES) == 4 and all(BLOCKS.values())
    table = TEXT.partition("## A new")[0]
    for folder in (path for path in (ROOT / "fikm_drake").iterdir() if path.is_dir()):
        if (folder / "__init__.py").exists():
            assert f"| `{folder.name}/`" in table
