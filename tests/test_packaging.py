"""The wheel: models inside, and usable from anywhere."""

import ast
import email
import functools
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
import yaml

import fikm_drake
from fikm_drake.kinematics.native import build as building
from fikm_drake.resources import models_dir

ROOT = Path(__file__).parents[1]

SCRIPT = """
import sys
import fikm_drake as fd
late = ("matplotlib", "hatchling", "pydrake", "fikm_drake.control")
print([name for name in late if name in sys.modules])
from fikm_drake.resources import models_dir, model_names
print(fd.__file__)
print(models_dir())
print(fd.load_arm("arm7").forward_kinematics([0.0] * 7)[:3, 3].round(12).tolist())
print(all(fd.load_scenario(name).load_arm() for name in model_names("scenarios")))
"""


ALONE = """
import importlib, pkgutil, sys
import fikm_drake
found = pkgutil.walk_packages(fikm_drake.__path__, "fikm_drake.")
names = [m.name for m in found if not m.name.endswith(("_kernel", "__main__"))]
failed = []
for name in names:
    for loaded in [loaded for loaded in sys.modules if loaded.startswith("fikm_drake")]:
        del sys.modules[loaded]
    try:
        importlib.import_module(name)
    except ImportError as error:
        failed.append((name, str(error)))
print(failed)
assert len(names) > 200
"""


@pytest.fixture(scope="module")
def unzipped(tmp_path_factory):
    """The wheel's files; hatchling is installed, so that nothing is downloaded."""
    folder = tmp_path_factory.mktemp("wheel")
    wheel = built_wheel(folder)
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "unzipped")
        kernel = "fikm_drake/kinematics/native/_kernel.so" in archive.namelist()
    # With a compiler the kernel is in it, and the wheel is of this platform.
    assert wheel.name.startswith(f"fikm_drake-{fikm_drake.__version__}-py3-none-")
    assert (
        kernel == (not wheel.name.endswith("-none-any.whl")) == (building._compiler() is not None)
    )
    return folder / "unzipped"


def built_wheel(folder, **environment):
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    command += ["--no-index", "--quiet", "--wheel-dir", str(folder), str(ROOT)]
    environment = {**os.environ, "FIKM_DRAKE_NATIVE": "", **environment}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    (wheel,) = folder.glob("*.whl")
    return wheel


def test_without_the_native_kernel_the_wheel_is_a_pure_one(tmp_path):
    wheel = built_wheel(tmp_path, FIKM_DRAKE_NATIVE="0")
    assert wheel.name == f"fikm_drake-{fikm_drake.__version__}-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert not [name for name in names if "_kernel" in name]
    assert "fikm_drake/kinematics/native/kernel.c" in names


def test_wheel_holds_models_types_and_license_and_nothing_else(unzipped):
    assert (unzipped / "fikm_drake" / "py.typed").is_file()
    ours = sorted(path.relative_to(models_dir()) for path in models_dir().rglob("*"))
    models = unzipped / "fikm_drake" / "models"
    assert sorted(path.relative_to(models) for path in models.rglob("*")) == ours
    assert len(ours) > 15
    assert list(unzipped.glob("*.dist-info/licenses/LICENSE"))
    tops = {path.name.removesuffix(".dist-info") for path in unzipped.iterdir()}
    assert tops == {"fikm_drake", f"fikm_drake-{fikm_drake.__version__}"}


def test_wheel_holds_the_templates_of_the_c_export(unzipped):
    templates = Path(fikm_drake.__file__).parent / "fuzzy" / "integer" / "templates"
    names = {path.name for path in templates.iterdir()}
    packed = unzipped / templates.relative_to(Path(fikm_drake.__file__).parents[1])
    assert {path.name for path in packed.iterdir()} == names and len(names) == 5


def test_metadata_asks_for_drake_and_numpy_only(unzipped):
    (metadata,) = unzipped.glob("*.dist-info/METADATA")
    required = re.findall(r"^Requires-Dist: (.*)$", metadata.read_text("utf-8"), re.MULTILINE)
    assert [line for line in required if "extra ==" not in line] == ["drake", "numpy"]
    assert {line.split("'")[1] for line in required if "extra ==" in line} == {
        "cluster",
        "docs",
        "notebooks",
        "peers",
        "test",
    }
    (entry_points,) = unzipped.glob("*.dist-info/entry_points.txt")
    assert "fikm-drake = fikm_drake.cli:main" in entry_points.read_text("utf-8")


