"""Whether the files that a scenario names are still what they were."""

import dataclasses
import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

from fikm_drake.resources import models_dir
from fikm_drake.simulation.scenario.schema import Scenario

NAMED = re.compile(r"""(?:\bfile(?:name)?\s*[:=]\s*["']?|<uri>\s*)([^\s"'<>,}]+)""")
"""A file that a model names: in directives, URDF, MJCF, SDF."""
TEXTS = (".urdf", ".sdf", ".xml", ".yaml", ".yml")


def fingerprint(scenario: Scenario) -> str:
    """A digest of all files that a scenario names, and those name in turn; empty: it names none.

    An arm's table and a target's are in the scenario itself (`Scenario.whole`); a model is a path, so are
    learned bounds and rules of one's own. Two runs of the same scenario are the same if this is.
    """
    found: dict[Path, bytes] = {}
    for text in _texts(scenario.whole()):
        if "/" in text or "." in text:
            _add(Path(text), found)
    if not found:
        return ""
    digest = hashlib.sha256()
    for path in sorted(found):
        digest.update(path.name.encode("utf-8"))
        digest.update(found[path])
    return digest.hexdigest()


def _add(path: Path, found: dict[Path, bytes]) -> None:
    """Enter a file and those that it names; what is no file is left out."""
    try:
        path = path.resolve()
        if path in found or not path.is_file():
            return
        data = path.read_bytes()
    except OSError:
        return
    found[path] = hashlib.sha256(data).digest()
    if path.suffix in TEXTS:
        for name in NAMED.findall(data.decode("utf-8", "replace")):
            for candidate in _places(name, path):
                _add(candidate, found)


def _places(name: str, path: Path) -> Iterator[Path]:
    """Where a file that another one names may be."""
    scheme, separator, rest = name.partition("://")
    if not separator:
        yield path.parent / name
    elif scheme == "file":
        yield Path(rest)
    elif scheme in ("package", "model"):
        package, _, inside = rest.partition("/")
        if package == "fikm_drake":
            yield models_dir() / inside
        yield from (folder / inside for folder in path.parents if folder.name == package)


def _texts(data: object) -> Iterator[str]:
    """All strings in options and their lists."""
    if isinstance(data, str):
        yield data
    elif dataclasses.is_dataclass(data) and not isinstance(data, type):
        for item in dataclasses.fields(data):
            yield from _texts(getattr(data, item.name))
    elif isinstance(data, list):
        for value in data:
            yield from _texts(value)
