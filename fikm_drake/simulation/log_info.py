"""What a log says of itself, beside its numbers."""

import dataclasses
import json
import platform
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from importlib.metadata import PackageNotFoundError, version

FORMAT = "fikm_drake.RunLog/2"
RESERVED = ("time", "info")
"""Names that no series can have."""


@dataclass
class LogInfo:
    """The head of a log: what was run, with what, and what its columns are."""

    columns: dict[str, list[str]]
    """The series by name, each with the names of its columns, the unit at the end, such as `q_1_rad`."""
    scenario: str = ""
    """The scenario as YAML, its arm inside; empty for a Diagram of the user's own."""
    law: str = ""
    """The law as it was; empty for none."""
    names: dict[str, dict[str, str]] = field(default_factory=dict)
    """Series of whole numbers that have names, such as `status`: each number, as text, to its name."""
    versions: dict[str, str] = field(default_factory=dict)
    """Versions of fikm_drake, drake, numpy, Python and the platform; see `versions`."""
    skipped: dict[str, str] = field(default_factory=dict)
    """Ports that could not be read, and why."""
    ended: str = ""
    """Why the run ended early; empty for a whole run."""

    @property
    def width(self) -> int:
        """Columns of all series together."""
        return sum(map(len, self.columns.values()))

    def to_json(self) -> bytes:
        """As one line of JSON."""
        data = {"format": FORMAT, **dataclasses.asdict(self)}
        return json.dumps(data, ensure_ascii=False).encode("utf-8")

    @classmethod
    def from_json(cls, data: bytes) -> "LogInfo":
        """What `to_json` wrote.

        Raises:
            ValueError: it is something else.
        """
        try:
            found = json.loads(data)
        except (ValueError, RecursionError) as error:
            raise ValueError(f"its head is not JSON: {error}") from error
        if not isinstance(found, dict) or found.pop("format", None) != FORMAT:
            raise ValueError(f"its format is not {FORMAT!r}")
        known = {item.name for item in dataclasses.fields(cls)}
        if unknown := sorted(set(found) - known) or "columns" not in found:
            raise ValueError(f"its head has no columns, or unknown entries: {unknown}")
        info = cls(**found)
        info.validate()
        return info

    def validate(self) -> None:
        """Raise ValueError, naming the bad entry."""
        for name in ("scenario", "law", "ended"):
            if not isinstance(getattr(self, name), str):
                raise ValueError(f"{name} must be a text, got {getattr(self, name)!r}")
        for name in ("versions", "skipped"):
            if not _is_map(getattr(self, name), str):
                raise ValueError(f"{name} must be texts by name, got {getattr(self, name)!r}")
        if not _is_map(self.names, dict) or not all(_is_map(m, str) for m in self.names.values()):
            raise ValueError(f"names must be maps of numbers to texts, got {self.names!r}")
        if not _is_map(self.columns, list):
            raise ValueError(f"columns must be lists by name, got {self.columns!r}")
        labels = [label for columns in self.columns.values() for label in columns]
        if not all(isinstance(label, str) for label in labels):
            raise ValueError("the names of columns must be texts")
        twice = sorted({label for label in labels if labels.count(label) > 1})[:3]
        bad = twice + [name for name in RESERVED if name in self.columns]
        if bad or not all(self.columns.values()):
            raise ValueError(f"columns must be there once, and none be called {RESERVED}: {bad}")


def versions() -> dict[str, str]:
    """Of what this process computes with."""
    found = {"python": sys.version.split()[0], "platform": platform.platform()}
    for name in ("fikm_drake", "drake", "numpy"):
        try:
            found[name] = version(name.replace("_", "-"))
        except PackageNotFoundError:  # a checkout that is not installed
            found[name] = getattr(sys.modules.get(name), "__version__", "unknown")
    return found


def names_of(enum: type[IntEnum]) -> dict[str, str]:
    """The names of an enum's values, for `LogInfo.names`."""
    return {str(int(value)): value.name for value in enum}


def _is_map(value: object, kind: type) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(key, str) and isinstance(item, kind) for key, item in value.items()
    )