def test_metadata_is_fit_to_be_published(unzipped):
    (path,) = unzipped.glob("*.dist-info/METADATA")
    metadata = email.message_from_string(path.read_text("utf-8"))
    # None is better than one that leads nowhere; see "Before publishing" in CONTRIBUTING.
    urls = dict(line.split(", ") for line in metadata.get_all("Project-URL", []))
    assert not [url for url in urls.values() if not url.startswith("https://") or ".invalid" in url]
    if urls:
        assert {"Homepage", "Documentation", "Changelog", "Issues", "Source"} <= set(urls)
    minors = [line.rsplit(" ", 1)[1] for line in metadata.get_all("Classifier") if "3." in line]
    assert metadata["Requires-Python"] == f">={minors[0]}"
    assert f"{sys.version_info.major}.{sys.version_info.minor}" in minors
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert len(metadata["Keywords"].split(",")) > 5


def test_sdist_holds_the_project_and_builds_the_same_wheel(tmp_path, unzipped):
    hatch = [sys.executable, "-m", "hatchling", "build"]
    run = functools.partial(subprocess.run, check=True, capture_output=True, timeout=300)
    run([*hatch, "-t", "sdist", "-d", str(tmp_path)], cwd=ROOT)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as tar:
        tar.extractall(tmp_path, filter="data")
    (source,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert source.name == f"fikm_drake-{fikm_drake.__version__}"
    tops = {path.name for path in source.iterdir()}
    assert {"CITATION.cff", "LICENSE", "README.md", "fikm_drake", "models", "tests"} <= tops
    assert not {".ci", ".venv", "dist"} & tops
    run([*hatch, "-t", "wheel", "-d", str(tmp_path / "again")], cwd=source)
    (wheel,) = (tmp_path / "again").glob("*.whl")
    with zipfile.ZipFile(wheel) as again:
        packed = {name for name in again.namelist() if not name.endswith("/")}
    files = (path for path in unzipped.rglob("*") if path.is_file())
    assert packed == {path.relative_to(unzipped).as_posix() for path in files}


def test_citation_is_of_this_version_and_names_five_papers():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["version"] == fikm_drake.__version__
    assert citation["license"] == "BSD-3-Clause" and citation["authors"] and citation["message"]
    assert len(citation["references"]) == 5
    for paper in citation["references"]:
        assert paper["type"] and paper["title"] and paper["authors"]
        for name in paper["notes"].split(", "):
            assert hasattr(fikm_drake, name.removeprefix("fd."))


def test_unzipped_wheel_finds_its_models_from_anywhere(unzipped, tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(unzipped)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    late, package, models, home, scenarios = done.stdout.splitlines()
    assert late == "[]"  # what takes long to load, and few need
    assert Path(package).is_relative_to(unzipped)
    assert Path(models) == unzipped / "fikm_drake" / "models"
    assert home == "[0.2, -0.6, 0.6]"
    assert scenarios == "True"


def test_changelog_tells_of_this_version():
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    assert f"## [{fikm_drake.__version__}]" in changelog


def test_public_names_exist_and_others_do_not():
    assert len(fikm_drake.__all__) > 150 and set(fikm_drake.__all__) <= set(dir(fikm_drake))
    for name in fikm_drake.__all__:
        assert hasattr(fikm_drake, name)
    assert fikm_drake.control.status.ControllerStatus is fikm_drake.ControllerStatus
    with pytest.raises(AttributeError, match="module 'fikm_drake' has no attribute 'solve_bach'"):
        fikm_drake.__getattr__("solve_bach")
    with pytest.raises(ImportError):
        from fikm_drake import nothing  # noqa: F401


def test_types_of_public_names_are_told_by_the_stub():
    tree = ast.parse((ROOT / "fikm_drake" / "__init__.pyi").read_text("utf-8"))
    imported = [a.name for n in tree.body if isinstance(n, ast.ImportFrom) for a in n.names]
    (exported,) = (ast.literal_eval(n.value) for n in tree.body if isinstance(n, ast.Assign))
    assert sorted(imported) == sorted(exported) == fikm_drake.__all__


def test_every_module_can_be_the_first_that_is_imported():
    done = subprocess.run(
        [sys.executable, "-c", ALONE], capture_output=True, text=True, timeout=300
    )
    assert (done.stdout, done.returncode) == ("[]\n", 0), done.stderr
