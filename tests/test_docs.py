"""The documentation: its blocks run, its commands exist, the API reference builds without a warning."""

import dataclasses
import importlib.util
import inspect
import json
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

import fikm_drake as fd
from fikm_drake.cli import main
from fikm_drake.experiments.benchmarks.registry import BENCHMARKS
from fikm_drake.experiments.reproduce.papers import PAPERS

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "notebooks").glob("*.md"))]
EXAMPLES = re.findall(
    r"^```python\n(.*?)^```",
    (ROOT / "notebooks" / "examples.md").read_text("utf-8"),
    flags=re.M | re.S,
)


@pytest.mark.parametrize("code", EXAMPLES, ids=range(len(EXAMPLES)))
def test_example_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "notebooks/examples.md", "exec"), {})


def examples():
    """Code in use: pages and notebooks, which are run, doctests and the snippets of docstrings."""
    for page in PAGES:
        text = page.read_text("utf-8")
        yield from re.findall(r"```(?:python|yaml)\n.*?```|`fd\.\w+`", text, flags=re.S)
    for path in (ROOT / "notebooks").glob("*.ipynb"):
        cells = json.loads(path.read_text("utf-8"))["cells"]
        yield from ("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    for path in (ROOT / "fikm_drake").rglob("*.py"):
        text = path.read_text("utf-8")
        yield "\n".join(re.findall(r"^\s*(?:>>>|\.\.\.) .*$|^ {4,}.*\bfd\..*$", text, flags=re.M))


def test_every_public_name_has_an_example():
    used = set(re.findall(r"\w+", "\n".join(examples())))
    assert sorted(set(fd.__all__) - used) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_links_exist(page, capsys):
    text = page.read_text("utf-8")
    for name in re.findall(r"`?(?:fikm-drake )?benchmark ([a-z]+)", text):
        assert name in {*BENCHMARKS, "all"}
    for name in re.findall(r"`(?:fikm-drake )?reproduce ([a-z]+)", text):
        assert name in {*PAPERS, "all", "wall"}  # the last is the recipe's
    for link in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (page.parent / link).exists(), link
    for name in re.findall(r"`fikm-drake ([a-z-]+)", text):
        with pytest.raises(SystemExit) as stopped:
            main([name, "--help"])
        assert stopped.value.code == 0, name


@pytest.mark.skipif(not importlib.util.find_spec("pdoc"), reason="the extra docs is not installed")
def test_api_reference_builds_without_a_warning(tmp_path):
    command = [sys.executable, str(ROOT / ".ci" / "build_api.py"), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "fikm_drake.html").read_text("utf-8")
    names = [name for name in fd.__all__ if not inspect.ismodule(getattr(fd, name))]
    missing = [name for name in names if f'id="{name}"' not in page]
    assert missing == []
    assert ".. pydrake_system::" not in page


CONFIGS = (
    fd.FuzzyIkConfig,
    fd.GainSupervisorConfig,
    fd.ClearanceConfig,
    fd.CommandSupervisorConfig,
    fd.MamdaniConfig,
    fd.DhTable,
    fd.DhJoint,
    fd.Workplane,
)


@pytest.mark.parametrize("config", CONFIGS, ids=lambda config: config.__name__)
def test_help_shows_every_field_of_a_config(config):
    """Its name in the section of attributes, with a text; the default stands in the signature."""
    shown = pydoc.plain(pydoc.render_doc(config))
    attributes = shown[shown.index("Attributes:") :]
    for field in dataclasses.fields(config):
        assert re.search(rf"\b{field.name}: \S", attributes), field.name
