"""Every equation, table, figure, algorithm and claim of the five papers: what, where, what runs it.

`catalogue.txt` has a line each: names | what | object in `fikm_drake` that holds it | part of `reproduce`
that shows it. Names of tables, figures and algorithms are keys of `fikm-drake reproduce` too. A test looks
up every object and every part, and that no number is left out.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

KEYS = ("table", "figure", "algorithm")
"""What a name begins with that is a key."""


@dataclass(frozen=True)
class Item:
    """One thing of a paper."""

    names: tuple[str, ...]
    """Such as `figure 14`."""
    what: str
    """In a few words."""
    where: str
    """Module and object inside `fikm_drake`, such as `laws.fuzzy_mapping:FuzzyMapping`."""
    part: str
    """Key of the experiment that shows it."""


@cache
def catalogue() -> dict[str, list[Item]]:
    """The items of each paper, in its order."""
    found: dict[str, list[Item]] = {}
    for line in Path(__file__).with_suffix(".txt").read_text("utf-8").splitlines():
        if line.startswith("["):
            items = found[line.strip("[]")] = []
        elif line and not line.startswith("#"):
            names, what, where, part = line.split(" | ")
            items.append(Item(tuple(names.split(", ")), what, where, part))
    return found


def aliases(paper: str) -> dict[str, str]:
    """Tables, figures and algorithms of a paper to the key of the experiment that shows them."""
    return {
        name: item.part
        for item in catalogue()[paper]
        for name in item.names
        if name.split()[0] in KEYS
    }
